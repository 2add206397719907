#include "render/scene/scene_faults.h"

#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/diffuse/diffuse_scene.h"
#include "render/scene/light/light_builder.h"
#include "render/scene/light/light_values.h"
#include "render/scene/material/material_builder.h"
#include "render/scene/medium/medium_builder.h"
#include "render/scene/placement/motion.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/shape/csg.h"
#include "render/scene/shape/csg_solid.h"
#include "render/scene/shape/geometry.h"
#include "render/scene/shape/object_graph.h"
#include "render/scene/texture/mesh_attributes.h"
#include "render/scene/texture/texture_builder.h"
#include "render/scene/texture/texture_images.h"
#include "render/scene/values/located.h"
#include "render/scene/view/settings.h"
#include "render/scene/view/view.h"
#include "wire/algorithm.h"
#include "wire/algorithm_fit.h"
#include "wire/exposure.h"
#include "wire/mesh_blob.h"

namespace tessera::render {

namespace {

/// About the origin of the world where the scene's is at fault, which find_job_faults() tells.
RenderSpace space_of(const v1::Scene& scene) {
  const auto origin = render_origin(scene);
  return render_space_about(origin.ok() ? *origin : Imath::V3d(0, 0, 0));
}

/// Those of the scene, by their names.
std::unordered_map<std::string, const v1::Material*> materials_of(const v1::Scene& scene) {
  std::unordered_map<std::string, const v1::Material*> materials;
  for (const v1::Material& material : scene.materials()) materials.try_emplace(material.name(), &material);
  return materials;
}

const v1::Material* find_material(const std::unordered_map<std::string, const v1::Material*>& materials,
                                  const std::string& name) {
  const auto known = materials.find(name);
  return known == materials.end() ? nullptr : known->second;
}

class FaultFinder {
 public:
  FaultFinder(const v1::Scene& scene, const Settings& settings, const BlobSource& blobs, FaultList& faults)
      : scene_(scene),
        blobs_(blobs),
        faults_(faults),
        algorithm_(*settings.algorithm),
        space_(space_of(scene)),
        textures_(space_, images_, texture_table_, settings.texture_filter) {}

  void run() {
    faults_.add(scene_, "", SceneScale::of(scene_.units()).status());
    textures_.build(scene_.textures(), faults_);
    look_at_media();
    materials_.build(scene_.materials(), faults_);
    look_at_shapes(scene_, space_.from_world, "");
    for (const v1::Object& object : scene_.objects())
      look_at_shapes(object, Transform{}, absl::StrCat("object '", object.name(), "', "));
    look_at_instances();
    lights_.add_lights(scene_.lights(), faults_);
    if (!faults_.full()) look_at_images();
  }

 private:
  /// One after another, so that the samples of one grid are in memory at a time.
  void look_at_media() {
    media_.left_out = !algorithm_.media;
    for (int i = 0; i < scene_.media_size() && algorithm_.media && !faults_.full(); ++i) {
      const v1::Medium& medium = scene_.media(i);
      const std::string place = absl::StrCat("medium '", medium.name(), "'");
      MediumTable table;
      faults_.add(medium, place, MediumBuilder(space_, blobs_, table).add(medium));
      faults_.add(medium, place, media_.names.add(medium.name(), i));
    }
    faults_.add(scene_.camera(), "camera", media_.find(scene_.camera().medium()).status());
    for (int i = 0; i < scene_.views_size(); ++i) {
      const v1::Camera& camera = scene_.views(i);
      faults_.add(camera, absl::StrCat("view ", i + 1), media_.find(camera.medium()).status());
    }
  }

  template <class Holder>
  void look_at_shapes(const Holder& holder, const Transform& space_from_holder, const std::string& where) {
    for (int i = 0; i < holder.shapes_size() && !faults_.full(); ++i) {
      const v1::Shape& shape = holder.shapes(i);
      const std::string place = where + place_in_scene("shape", i, shape.name());
      look_at(shape, space_from_holder, place);
      look_at_references(shape, place);
      look_at_area_light(shape, place);
    }
  }

