#include "render/accel/structure/primitive_list.h"

#include "absl/strings/str_cat.h"
#include "render/accel/structure/has_normal.h"
#include "render/core/stopped.h"
#include "render/shape/exact_affine.h"
#include "render/shape/key_vertices.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

namespace {

/// A primitive that is told by its box.
void add_boxed(PrimitiveKind kind, std::int32_t shape, std::int32_t number, const Box& box,
               std::vector<Primitive>& list, bool has_alpha = false) {
  if (box.empty() || !box.finite()) return;
  Primitive primitive{};
  primitive.kind = kind;
  primitive.shape = shape;
  primitive.number = number;
  primitive.has_alpha = has_alpha;
  std::copy_n(box.low, 3, primitive.corners[0]);
  std::copy_n(box.high, 3, primitive.corners[1]);
  list.push_back(primitive);
}

/// The numbers of a triangle's corners among the shape's vertices.
const std::uint32_t* corners_of(const ShapeTable& table, const ShapeRecord& shape, std::int32_t triangle) {
  return table.triangles.data() +
         3 * (static_cast<std::size_t>(shape.first_triangle) + static_cast<std::size_t>(triangle));
}

/// Triangles whose corners move, each in a box about all of its way: that of a corner is straight between two
/// keys. A rounding more is less than rays' boxes are padded by.
void add_deforming(const ShapeTable& table, const ShapeRecord& shape, std::int32_t index,
                   std::vector<Primitive>& list, const std::stop_token& stop) {
  for (std::int32_t t = 0; t < shape.triangle_count; ++t) {
    throw_if_stopped(stop, static_cast<std::size_t>(t));
    const std::uint32_t* const row = corners_of(table, shape, t);
    Box box;
    for (std::int32_t key = 0; key <= shape.key_segments; ++key)
      for (int c = 0; c < 3; ++c) box.add(key_vertex(table, shape, row[c], key).position);
    add_boxed(PrimitiveKind::kDeforming, index, t, box, list, (shape.flags & kHasAlpha) != 0);
  }
}

void add_triangles(const ShapeTable& table, const ShapeRecord& shape, std::int32_t index,
                   std::vector<Primitive>& list, const std::stop_token& stop) {
  for (std::int32_t t = 0; t < shape.triangle_count; ++t) {
    throw_if_stopped(stop, static_cast<std::size_t>(t));
    const std::uint32_t* const row = corners_of(table, shape, t);
    Primitive primitive{};
    primitive.shape = index;
    primitive.number = t;
    primitive.has_alpha = (shape.flags & kHasAlpha) != 0;
    for (int c = 0; c < 3; ++c) {
      const Vertex& vertex = table.vertices[static_cast<std::size_t>(shape.first_vertex) + row[c]];
      std::copy_n(vertex.position, 3, primitive.corners[c]);
    }
    if (box_of(primitive).finite() && has_normal(primitive.corners)) list.push_back(primitive);
  }
}

/// The box of a box that is moved, rounded outwards.
Box moved_box(const ExactAffine& a, const Box& box) {
  Box moved;
  for (int i = 0; i < 3; ++i) {
    const double* const row = a.m + 4 * i;
    double low = row[3], high = row[3], size = std::abs(row[3]);
    for (int k = 0; k < 3; ++k) {
      const double x = row[k] * box.low[k], y = row[k] * box.high[k];
      low += std::min(x, y), high += std::max(x, y);
      size += std::max(std::abs(x), std::abs(y));
    }
    const double room = 0x1p-24 * size;  // more than the sums above and the rounding to float are off
    moved.low[i] = static_cast<float>(low - room), moved.high[i] = static_cast<float>(high + room);
  }
  return moved;
}

}  // namespace

std::size_t most_primitives(const ShapeTable& table, std::int32_t shape, const AnalyticBounds& analytic) {
  const ShapeRecord& record = table.shapes[static_cast<std::size_t>(shape)];
  if (record.kind == ShapeKind::kCurves) return 0;  // they are refused
  if (record.kind == ShapeKind::kTriangles) return static_cast<std::size_t>(record.triangle_count);
  return static_cast<std::size_t>(analytic.count(table, shape));
}

absl::Status add_primitives(const ShapeTable& table, std::int32_t shape, const AnalyticBounds& analytic,
                            std::vector<Primitive>& list, const std::stop_token& stop) {
  throw_if_stopped(stop);
  const ShapeRecord& record = table.shapes[static_cast<std::size_t>(shape)];
  if (record.kind == ShapeKind::kCurves) {
    return absl::InvalidArgumentError(absl::StrCat("curves (shape ", record.number,
                                                   " of the scene) are met by accelerator 'embree' alone"));
  }
  if (record.kind == ShapeKind::kTriangles) {
    (record.key_segments > 0 ? add_deforming : add_triangles)(table, record, shape, list, stop);
    return absl::OkStatus();
  }
  const std::int32_t count = analytic.count(table, shape);
  for (std::int32_t p = 0; p < count; ++p) {
    throw_if_stopped(stop);
    add_boxed(PrimitiveKind::kAnalytic, shape, p, analytic.bounds(table, shape, p), list);
  }
  return absl::OkStatus();
}

Box box_of_instance(const ShapeTable& table, const InstanceRecord& record, const Box& object) {
  if (object.empty()) return {};
  // A point's way is straight between two steps: what is in the boxes of both stays in the box of both.
  Box box = record.segments == 0 ? moved_box(exact(record.render_from_instance), object) : Box{};
  for (std::int32_t k = 0; record.segments > 0 && k <= record.segments; ++k)
    box.add(moved_box(exact(table.motion_steps[static_cast<std::size_t>(record.first_step + k)]), object));
  return box;
}

void add_instance(std::int32_t number, const Box& box, std::vector<Primitive>& list) {
  add_boxed(PrimitiveKind::kInstance, -1, number, box, list);
}

}  // namespace tessera::render
