#include "render/scene/scene_content.h"

#include <google/protobuf/message.h>

#include <bit>
#include <future>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "base/cpu_time.h"
#include "render/accel/accel_kernel.h"
#include "render/accel/embree/accelerator.h"
#include "render/core/stopped.h"
#include "render/scene/diffuse/diffuse_scene.h"
#include "render/scene/light/light_builder.h"
#include "render/scene/light/light_values.h"
#include "render/scene/material/material_builder.h"
#include "render/scene/medium/medium_builder.h"
#include "render/scene/placement/motion.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/shape/instance_builder.h"
#include "render/scene/shape/intersection.h"
#include "render/scene/shape/object_graph.h"
#include "render/scene/shape/shading_groups.h"
#include "render/scene/shape/shape_builder.h"
#include "render/scene/spectral/spectral_builder.h"
#include "render/scene/texture/mesh_attributes.h"
#include "render/scene/texture/texture_builder.h"
#include "render/scene/texture/texture_images.h"
#include "render/scene/values/located.h"
#include "render/scene/view/layers.h"
#include "render/scene/view/settings.h"
#include "render/scene/view/view.h"
#include "wire/message_digest.h"

namespace tessera::render {

/// The builders of a scene's arrays: what each reads of those before it, and the order in which they run.
struct ArrayBuilders {
  const v1::Scene& scene;
  const BlobSource& blobs;
  const wire::AlgorithmTraits& algorithm;
  const RenderSpace space;
  SceneArrays& arrays;
  std::vector<std::string>& warnings;
  const TexelFilter unsaid_filter;  // used for images that name none
  SharedImages* const shared_images;
  const std::stop_token stop;
  SpectralBuilder* const spectral;  // null in jobs of RGB

  // Builders that ask for a texture mark its images as needed; they are decoded when nothing more asks.
  TextureImages images{shared_images};
  TextureBuilder textures{space, images, arrays.textures, unsaid_filter};
  MediumBuilder media{space, blobs, arrays.media, spectral};
  MaterialBuilder materials{textures, arrays.materials, warnings, true, spectral};
  MeshAttributes attributes{textures.attribute_names(), blobs, arrays.textures};
  ShapeBuilder shapes{{blobs, materials.names(), arrays.materials, media.names(), textures, attributes,
                       algorithm.diffuse_only, stop},
                      arrays.shapes,
                      warnings};
  InstanceBuilder instances{space, blobs, shapes, arrays.shapes, warnings, stop};
  v1::Nesting nesting = v1::NESTING_UNSPECIFIED;
  std::string lists_instances = "";  // who does, for plan_nesting()
  LightBuilder lights{{.space = space,
                       .blobs = blobs,
                       .algorithm = algorithm,
                       .textures = textures,
                       .spectral = spectral,
                       .warnings = &warnings,
                       .scale = SceneScale::of(scene.units()).value_or(SceneScale{})},
                      arrays.lights};