  void look_at(const v1::Shape& shape, const Transform& space_from_holder, const std::string& place) {
    const auto motion = Motion::of(shape);
    if (!faults_.add(shape, place, motion.status())) return;
    const Transform placed = space_from_holder * motion->at(0);
    if (shape.has_csg()) return look_at_combination(shape, placed, place);
    if (shape.has_mesh()) return;
    if (shape.has_curves()) {
      faults_.add(shape, place, read_curves(shape, placed, blobs_).status());
      return;
    }
    ShapeTable unused;
    ShapeRecord record;
    faults_.add(shape, place, add_geometry(shape, placed, false, blobs_, unused, record));
  }

  void look_at_combination(const v1::Shape& shape, const Transform& placed, const std::string& place) {
    const auto tree = read_csg_tree(shape.csg());
    if (!faults_.add(shape, place, tree.status())) return;
    bool sound = true;
    for (std::size_t i = 0; i < tree->solids.size(); ++i) {
      // The bounds of an implicit surface, which stand before it, are no shape of the scene.
      const std::int32_t operand = tree->solids[i].operand;
      const bool bounds = i + 1 < tree->solids.size() && tree->solids[i + 1].operand == operand;
      const v1::Shape& message = *tree->solids[bounds ? i + 1 : i].shape;
      const std::string where = absl::StrCat(place, ", ", place_in_scene("operand", operand, message.name()));
      const auto read = read_csg_operand(*tree->solids[i].shape, blobs_);
      sound &= faults_.add(message, where, read.status());
      if (!bounds) look_at_references(message, where);
      if (!read.ok() || !message.has_mesh()) continue;
      sound &= faults_.add(message, where,
                           closed_mesh_of(message.mesh(), read->combination_from_object, blobs_).status());
    }
    if (!sound) return;
    ShapeTable unused;
    ShapeRecord record;
    std::vector<ShapeRecord> solids;
    faults_.add(shape, place, add_csg(shape, *tree, placed, blobs_, unused, record, solids).status());
  }

  /// Looks at names in a shape, and at what its textures need.
  void look_at_references(const v1::Shape& shape, const std::string& place) {
    faults_.add(shape, place, materials_.names().find(shape.material()).status());
    faults_.add(shape, place, media_.find(shape.interior_medium()).status());
    faults_.add(shape, place, media_.find(shape.exterior_medium()).status());
    if (wire::is_nothing(shape, find_material(named_materials_, shape.material()))) return;
    if (shape.alpha().has_texture())
      faults_.add(shape, place, textures_.exact_node(shape.alpha().texture()).status());
    if (shape.has_mesh()) faults_.add(shape, place, attributes_.check(shape.mesh()));
  }

  void look_at_area_light(const v1::Shape& shape, const std::string& place) {
    if (!shape.has_area_light()) return;
    if (const char* const dark = kind_without_light(shape); dark != nullptr) {
      faults_.add(shape, place, absl::InvalidArgumentError(absl::StrCat(dark, " cannot emit light")));
    } else if (!shape.has_curves()) {  // their lights are left out
      faults_.add(shape, place, lights_.check_area_light(shape.area_light()));
    }
  }

  void look_at_instances() {
    NameTable names{"object"};
    for (int i = 0; i < scene_.objects_size(); ++i) {
      const v1::Object& object = scene_.objects(i);
      faults_.add(object, absl::StrCat("object '", object.name(), "'"), names.add(object.name(), i));
      look_at_motions(object, absl::StrCat("object '", object.name(), "', "));
    }
    look_at_motions(scene_, "", plain_objects());
    std::vector<int> placed;
    faults_.add(scene_, "", append_held(scene_, names, "", placed));
    static_cast<void>(ObjectGraph::of(scene_.objects(), names, faults_));
  }

  template <class Holder>
  void look_at_motions(const Holder& holder, const std::string& where,
                       const std::set<std::string_view>& plain = {}) {
    for (int i = 0; i < holder.instances_size() && !faults_.full(); ++i) {
      const v1::Instance& instance = holder.instances(i);
      const auto motion = Motion::of(instance);
      absl::Status status = motion.status();
      if (motion.ok() && where.empty() && plain.contains(instance.object()))
        status = check_scale(motion->at(0));
      if (!status.ok())
        faults_.add(instance, where + place_in_scene("instance", i, instance.object()), status);
    }
  }

