// The second half of DirectiveHandler: what can only be done when the whole file has been read.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "import/geometry/motion_keys.h"
#include "import/input/concat.h"
#include "import/input/input_file.h"
#include "import/input/parallel.h"
#include "import/pbrt/directive_handler.h"
#include "import/pbrt/render_settings.h"
#include "import/pbrt/shapes/shapes.h"
#include "import/ply/ply_reader.h"
#include "wire/digest.h"
#include "wire/scene_numbers.h"

namespace tessera::client::pbrt {
namespace {

/// A PLY file on its way to a blob.
struct MeshJob {
  std::string file;  // the scene's name for it
  std::filesystem::path path;
  absl::Status status;
  std::string bytes;
  std::string digest;
  std::vector<std::string> warnings;
  v1::BlobRef blob;
};

void run(MeshJob& job) {
  absl::StatusOr<InputFile> file = InputFile::open(job.path);
  if (!file.ok()) {
    job.status = file.status();
    return;
  }
  absl::StatusOr<PlyMesh> ply = read_ply(file->bytes());
  if (!ply.ok()) {
    job.status = absl::InvalidArgumentError(concat(job.path.string(), ": ", ply.status().message()));
    return;
  }
  turn_faces_to_normals(ply->mesh);
  job.bytes = wire::encode_mesh(ply->mesh);
  job.digest = wire::sha256_hex(job.bytes);
  job.warnings = std::move(ply->warnings);
}

}  // namespace

const ShutterTimes& DirectiveHandler::shutter() {
  if (!shutter_) shutter_ = read_shutter(context_, camera_);
  return *shutter_;
}

MovingTransform DirectiveHandler::during_exposure(const MovingTransform& moving) {
  if (!moving.moves()) return moving;
  MovingTransform result;
  const ShutterTimes& times = shutter();
  result.start = interpolated(moving, times.open, transform_times_[0], transform_times_[1]);
  result.end = interpolated(moving, times.close, transform_times_[0], transform_times_[1]);
  if (const double open_for = times.close - times.open; open_for > 0) {
    result.begins = std::clamp((transform_times_[0] - times.open) / open_for, 0.0, 1.0);
    result.ends = std::clamp((transform_times_[1] - times.open) / open_for, 0.0, 1.0);
  }
  return result;
}

void DirectiveHandler::place_shapes() {
  for (const PendingShape& pending : pending_shapes_) {
    const MovingTransform moving = during_exposure(pending.world_from_object);
    write_matrix(moving.start, *pending.shape->mutable_world_from_object());
    write_motion(placings_of(moving), &v1::Shape::mutable_world_from_object_end, *pending.shape);
  }
}

void DirectiveHandler::place_camera() {
  const MovingTransform from_world = during_exposure(camera_from_world_);
  const std::optional<Imath::M44d> start = inverse(from_world.start), end = inverse(from_world.end);
  if (!start || !end) {
    context_.diagnostics.error(camera_.parameters.where(), "the camera's transformation is singular");
    return;
  }
  // Sound numbers may still have an inverse that is none: 1e-45 has.
  for (const Imath::M44d& world_from_camera : {*start, *end}) {
    if (std::ranges::all_of(elements_of(world_from_camera), wire::is_scene_number)) continue;
    context_.diagnostics.error(camera_.parameters.where(), "the camera's transformation is nearly singular");
    return;
  }
  v1::Camera& camera = *context_.scene.mutable_camera();
  write_matrix(*start, *camera.mutable_world_from_camera());
  write_motion(placings_of({*start, *end, from_world.begins, from_world.ends}),
               &v1::Camera::mutable_world_from_camera_end, camera);
}

void DirectiveHandler::add_media() {
  std::set<std::string> used = {context_.scene.camera().medium()};
  for (const PendingShape& pending : pending_shapes_) {
    used.insert(pending.shape->interior_medium());
    used.insert(pending.shape->exterior_medium());
  }
  for (auto& [name, medium] : media_) {
    if (!used.contains(name)) continue;
    v1::Medium& added = *context_.scene.add_media();
    added = std::move(medium.message);
    context_.note(added, medium.where, concat("medium (", name, "): "));
  }
}

void DirectiveHandler::place_instances() {
  for (const EarlyInstance& early : early_instances_) {
    if (!object_index_.contains(early.object))
      context_.diagnostics.error(early.where, concat("there is no object \"", early.object, "\""));
  }
  const auto& objects = context_.scene.objects();
  const auto at = [](int object) { return static_cast<std::size_t>(object); };
  std::vector<bool> empty(at(objects.size())), used(at(objects.size()));
  const auto is_there = [&](const std::string& name) {
    const auto object = object_index_.find(name);
    return object != object_index_.end() && !empty[at(object->second)];
  };
  const auto mark_used = [&](const InstanceList& instances) {
    for (const std::string& name : instances.objects()) {
      if (is_there(name)) used[at(object_index_.at(name))] = true;
    }
  };
  // Objects follow those that they hold.
  for (int i = 0; i < objects.size(); ++i) {
    const auto held = instances_by_holder_.find(i);
    empty[at(i)] = objects[i].shapes().empty() && (held == instances_by_holder_.end() ||
                                                   std::ranges::none_of(held->second.objects(), is_there));
  }
  mark_used(world_instances_);
  for (auto held = instances_by_holder_.rbegin(); held != instances_by_holder_.rend(); ++held) {
    if (used[at(held->first)]) mark_used(held->second);
  }
  const auto place = [&](InstanceList& instances, auto& holder) {
    instances.for_each_moving([&](MovingTransform& moving) { moving = during_exposure(moving); });
    instances.move_to(holder, is_there, context_.blobs);
  };
  place(world_instances_, context_.scene);
  for (auto& [holder, instances] : instances_by_holder_) {
    if (used[at(holder)]) place(instances, *context_.scene.mutable_objects(holder));
  }
  std::erase_if(pending_shapes_,
                [&](const PendingShape& shape) { return shape.object >= 0 && !used[at(shape.object)]; });
  // From the back, so that the indices before stay what they are.
  for (int i = context_.scene.objects_size() - 1; i >= 0; --i) {
    if (!used[at(i)]) context_.scene.mutable_objects()->DeleteSubrange(i, 1);
  }
}

void DirectiveHandler::load_meshes() {
  // Each file once, however many shapes use it.
  std::vector<MeshJob> jobs;
  std::map<std::string, std::size_t> job_of_file;
  for (const PendingShape& shape : pending_shapes_) {
    if (shape.needs.ply_file.empty() || !job_of_file.try_emplace(shape.needs.ply_file, jobs.size()).second)
      continue;
    jobs.push_back(
        {shape.needs.ply_file, context_.resolve(shape.needs.ply_file), absl::OkStatus(), "", "", {}, {}});
  }
  parallel_for(jobs.size(), context_.threads, [&](std::size_t i) { run(jobs[i]); });
  for (MeshJob& job : jobs) {
    if (job.status.ok()) job.blob = context_.blobs.add_bytes(std::move(job.bytes), job.digest);
  }
  std::set<const MeshJob*> reported;
  for (PendingShape& shape : pending_shapes_) {
    if (shape.needs.ply_file.empty()) continue;
    const MeshJob& job = jobs[job_of_file[shape.needs.ply_file]];
    *shape.shape->mutable_mesh()->mutable_blob() = job.blob;
    if (!reported.insert(&job).second) continue;
    if (!job.status.ok()) context_.diagnostics.error(shape.where, std::string(job.status.message()));
    for (const std::string& warning : job.warnings) {
      context_.diagnostics.warning(shape.where, concat(job.file, ": ", warning));
    }
  }
}

void DirectiveHandler::resolve_materials_and_textures() {
  for (const PendingShape& pending : pending_shapes_) {
    pending.shape->set_material(materials_.use(pending.material, pending.where));
    if (!pending.needs.alpha_texture.empty()) {
      pending.shape->mutable_alpha()->set_texture(
          textures_.use(TextureKind::kFloat, pending.needs.alpha_texture, pending.where));
    }
    if (pending.shape->has_area_light() && materials_.is_interface(pending.material)) {
      pending.shape->clear_area_light();
      context_.diagnostics.warning(
          pending.where, "an area light on a shape of interface material is ignored, as in pbrt-v4");
    }
  }
}

void DirectiveHandler::resolve_powers() {
  for (const PendingShape& pending : pending_shapes_) {
    if (pending.power <= 0 || !pending.shape->has_area_light()) continue;
    const SurfaceArea area = world_area(*pending.shape, pending.world_from_object.start, context_.blobs);
    // pbrt-v4 gives the power to each of the lights that it makes of a mesh.
    const double lights =
        static_cast<double>(area.triangles) / static_cast<double>(pending.needs.triangles_per_light);
    v1::AreaLight& light = *pending.shape->mutable_area_light();
    // A diffuse emitter of radiance L emits pi L for each unit of area and side.
    const double sides = light.two_sided() ? 2 : 1;
    const double emitted = sides * std::numbers::pi * area.total * pending.mean_image;
    if (!(emitted > 0)) {
      context_.diagnostics.error(
          pending.where,
          "\"power\" of an area light: the shape has no area, or none that is known here, or its "
          "image is dark");
      continue;
    }
    const double scale = light.has_scale() ? light.scale() : 1;
    light.set_scale(static_cast<float>(scale * pending.power * lights / emitted));
    if (!area.triangles_of_equal_area) {
      context_.diagnostics.warning(
          pending.where,
          "\"power\" is spread evenly over the mesh; pbrt-v4 gives the same to each triangle, "
          "whatever its size");
    }
  }
}

void DirectiveHandler::finish() {
  for (const Block& block : blocks_) {
    context_.diagnostics.error(block.where, "this block is never closed");
  }
  if (!in_world_) context_.diagnostics.error({0, 0, 0}, "expected WorldBegin before the end of the file");
  close_curves();
  place_instances();
  place_shapes();
  load_meshes();
  resolve_materials_and_textures();
  resolve_powers();
  add_media();
  write_film(context_, film_, shutter().close - shutter().open);
  write_filter(context_, filter_);
  place_camera();
  write_camera(context_, camera_, film_);
  write_sampler(context_, sampler_);
  write_integrator(context_, integrator_);
  note_places();
}

void DirectiveHandler::note_places() {
  if (context_.diagnostics.has_errors()) return;
  context_.note(context_.scene.camera(), camera_.parameters.where(), "camera: ");
  context_.note(context_.scene.film(), film_.parameters.where(), "film: ");
  for (const PendingShape& pending : pending_shapes_) {
    const v1::Shape& shape = *pending.shape;
    const bool operand = pending.is_csg_operand;
    // Little of others is looked at (render/scene/scene_faults.h), and they may be many.
    const bool plain =
        !shape.has_area_light() && shape.world_from_object_end().elements().empty() && shape.motion().empty();
    if (!operand && plain && (shape.has_mesh() || shape.has_curves())) continue;
    const std::string& name = shape.name();  // "torus, scene.pbrt:12"
    context_.note(shape, pending.where, concat(name.substr(0, name.rfind(", ")), ": "));
  }
}

}  // namespace tessera::client::pbrt