  absl::Status run() {
    if (auto s = SceneScale::of(scene.units()).status(); !s.ok()) return s;
    if (auto s = textures.build(scene.textures()); !s.ok()) return s;
    if (auto s = media.build(scene.media(), algorithm, warnings); !s.ok()) return s;
    throw_if_stopped(stop);
    if (auto s = materials.build(scene.materials()); !s.ok()) return s;
    throw_if_stopped(stop);
    if (algorithm.lists_instances) lists_instances = wants_flat(algorithm);
    if (auto s = instances.build(scene, nesting, lists_instances); !s.ok()) return s;
    throw_if_stopped(stop);
    if (auto s = lights.add_area_lights(shapes.emitters(), arrays.shapes); !s.ok()) return s;
    return lights.add_lights(scene.lights());
  }
};

namespace {

/// Sets the flags that paths look at before they begin, from all materials and media.
void set_path_traits(const SceneArrays& arrays, const Settings& settings, SceneTables& tables) {
  for (const MaterialRecord& material : arrays.materials.materials) {
    tables.any_textures = tables.any_textures || (material.flags & kHasTextures);
    tables.any_tangents = tables.any_tangents || (material.flags & (kHasBump | kAnisotropic)) ||
                          material.upper_normal_texture >= 0;
    tables.any_mix = tables.any_mix || (material.flags & (kMixed | kHasBack));
    tables.any_opacity = tables.any_opacity || (material.flags & kHasOpacity);
    tables.any_dispersion = tables.any_dispersion || (material.flags & kDisperses);
    tables.straight_shadows |= settings.straight_shadows && is_clear_glass(material);
    // Materials that are no surface matter in media only.
    if (!settings.algorithm->media || material.kind == kNoSurface) continue;
    tables.paths_pass = tables.paths_pass || (material.flags & (kHasOpacity | kPassesStraight));
  }
  tables.paths_pass = tables.paths_pass || !arrays.media.media.empty();
  tables.volumetric = tables.paths_pass || tables.straight_shadows;
  tables.any_motion = !tables.sensor.steps.empty() || arrays.shapes.moves() ||
                      (arrays.lights.moving != nullptr && arrays.lights.moving->moves);
}

/// Media that the camera is not in and no border leads to are as if they were not there.
void leave_out_unmet_media(std::int32_t medium_of_camera, SceneArrays& arrays) {
  const auto is_border = [](const ShapeRecord& shape) { return (shape.flags & kMediumBorder) != 0; };
  if (medium_of_camera < 0 && std::ranges::none_of(arrays.shapes.shapes, is_border)) arrays.media = {};
}

/// Whether footprints are asked for, once images are decoded.
void set_footprint_traits(const SceneArrays& arrays, SceneTables& tables) {
  for (const MaterialRecord& material : arrays.materials.materials)
    tables.any_filtered |= material.bump_texture >= 0 && !(material.flags & kBendsSoftly);
  for (const TextureNode& node : arrays.textures.nodes)
    tables.any_filtered |= node.image && !node.image->pyramid.levels.empty();
  tables.any_tangents |= tables.any_filtered;
}

/// Whether rays are traced one by one.
bool is_single(const Settings& settings) { return settings.asked.traversal() == v1::TRAVERSAL_SINGLE; }

absl::Status build_embree(bool robust, const Settings& settings, const LoadOptions& options,
                          const EmbreeKernel& embree, SceneContent& content) {
  const ShapeTable& shapes = content.arrays.shapes;
  auto built = Accelerator::build(shapes, content.arrays.textures, embree.callbacks,
                                  {options.threads, options.isa, robust, options.stop});
  if (!built.ok()) return built.status();
  content.rays = embree.make_query((*built)->scene(), shapes, is_single(settings));
  content.accelerator = *std::move(built);
  return absl::OkStatus();
}

absl::Status build_of_courses(StructureKind kind, const Settings& settings, const LoadOptions& options,
                              const StructureKernel& kernel, SceneContent& content) {
  const double density = settings.asked.grid_density();
  auto built = build_structure(kind, content.arrays.shapes, content.arrays.textures, kernel.analytic,
                               {.threads = options.threads,
                                .wide = !is_single(settings),
                                .grid_density = density == 0 ? kGridDensity : density,
                                .shadow_cache = settings.asked.shadow_cache(),
                                .stop = options.stop});
  if (!built.ok()) return built.status();
  content.rays = kernel.make_query(**built);
  content.accelerator = *std::move(built);
  return absl::OkStatus();
}

/// The structure over the shapes while the images are decoded, which it has nothing to do with. A worker of
/// one thread uses one.
absl::Status build_accelerator(ArrayBuilders& builders, bool robust, const Settings& settings,
                               const LoadOptions& options, const AccelKernel& accel, SceneContent& content) {
  std::future<absl::Status> images =
      std::async(options.threads > 1 ? std::launch::async : std::launch::deferred,
                 [&] { return builders.images.decode(builders.blobs, options.threads); });
  const std::chrono::nanoseconds start = base::process_cpu_time();
  const absl::Status built =
      settings.structure ? build_of_courses(*settings.structure, settings, options, accel.structures, content)
                         : build_embree(robust, settings, options, accel.embree, content);
  content.accelerator_cpu_seconds = base::in_seconds(base::process_cpu_time() - start);
  if (auto s = images.get(); !s.ok()) return s;
  return built;
}

/// Builds Embree's structure anew, for robust tests.
absl::Status build_robust(const Settings& settings, const LoadOptions& options, const AccelKernel& accel,
                          SceneContent& content) {
  const std::chrono::nanoseconds start = base::process_cpu_time();
  content.rays.reset();
  content.accelerator.reset();
  const absl::Status built = build_embree(true, settings, options, accel.embree, content);
  content.accelerator_cpu_seconds += base::in_seconds(base::process_cpu_time() - start);
  return built;
}

}  // namespace

namespace {

/// Key of what building reads of an algorithm: algorithms with one key share what is built. What views read
/// of it (view.h) is not in the key.
std::string building_key(const wire::AlgorithmTraits& algorithm, const v1::Scene& scene) {
  const bool warns = !algorithm.media && scene.media_size() > 0;  // the warning has its name
  return absl::StrCat(warns ? algorithm.name : "", " ", algorithm.media, algorithm.samples_all_light,
                      algorithm.starts_at_lights, algorithm.motion, algorithm.diffuse_only,
                      algorithm.lists_instances);
}

/// Takes out names of shapes, which may have that of a frame's own file in them, and files that blobs came
/// from: only messages tell them.
void clear_hints(google::protobuf::Message& message) {
  if (auto* const blob = google::protobuf::DynamicCastToGenerated<v1::BlobRef>(&message)) blob->clear_path();
  if (auto* const shape = google::protobuf::DynamicCastToGenerated<v1::Shape>(&message)) shape->clear_name();
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const google::protobuf::FieldDescriptor* field : fields) {
    if (field->cpp_type() != google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (field->message_type() == v1::Instance::descriptor()) continue;  // millions, without either
    if (!field->is_repeated()) {
      clear_hints(*reflection.MutableMessage(&message, field));
      continue;
    }
    for (int i = 0; i < reflection.FieldSize(message, field); ++i)
      clear_hints(*reflection.MutableRepeatedMessage(&message, field, i));
  }
}

}  // namespace

std::string content_key(const v1::Scene& scene, const v1::JobSpec& job, const std::string& isa) {
  v1::Scene relevant = scene;
  relevant.clear_name();
  clear_hints(relevant);
  relevant.clear_film();
  relevant.clear_views();
  relevant.clear_settings();  // only asked for: what holds is in the job
  v1::Camera& camera = *relevant.mutable_camera();
  camera.clear_kind();
  camera.clear_screen_window();
  camera.clear_near_clip();
  camera.clear_far_clip();
  camera.clear_distortion();
  camera.clear_view_name();
  camera.clear_shutter();
  camera.clear_focus_point();
  std::string key = absl::StrCat(isa, " ");
  const auto origin = render_origin(scene);
  if (camera.world_from_camera_end().elements().empty() && camera.motion().empty() && origin.ok()) {
    absl::StrAppend(&key, absl::Hex(std::bit_cast<std::uint64_t>(origin->x)), " ",
                    absl::Hex(std::bit_cast<std::uint64_t>(origin->y)), " ",
                    absl::Hex(std::bit_cast<std::uint64_t>(origin->z)), " ");
    camera.clear_world_from_camera();
    camera.clear_viewpoint();
  }
  v1::Algorithms algorithms = job.content().algorithms();
  absl::StrAppend(&key, building_key(*wire::find_algorithm(algorithms.integrator()), scene), " ");
  algorithms.clear_integrator();
  return absl::StrCat(key, wire::digest_of({&algorithms, &relevant}));
}

absl::Status view_content(const v1::Scene& scene, const v1::JobSpec& job, const BlobSource& blobs,
                          SceneTables& tables) {
  const Settings settings = read_settings(job);
  const auto origin = render_origin(scene);
  if (!origin.ok()) return origin.status();
  return set_view(scene, job, settings, render_space_about(*origin), blobs, tables);
}

struct ContentBuild::Parts {
  const v1::Scene& scene;
  const LoadOptions& options;
  const AccelKernel& accel;
  const Settings settings;
  const std::shared_ptr<SceneContent> content;
  const std::unique_ptr<SpectralBuilder> spectral;  // null in jobs of RGB
  ArrayBuilders builders;
};

ContentBuild::ContentBuild(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
ContentBuild::ContentBuild(ContentBuild&&) noexcept = default;
ContentBuild::~ContentBuild() = default;

SceneArrays& ContentBuild::arrays() { return parts_->content->arrays; }

std::shared_ptr<const ShapeTable> ContentBuild::shapes() const {
  return {parts_->content, &parts_->content->arrays.shapes};
}

const std::vector<const v1::Shape*>& ContentBuild::shape_messages() const {
  return parts_->builders.shapes.messages();
}

const std::vector<std::string>& ContentBuild::warnings() const { return parts_->content->warnings; }

absl::StatusOr<ContentBuild> ContentBuild::begin(const v1::Scene& scene, const v1::JobSpec& job,
                                                 const BlobSource& blobs, const LoadOptions& options,
                                                 const AccelKernel& accel, LightSources light_sources) {
  const Settings settings = read_settings(job);
  const auto origin = render_origin(scene);
  if (!origin.ok()) return origin.status();
  auto content = std::make_shared<SceneContent>();
  SceneArrays& arrays = content->arrays;
  arrays.lights.sources = light_sources;
  arrays.lights.shapes = &arrays.shapes;
  arrays.lights.textures = &arrays.textures;
  auto spectral = settings.spectral ? std::make_unique<SpectralBuilder>(arrays.spectral) : nullptr;
  SpectralBuilder* const spectra = spectral.get();
  std::unique_ptr<Parts> parts(new Parts{
      .scene = scene,
      .options = options,
      .accel = accel,
      .settings = settings,
      .content = content,
      .spectral = std::move(spectral),
      .builders = {.scene = scene,
                   .blobs = blobs,
                   .algorithm = *settings.algorithm,
                   .space = render_space_about(*origin),
                   .arrays = arrays,
                   .warnings = content->warnings,
                   .unsaid_filter = settings.texture_filter,
                   .shared_images = options.contents == nullptr ? nullptr : &options.contents->images(),
                   .stop = options.stop,
                   .spectral = spectra,
                   .nesting = settings.asked.nesting(),
                   .lists_instances = options.lists_instances}});
  ArrayBuilders& builders = parts->builders;
  SceneTables& tables = content->tables;
  if (settings.spectral) tables.spectral = &arrays.spectral;
  if (auto s = set_view(scene, job, settings, builders.space, blobs, tables); !s.ok()) return s;
  if (auto s = builders.run(); !s.ok()) return s;
  if (const auto motion = Motion::of(scene.camera()); motion.ok()) {
    const std::string roughness = roughness_of(motion->steps());
    if (!roughness.empty()) content->warnings.push_back("camera: " + roughness);
  }
  accel.structures.prepare(arrays.shapes);
  const auto medium = builders.media.names().find(scene.camera().medium());
  if (!medium.ok()) return located(medium.status(), "camera");
  tables.sensor.medium = *medium;
  return ContentBuild(std::move(parts));
}

absl::StatusOr<std::shared_ptr<const SceneContent>> ContentBuild::finish() {
  const Settings& settings = parts_->settings;
  ArrayBuilders& builders = parts_->builders;
  SceneContent& content = *parts_->content;
  SceneArrays& arrays = content.arrays;
  for (const v1::Material& material : parts_->scene.materials())
    content.material_names.push_back(material.name());
  if (!builders.instances.note().empty()) content.notes.push_back(builders.instances.note());
  content.material_names.resize(arrays.materials.materials.size(), "(default)");
  if (settings.algorithm->diffuse_only) {
    const DiffuseSceneNames names{builders.shapes.names(), content.material_names};
    throw_if_stopped(parts_->options.stop);
    if (auto s = make_diffuse(settings, names, arrays, content.warnings); !s.ok()) return s;
  }
  leave_out_unmet_media(content.tables.sensor.medium, arrays);
  set_path_traits(arrays, settings, content.tables);
  group_for_shading(arrays.shapes, arrays.materials, content.tables);
  if (parts_->options.geometry_read) parts_->options.geometry_read();

  const std::vector<std::string>& names = builders.shapes.names();
  IntersectionProbe probe;
  if (!settings.structure) probe = probe_intersection(arrays.shapes);
  const bool robust =
      !settings.structure &&
      wants_robust_intersection(probe, names, settings.asked.intersection(), content.warnings);
  if (auto s = build_accelerator(builders, robust, settings, parts_->options, parts_->accel, content);
      !s.ok())
    return s;
  throw_if_stopped(parts_->options.stop);
  if (auto s = builders.lights.settle_amounts(); !s.ok()) return s;
  set_footprint_traits(arrays, content.tables);
  const float* const centre = content.accelerator->bounding_centre();
  const float radius = content.accelerator->bounding_radius();
  if (auto s = builders.instances.check_reach(centre, radius); !s.ok()) return s;
  build_light_selection(settings.asked, centre, radius, arrays.lights);
  const bool may_change =
      !settings.structure && !robust && settings.asked.intersection() != v1::INTERSECTION_FAST;
  if (may_change && leaks_would_show(probe, arrays, *content.rays, names, content.warnings)) {
    if (auto s = build_robust(settings, parts_->options, parts_->accel, content); !s.ok()) return s;
  }
  content.shape_numbers = shape_numbers(parts_->scene, builders.shapes.messages());
  if (parts_->spectral != nullptr) {
    // Last: all that looks at a scene before it is rendered looks at colours.
    arrays.spectral.curve_of_light = builders.lights.curves_by_light();
    parts_->spectral->convert(arrays.materials, arrays.textures, content.material_names, content.warnings);
    parts_->spectral->convert(arrays.media);
  }
  return parts_->content;
}

}  // namespace tessera::render
