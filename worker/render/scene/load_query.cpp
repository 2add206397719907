#include "render/scene/load_query.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "render/accel/accel_kernel.h"
#include "render/kernel/kernel_module.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/scene_content.h"
#include "render/shape/key_vertices.h"
#include "wire/algorithm_fit.h"
#include "wire/scene_numbers.h"

namespace tessera::render {

namespace {

/// Makes meshes that deform what they are at `time`: queries are asked of one moment.
void hold_deforming_meshes(float time, ShapeTable& shapes) {
  for (ShapeRecord& shape : shapes.shapes) {
    if (shape.kind != ShapeKind::kTriangles || shape.key_segments == 0) continue;
    const KeyTime at(shape.key_segments, time);
    for (std::int32_t i = 0; i < shape.vertex_count; ++i) {
      const auto vertex = static_cast<std::uint32_t>(i);
      const Vertex a = key_vertex(shapes, shape, vertex, at.before),
                   b = key_vertex(shapes, shape, vertex, at.before + 1);
      Vertex& now = shapes.vertices[static_cast<std::size_t>(shape.first_vertex) + vertex];
      for (int k = 0; k < 3; ++k) {
        now.position[k] = (1 - at.part) * a.position[k] + at.part * b.position[k];
        now.normal[k] = (1 - at.part) * a.normal[k] + at.part * b.normal[k];
      }
    }
    shape.key_segments = 0;
    shape.flags &= ~kDeforms;
  }
}

}  // namespace

absl::StatusOr<std::unique_ptr<const QueryScene>> load_query(const v1::Scene& scene, const v1::JobSpec& job,
                                                             const BlobSource& blobs,
                                                             const QueryOptions& options,
                                                             std::vector<std::string>& warnings) {
  const auto found = kernel_of(options.isa, KernelLight::kRgb);
  if (!found.ok()) {
    return absl::FailedPreconditionError(
        absl::StrCat("there are no kernels for ISA '", options.isa, "' here: ", found.status().message()));
  }
  const Kernel* const kernel = *found;
  if (auto s = wire::check_scene_numbers(scene); !s.ok()) return s;
  if (auto s = wire::check_obstacles(job.content().algorithms(), scene); !s.ok()) return s;
  // Crossings name a shape and an instance, with no levels between.
  const LoadOptions load{.isa = options.isa, .threads = options.threads, .lists_instances = "a query"};
  auto build = ContentBuild::begin(scene, job, blobs, load, *kernel->accel, kernel->light_sources);
  if (!build.ok()) return build.status();
  hold_deforming_meshes(options.time, build->arrays().shapes);
  const auto origin = render_origin(scene);
  if (!origin.ok()) return origin.status();
  const auto world_from_camera = Transform::from_proto(scene.camera().world_from_camera());
  if (!world_from_camera.ok()) return world_from_camera.status();
  warnings.insert(warnings.end(), build->warnings().begin(), build->warnings().end());

  QueryScene::Parts parts{.shapes = build->shapes(),
                          .names = {},
                          .origin = *origin,
                          .camera = world_from_camera->apply({0, 0, 0}),
                          .camera_medium = scene.camera().medium(),
                          .kernel = kernel->query,
                          .analytic = kernel->accel->structures.analytic,
                          .time = options.time,
                          .threads = options.threads};
  for (std::size_t i = 0; i < parts.shapes->shapes.size(); ++i) {
    const v1::Shape& message = *build->shape_messages()[i];
    parts.names.push_back({message.name(), message.material(), message.interior_medium(),
                           message.exterior_medium(), parts.shapes->shapes[i].number});
  }
  auto built = QueryScene::build(std::move(parts));
  if (!built.ok()) return built.status();
  const auto warn = [&](const std::vector<std::int32_t>& shapes, const char* what) {
    if (shapes.empty()) return;
    const ShapeNames& first = (*built)->names(shapes.front());
    warnings.push_back(
        absl::StrCat("shape ", first.number, first.name.empty() ? "" : absl::StrCat(" (", first.name, ")"),
                     shapes.size() > 1 ? absl::StrCat(" and ", shapes.size() - 1, " more") : "", what));
  };
  warn((*built)->left_out(), ": curves, which face whoever looks, are left out");
  return built;
}

}  // namespace tessera::render