  /// Names of objects that hold no others, and of which a part is where an instance has it, but for a
  /// translation.
  std::set<std::string_view> plain_objects() const {
    std::set<std::string_view> plain;
    for (const v1::Object& object : scene_.objects()) {
      const auto stays = [&](const v1::Shape& shape) {
        return shape.world_from_object_end().elements().empty() && shape.motion().empty() &&
               !shape.has_half_space() &&
               !wire::is_nothing(shape, find_material(named_materials_, shape.material()));
      };
      if (object.instances().empty() && !object.has_packed_instances() &&
          std::ranges::any_of(object.shapes(), stays))
        plain.insert(object.name());
    }
    return plain;
  }

  static absl::Status check_scale(Transform placed) {
    placed.m[3] = placed.m[7] = placed.m[11] = 0;
    Transform back;
    if (!placed.invert(back)) return absl::OkStatus();  // left out
    return fits_floats(placed, back) ? absl::OkStatus() : absl::InvalidArgumentError(kBeyondFloats);
  }

  /// Looks at the files that all of this looks up, for whoever names one first.
  void look_at_images() {
    const auto refusals = images_.refusals(blobs_);
    if (refusals.empty()) return;
    std::unordered_map<const v1::ImageTexture*, std::pair<const google::protobuf::Message*, std::string>>
        owners;
    for (const v1::Texture& texture : scene_.textures())
      owners[&texture.image()] = {&texture, absl::StrCat("texture '", texture.name(), "'")};
    for (const v1::Material& material : scene_.materials()) {
      for (const v1::ImageTexture* image : {&material.normal_map(), &material.gltf().clearcoat_normal_map()})
        owners[image] = {&material, absl::StrCat("material '", material.name(), "'")};
    }
    for (const auto& [image, status] : refusals) {
      const auto& [element, place] = owners.at(image);
      faults_.add(*element, place, status);
    }
  }

  const v1::Scene& scene_;
  const BlobSource& blobs_;
  FaultList& faults_;
  const wire::AlgorithmTraits& algorithm_;
  const RenderSpace space_;
  const std::unordered_map<std::string, const v1::Material*> named_materials_ = materials_of(scene_);

  // Nobody looks at these, which the builders fill.
  std::vector<std::string> warnings_;
  TextureTable texture_table_;
  MaterialTable material_table_;
  LightTable light_table_;
  TextureImages images_;
  TextureBuilder textures_;
  MediumNames media_;
  MaterialBuilder materials_{textures_, material_table_, warnings_, false};
  MeshAttributes attributes_{textures_.attribute_names(), blobs_, texture_table_};
  LightBuilder lights_{{.space = space_,
                        .blobs = blobs_,
                        .algorithm = algorithm_,
                        .textures = textures_,
                        .headers_alone = true,
                        .scale = SceneScale::of(scene_.units()).value_or(SceneScale{})},
                       light_table_};
};

/// Counts of each object, without what its instances place, and of the world.
struct OwnCounts {
  std::vector<std::uint64_t> parts, half_spaces, triangles;
  std::uint64_t triangles_of_world = 0;
};

class Counter {
 public:
  Counter(const v1::Scene& scene, bool counts_triangles, const BlobSource& blobs)
      : scene_(scene), counts_triangles_(counts_triangles), blobs_(blobs) {}

  OwnCounts run() const {
    OwnCounts counts;
    for (const v1::Shape& shape : scene_.shapes()) counts.triangles_of_world += triangles_of(shape);
    for (const v1::Object& object : scene_.objects()) {
      std::uint64_t alone = 0, half_spaces = 0, triangles = 0;
      bool together = false;  // shapes that stand still are one part
      for (const v1::Shape& shape : object.shapes()) {
        if (is_nothing(shape)) continue;
        const bool is_alone = moves(shape) || shape.has_half_space();
        alone += is_alone;
        together |= !is_alone;
        half_spaces += shape.has_half_space();
        triangles += triangles_of(shape);
      }
      counts.parts.push_back(alone + together);
      counts.half_spaces.push_back(half_spaces);
      counts.triangles.push_back(triangles);
    }
    return counts;
  }

 private:
  bool is_nothing(const v1::Shape& shape) const {
    return wire::is_nothing(shape, find_material(named_materials_, shape.material()));
  }

  static bool moves(const v1::Shape& shape) {
    const auto motion = Motion::of(shape);
    return motion.ok() && motion->moves();
  }

