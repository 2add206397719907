#include "render/query/query_structure.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace tessera::render {

void triangle_corners(const ShapeTable& table, const ShapeRecord& mesh, std::int32_t number,
                      float (&corners)[3][3]) {
  const std::uint32_t* const row =
      table.triangles.data() +
      3 * (static_cast<std::size_t>(mesh.first_triangle) + static_cast<std::size_t>(number));
  for (int c = 0; c < 3; ++c)
    std::copy_n(table.vertices[static_cast<std::size_t>(mesh.first_vertex) + row[c]].position, 3, corners[c]);
}

absl::Status QueryStructure::add_shapes(std::int32_t first, std::int32_t count,
                                        const AnalyticBounds& analytic, Level<Bvh>& level) const {
  for (std::int32_t s = first; s < first + count; ++s) {
    const ShapeRecord& record = shapes_->shapes[static_cast<std::size_t>(s)];
    if (record.kind == ShapeKind::kCurves) continue;
    if (record.kind != ShapeKind::kTriangles) {
      if (auto status = add_primitives(*shapes_, s, analytic, level.primitives); !status.ok()) return status;
      continue;
    }
    for (std::int32_t t = 0; t < record.triangle_count; ++t) {
      Primitive primitive{};
      primitive.shape = s, primitive.number = t;
      triangle_corners(*shapes_, record, t, primitive.corners);
      if (box_of(primitive).finite()) level.primitives.push_back(primitive);
    }
  }
  return absl::OkStatus();
}

absl::Status QueryStructure::finish(Level<Bvh>& level, int threads) {
  constexpr std::size_t kMostPrimitives = std::size_t{1} << 30;
  if (level.primitives.size() > kMostPrimitives) {
    return absl::ResourceExhaustedError(
        absl::StrCat(level.primitives.size(), " primitives to be asked; at most ", kMostPrimitives));
  }
  for (const Primitive& primitive : level.primitives) level.box.add(box_of(primitive));
  level.largest = level.primitives.empty() ? 0 : level.box.largest_coordinate();
  level.tree = build_bvh(BvhRule::kSah, level.primitives, threads);
  return absl::OkStatus();
}

absl::StatusOr<QueryStructure> QueryStructure::build(const ShapeTable& table, const AnalyticBounds& analytic,
                                                     int threads) {
  QueryStructure self;
  self.shapes_ = &table;
  self.objects_.resize(table.objects.size());
  for (std::size_t i = 0; i < table.objects.size(); ++i) {
    const ObjectRange& range = table.objects[i];
    if (auto s = self.add_shapes(range.first_shape, range.shape_count, analytic, self.objects_[i]); !s.ok())
      return s;
    if (auto s = finish(self.objects_[i], threads); !s.ok()) return s;
  }
  if (auto s = self.add_shapes(0, table.world_shape_count, analytic, self.world_); !s.ok()) return s;
  self.instance_from_render_.reserve(table.instances.size());
  for (std::size_t i = 0; i < table.instances.size(); ++i) {
    const InstanceRecord& instance = table.instances[i];
    self.instance_from_render_.push_back(inverse(exact(instance.render_from_instance)));
    const Box& object = self.objects_[static_cast<std::size_t>(instance.object)].box;
    add_instance(static_cast<std::int32_t>(i), box_of_instance(table, instance, object),
                 self.world_.primitives);
  }
  if (auto s = finish(self.world_, threads); !s.ok()) return s;
  return self;
}

}  // namespace tessera::render
