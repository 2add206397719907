#include "wire/algorithm_fit.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <vector>

#include "absl/strings/str_cat.h"
#include "wire/scene_place.h"
#include "wire/scene_views.h"

namespace tessera::wire {
namespace {

constexpr char kStill[] = "wants a scene that stands still; this moves";
constexpr char kStillForOneMap[] =
    "with one map of photons for all passes wants a scene that stands still; this moves";

/// Whether two placements differ; an empty one is the identity as a start, and the start as an end.
bool differ(const v1::Matrix& start, const v1::Matrix& end) {
  if (end.elements().empty()) return false;
  static constexpr double kIdentity[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  if (start.elements().empty()) return !std::ranges::equal(end.elements(), kIdentity);
  return !std::ranges::equal(start.elements(), end.elements());
}

/// Whether a shape or instance moves while the shutter is open.
bool moves(const v1::Matrix& start, const v1::Matrix& end,
           const google::protobuf::RepeatedPtrField<v1::MotionKey>& keys) {
  const auto moves_to = [&](const v1::MotionKey& key) {
    if (!key.has_place()) return key.turn().degrees() != 0;
    const bool back = key.place().elements().empty();  // the identity
    return key.turn().degrees() != 0 || (back ? differ(key.place(), start) : differ(start, key.place()));
  };
  return differ(start, end) || std::ranges::any_of(keys, moves_to);
}

bool moves(const v1::Shape& shape) {
  return moves(shape.world_from_object(), shape.world_from_object_end(), shape.motion()) ||
         !shape.mesh().later_blobs().empty() || !shape.curves().later_points().empty();
}

/// Whether a light of any kind is elsewhere later: of each field `x_end`, `x` is the start. Keys of lights
/// without a matrix begin at the identity.
bool moves(const v1::Light& light) {
  const v1::Matrix& first_place = light.has_projection()    ? light.projection().world_from_light()
                                  : light.has_goniometric() ? light.goniometric().world_from_light()
                                                            : light.infinite().world_from_light();
  if (moves(first_place, {}, light.motion())) return true;
  const auto* const kind =
      light.GetReflection()->GetOneofFieldDescriptor(light, light.GetDescriptor()->FindOneofByName("kind"));
  if (kind == nullptr) return false;
  const google::protobuf::Message& own = light.GetReflection()->GetMessage(light, kind);
  const google::protobuf::Reflection& fields = *own.GetReflection();
  for (int i = 0; i < own.GetDescriptor()->field_count(); ++i) {
    const auto* const end = own.GetDescriptor()->field(i);
    constexpr std::string_view kEnd = "_end";
    if (!end->name().ends_with(kEnd) || !fields.HasField(own, end)) continue;
    const auto* const start =
        own.GetDescriptor()->FindFieldByName(end->name().substr(0, end->name().size() - kEnd.size()));
    const auto &first = fields.GetMessage(own, start), &last = fields.GetMessage(own, end);
    const auto* const matrix = google::protobuf::DynamicCastToGenerated<v1::Matrix>(&first);
    if (matrix == nullptr ? first.SerializeAsString() != last.SerializeAsString()
                          : differ(*matrix, *google::protobuf::DynamicCastToGenerated<v1::Matrix>(&last)))
      return true;
  }
  return false;
}

bool comes_from_infinity(const v1::Light& light) {
  return light.has_infinite() || light.has_distant() || light.has_sky();
}

/// Whether builders make triangles of the shape where an algorithm knows nothing else.
bool has_triangles(const v1::Shape& shape) {
  return shape.has_mesh() || shape.has_polygon() || shape.has_box() || shape.has_polyhedron();
}

class ObstacleFinder {
 public:
  ObstacleFinder(const v1::Algorithms& algorithms, const v1::Scene& scene, std::size_t most)
      : algorithm_(*find_algorithm(algorithms.integrator())), scene_(scene), most_(most) {
    if (!algorithm_.motion) still_ = kStill;
    if (algorithms.photon().map() == v1::PHOTON_MAP_CLASSIC) still_ = kStillForOneMap;
    lights_planes_ = algorithm_.starts_at_lights && std::ranges::any_of(scene.lights(), comes_from_infinity);
    wants_diffuse_ = algorithm_.diffuse_only && !algorithms.radiosity().ignore_non_diffuse();
    for (const v1::Material& material : scene.materials()) materials_.try_emplace(material.name(), &material);
    for (const v1::Texture& texture : scene.textures()) textures_.try_emplace(texture.name(), &texture);
  }

  std::vector<Obstacle> run() {
    for (int i = 0; i < scene_.lights_size() && algorithm_.starts_at_lights; ++i) {
      const v1::Light& light = scene_.lights(i);
      if (light.infinite().portal_size() > 0)
        add(light, place_in_scene("light", i, light.name()), "cannot begin at a portal");
    }
    for (int i = 0; i < scene_.lights_size() && still_; ++i) {
      if (moves(scene_.lights(i)))
        add(scene_.lights(i), place_in_scene("light", i, scene_.lights(i).name()), still_);
    }
    if (!still_ && !algorithm_.starts_at_lights && !algorithm_.diffuse_only) return std::move(found_);
    look_into(scene_, "");
    const std::set<std::string_view> placed = placed_objects();
    for (const v1::Object& object : scene_.objects()) {
      if (placed.contains(object.name())) look_into(object, absl::StrCat("object '", object.name(), "', "));
    }
    return std::move(found_);
  }

 private:
  bool full() const { return found_.size() >= most_; }

  void add(const google::protobuf::Message& element, std::string place, const char* reason) {
    if (!full()) found_.push_back({&element, std::move(place), reason});
  }

  /// Looks at the shapes and instances of the scene, or of an object.
  template <class Holder>
  void look_into(const Holder& holder, const std::string& where) {
    for (int i = 0; i < holder.shapes_size() && !full(); ++i) {
      const v1::Shape& shape = holder.shapes(i);
      if (is_nothing(shape, material_of(shape))) continue;
      if (const char* const reason = obstacle_of(shape); reason != nullptr)
        add(shape, where + place_in_scene("shape", i, shape.name()), reason);
      if (wants_diffuse_) look_at_material(shape.material());
    }
    for (int i = 0; i < holder.instances_size() && still_ && !full(); ++i) {
      const v1::Instance& instance = holder.instances(i);
      if (moves(instance.world_from_instance(), instance.world_from_instance_end(), instance.motion()))
        add(instance, where + place_in_scene("instance", i, instance.object()), still_);
    }
  }

  const char* obstacle_of(const v1::Shape& shape) const {
    if (still_ && moves(shape)) return still_;
    if (algorithm_.starts_at_lights && shape.has_curves() && shape.curves().kind() != v1::Curves::RIBBON)
      return "cannot light flat curves and cylinders, which turn to whoever looks";
    if (lights_planes_ && shape.has_half_space())
      return "cannot start light at infinity that falls on all of a half-space: take another integrator, a "
             "disk "
             "or a box";
    if (algorithm_.diffuse_only && !has_triangles(shape))
      return "is for meshes of triangles; this is another kind of shape";
    if (wants_diffuse_ && lets_pass(shape.alpha()))
      return "is for closed surfaces; this one has alpha below 1";
    return nullptr;
  }

  /// Null where there is none of that name.
  const v1::Material* material_of(const v1::Shape& shape) const {
    const auto material = materials_.find(shape.material());
    return material == materials_.end() ? nullptr : material->second;
  }

  /// Whether an opacity is below 1 somewhere, as far as messages tell.
  bool lets_pass(const v1::FloatValue& opacity) const {
    if (!opacity.has_texture()) return opacity.has_constant() && opacity.constant() < 1;
    const auto texture = textures_.find(opacity.texture());
    return texture != textures_.end() && texture->second->has_image();
  }

  void look_at_material(const std::string& name) {
    std::vector<std::string_view> open = {name};
    while (!open.empty() && !full()) {
      const auto known = materials_.find(open.back());
      open.pop_back();
      if (known == materials_.end() || !seen_.insert(known->second).second) continue;
      const v1::Material& material = *known->second;
      if (material.has_mix()) open.insert(open.end(), {material.mix().a(), material.mix().b()});
      if (!material.back().empty()) open.emplace_back(material.back());
      if ((material.has_diffuse() || material.has_mix()) && !lets_pass(material.opacity())) continue;
      add(material, absl::StrCat("material '", material.name(), "'"),
          "is for diffuse materials, and this one is not: it can be left out with --ignore-non-diffuse");
    }
  }

  /// Names of the objects that stand somewhere in the world.
  std::set<std::string_view> placed_objects() const {
    std::map<std::string_view, const v1::Object*> objects;
    for (const v1::Object& object : scene_.objects()) objects.try_emplace(object.name(), &object);
    std::set<std::string_view> placed;
    std::vector<const v1::Object*> open;
    const auto place = [&](const auto& holder) {
      const auto add_one = [&](const std::string& name) {
        const auto object = objects.find(name);
        if (object != objects.end() && placed.insert(object->first).second) open.push_back(object->second);
      };
      for (const v1::Instance& instance : holder.instances()) add_one(instance.object());
      for (const auto& run : holder.packed_instances().runs()) add_one(run.object());
    };
    place(scene_);
    while (!open.empty()) {
      const v1::Object& object = *open.back();
      open.pop_back();
      place(object);
    }
    return placed;
  }

  const AlgorithmTraits& algorithm_;
  const v1::Scene& scene_;
  const std::size_t most_;
  const char* still_ = nullptr;  // what is said of things that move; null: they may
  bool lights_planes_ = false;   // of half-spaces, all of them, which cannot be done
  bool wants_diffuse_ = false;
  std::map<std::string_view, const v1::Material*> materials_;
  std::map<std::string_view, const v1::Texture*> textures_;
  std::set<const v1::Material*> seen_;
  std::vector<Obstacle> found_;
};

}  // namespace

bool is_nothing(const v1::Shape& shape, const v1::Material* material) {
  return material != nullptr && material->has_interface() && !shape.has_csg() && !shape.has_area_light() &&
         shape.interior_medium() == shape.exterior_medium();
}

std::string Obstacle::to_string(const v1::Algorithms& algorithms) const {
  return absl::StrCat(place, ": integrator '", find_algorithm(algorithms.integrator())->name, "' ", reason);
}

std::vector<Obstacle> find_obstacles(const v1::Algorithms& algorithms, const v1::Scene& scene,
                                     std::size_t most) {
  if (find_algorithm(algorithms.integrator()) == nullptr) return {};
  return ObstacleFinder(algorithms, scene, most).run();
}

absl::Status check_obstacles(const v1::Algorithms& algorithms, const v1::Scene& scene) {
  const std::vector<Obstacle> obstacles = find_obstacles(algorithms, scene, 1);
  return obstacles.empty() ? absl::OkStatus()
                           : absl::InvalidArgumentError(obstacles.front().to_string(algorithms));
}

std::string obstacle_to(const v1::Algorithms& algorithms, const v1::Scene& scene, bool wants_media) {
  const std::vector<Obstacle> obstacles = find_obstacles(algorithms, scene, 1);
  if (!obstacles.empty()) return obstacles.front().reason;
  if (algorithms.color() == v1::COLOR_SPECTRAL && !find_algorithm(algorithms.integrator())->wavelengths)
    return "carries no light of wavelengths";
  if (wants_media && !find_algorithm(algorithms.integrator())->media && scene.media_size() > 0)
    return "sees no media";
  return "";
}

}  // namespace tessera::wire