  /// Triangles of the shape where an algorithm knows nothing else; 0 where they are not to be counted.
  std::uint64_t triangles_of(const v1::Shape& shape) const {
    if (!counts_triangles_ || is_nothing(shape)) return 0;
    ShapeTable unused;
    ShapeRecord record;
    if (!shape.has_mesh()) {
      const auto added = add_geometry(shape, Transform{}, true, blobs_, unused, record);
      return added.ok() ? static_cast<std::uint64_t>(record.triangle_count) : 0;
    }
    const auto bytes = blobs_(shape.mesh().blob().digest());
    if (!bytes.ok()) return 0;
    const auto mesh = wire::decode_mesh(bytes->bytes);
    return mesh.ok() ? mesh->triangle_count() : 0;
  }

  const v1::Scene& scene_;
  const bool counts_triangles_;
  const BlobSource& blobs_;
  const std::unordered_map<std::string, const v1::Material*> named_materials_ = materials_of(scene_);
};

/// Adds errors of InstanceBuilder and make_diffuse() that are of counts.
void check_counts(const v1::Scene& scene, const Settings& settings, const BlobSource& blobs,
                  FaultList& faults) {
  NameTable names{"object"};
  for (int i = 0; i < scene.objects_size(); ++i) names.add(scene.objects(i).name(), i).IgnoreError();
  const auto graph = ObjectGraph::of(scene.objects(), names);
  std::vector<int> placed;
  if (!graph.ok() || !append_held(scene, names, "", placed).ok()) return;  // told as the scene's own
  const OwnCounts own = Counter(scene, settings.algorithm->diffuse_only, blobs).run();
  faults.add(scene, "", check_flattened(*graph, own.half_spaces, placed, "half-spaces of objects"));
  faults.add(
      scene, "",
      plan_nesting(*graph, own.parts, placed, settings.asked.nesting(), wants_flat(*settings.algorithm))
          .status());
  if (!settings.algorithm->diffuse_only) return;
  constexpr std::uint64_t kMany = std::uint64_t{1} << 48;  // whose bytes are still a number
  const std::uint64_t triangles =
      std::min(kMany, own.triangles_of_world + count_flattened(*graph, own.triangles, placed));
  faults.add(scene, "", check_radiosity_memory(triangles, settings.radiosity.memory_limit));
}

}  // namespace

std::vector<SceneFault> find_scene_faults(const v1::Scene& scene, const v1::JobSpec* job,
                                          const BlobSource& blobs, std::size_t most) {
  Settings settings;
  if (job != nullptr) settings = read_settings(*job);
  // Any that sees media.
  if (job == nullptr)
    settings.algorithm = &*std::ranges::find(wire::algorithms(), true, &wire::AlgorithmTraits::media);
  FaultList faults(most);
  FaultFinder(scene, settings, blobs, faults).run();
  return faults.take();
}

std::vector<SceneFault> find_job_faults(const v1::Scene& scene, const v1::JobSpec& job,
                                        const BlobSource& blobs, std::size_t most) {
  const Settings settings = read_settings(job);
  const v1::Algorithms& algorithms = job.content().algorithms();
  FaultList faults(most);
  for (const wire::Obstacle& obstacle : wire::find_obstacles(algorithms, scene, most)) {
    faults.add(*obstacle.element, obstacle.place, absl::InvalidArgumentError(obstacle.to_string(algorithms)));
  }
  if (const auto origin = render_origin(scene); faults.add(scene.camera(), "camera", origin.status())) {
    const SceneArrays unused;
    SceneTables tables(unused);
    const RenderSpace space = render_space_about(*origin);
    set_view(scene, job, settings, space, blobs, tables, faults);
    // Faults of the film were told with the first camera.
    const bool exposure_is_sound = wire::film_exposure(scene.film(), job.view().exposure()).ok();
    for (int i = 0; i < scene.views_size(); ++i) {
      const std::string place = absl::StrCat("view ", i + 1);
      if (check_camera(scene.views(i), place, job, settings, space, blobs, faults) && exposure_is_sound)
        check_exposure(scene, scene.views(i), place, job, faults);
    }
  }
  check_counts(scene, settings, blobs, faults);
  return faults.take();
}

}  // namespace tessera::render
