#include "render/textbook/preview/clusters.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/shape/analytic_shape.h"

namespace tessera::render::TESSERA_ISA {

namespace {

struct Box {
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};

  /// Points that are not finite are left out, as triangles with them are.
  void add(const float* p, float radius = 0) {
    if (!std::isfinite(p[0] + p[1] + p[2] + radius)) return;
    for (int c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], p[c] - radius);
      high[c] = std::max(high[c], p[c] + radius);
    }
  }
};

std::int32_t primitives_of(const ShapeTable& table, const ShapeRecord& shape) {
  if (shape.kind == ShapeKind::kTriangles) return shape.triangle_count;
  if (shape.kind == ShapeKind::kCurves)
    return static_cast<std::int32_t>(table.curves[static_cast<std::size_t>(shape.quadric)].starts.size());
  return analytic_shape(shape.kind)->primitive_count(table, shape);
}

Box box_of_triangles(const ShapeTable& table, const ShapeRecord& shape, std::int32_t first,
                     std::int32_t last) {
  Box box;
  const Vertex* const vertices = table.vertices.data() + shape.first_vertex;
  const std::uint32_t* const corners = table.triangles.data() + std::size_t{3} * shape.first_triangle;
  for (std::size_t i = std::size_t{3} * first; i < std::size_t{3} * last; ++i)
    box.add(vertices[corners[i]].position);
  return box;
}

Box box_of_primitive(const ShapeTable& table, const ShapeRecord& shape, std::int32_t primitive) {
  Box box;
  if (shape.kind == ShapeKind::kCurves) {
    // A segment of either basis lies in the hull of its four points.
    const CurvesRecord& curves = table.curves[static_cast<std::size_t>(shape.quadric)];
    const CurvePoint* const points =
        curves.points.data() + curves.starts[static_cast<std::size_t>(primitive)];
    float radius = 0;
    for (int i = 0; i < 4; ++i) radius = std::max(radius, points[i].radius);
    for (int i = 0; i < 4; ++i) box.add(points[i].position, radius);
    return box;
  }
  const ShapeBounds bounds = analytic_shape(shape.kind)->bounds(table, shape, primitive);
  box.add(bounds.low);
  box.add(bounds.high);
  return box;
}

}  // namespace

Clusters::Clusters(const ShapeTable& shapes) : shapes_(shapes) {
  first_.reserve(shapes.shapes.size() + 1);
  for (const ShapeRecord& shape : shapes.shapes) {
    first_.push_back(count_);
    primitives_of_shape_.push_back(primitives_of(shapes, shape));
    count_ += static_cast<std::size_t>((primitives_of_shape_.back() + kClusterSize - 1) / kClusterSize);
  }
  first_.push_back(count_);
  for (int c = 0; c < 3; ++c) {
    // Read 16 at a time.
    boxes_.low[c].resize(count_ + kWidth);
    boxes_.high[c].resize(count_ + kWidth);
  }
  const auto draw = [&](std::int32_t shape, std::int32_t instance) {
    if (count_of(shape) == 0) return;
    draws_.push_back({shape, instance, drawn_});
    drawn_ += count_of(shape);
  };
  for (std::int32_t shape = 0; shape < shapes.world_shape_count; ++shape) draw(shape, -1);
  for (std::size_t i = 0; i < shapes.instances.size(); ++i) {
    const ObjectRange& object = shapes.objects[static_cast<std::size_t>(shapes.instances[i].object)];
    for (std::int32_t k = 0; k < object.shape_count; ++k)
      draw(object.first_shape + k, static_cast<std::int32_t>(i));
  }
}

int Clusters::primitives(std::int32_t shape, std::size_t index) const {
  const auto first = static_cast<std::int32_t>(index) * kClusterSize;
  return std::min(kClusterSize, primitives_of_shape_[static_cast<std::size_t>(shape)] - first);
}

std::size_t Clusters::draw_at(std::uint64_t place) const {
  const auto after =
      std::upper_bound(draws_.begin(), draws_.end(), place,
                       [](std::uint64_t p, const Draw& draw) { return p < draw.first_cluster; });
  return static_cast<std::size_t>(after - draws_.begin()) - 1;
}

void Clusters::fill(std::size_t first, std::size_t last) {
  std::size_t shape =
      static_cast<std::size_t>(std::upper_bound(first_.begin(), first_.end(), first) - first_.begin()) - 1;
  for (std::size_t i = first; i < last; ++i) {
    while (i >= first_[shape + 1]) ++shape;
    const ShapeRecord& record = shapes_.shapes[shape];
    const auto begin = static_cast<std::int32_t>(i - first_[shape]) * kClusterSize;
    const std::int32_t end = begin + primitives(static_cast<std::int32_t>(shape), i - first_[shape]);
    Box box;
    if (record.kind == ShapeKind::kTriangles) {
      box = box_of_triangles(shapes_, record, begin, end);
    } else {
      for (std::int32_t p = begin; p < end; ++p) {
        const Box one = box_of_primitive(shapes_, record, p);
        box.add(one.low);
        box.add(one.high);
      }
    }
    for (int c = 0; c < 3; ++c) {
      boxes_.low[c][i] = box.low[c];
      boxes_.high[c][i] = box.high[c];
    }
  }
}

WideBox Clusters::boxes(std::size_t first) const {
  const auto at = [&](const BigArray<float>& array) { return Float::load_unaligned(array.data() + first); };
  return {{at(boxes_.low[0]), at(boxes_.low[1]), at(boxes_.low[2])},
          {at(boxes_.high[0]), at(boxes_.high[1]), at(boxes_.high[2])}};
}

WideBox Clusters::primitive_boxes(std::int32_t shape, std::int32_t first, Mask active) const {
  alignas(64) float lanes[6][kWidth] = {};
  for (std::uint32_t bits = active.bits(); bits != 0; bits &= bits - 1) {
    const int lane = __builtin_ctz(bits);
    const Box box = box_of_primitive(shapes_, shapes_.shapes[static_cast<std::size_t>(shape)], first + lane);
    for (int c = 0; c < 3; ++c) {
      lanes[c][lane] = box.low[c];
      lanes[3 + c][lane] = box.high[c];
    }
  }
  return {{Float::load(lanes[0]), Float::load(lanes[1]), Float::load(lanes[2])},
          {Float::load(lanes[3]), Float::load(lanes[4]), Float::load(lanes[5])}};
}

}  // namespace tessera::render::TESSERA_ISA
