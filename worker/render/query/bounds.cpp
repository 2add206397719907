// Bounds of a scene, its shapes and its instances.
#include <algorithm>
#include <cmath>

#include "render/query/query_scene.h"

namespace tessera::render {
namespace {

constexpr double kNothing = HUGE_VAL;

void add(BoundsReport& to, const V3d& p) {
  for (int k = 0; k < 3; ++k) to.low[k] = std::min(to.low[k], p[k]), to.high[k] = std::max(to.high[k], p[k]);
}

/// One of a shape, mapped by `place` from the space that it is placed in.
void add_shape(const ShapeTable& table, const ShapeRecord& shape, const QueryKernel& kernel, const Box& box,
               const ExactAffine& place, BoundsReport& to) {
  if (box.empty()) return;
  if (shape.kind == ShapeKind::kTriangles) {
    for (std::int32_t t = 0; t < shape.triangle_count; ++t) {
      float corners[3][3];
      triangle_corners(table, shape, t, corners);
      for (const auto& corner : corners) {
        const V3d p = apply(place, to_point(corner));
        if (std::isfinite(p.x + p.y + p.z)) add(to, p);
      }
    }
    return;
  }
  const ExactAffine all = compose(place, placed_from_object(table, shape));
  V3d low, high;
  bool known = true;
  for (int k = 0; k < 3; ++k) {
    const V3d row(all.m[4 * k], all.m[4 * k + 1], all.m[4 * k + 2]);
    const auto most = support(table, shape, kernel, row), least = support(table, shape, kernel, -row);
    known = known && most && least;
    high[k] = all.m[4 * k + 3] + most.value_or(0), low[k] = all.m[4 * k + 3] - least.value_or(0);
  }
  if (known) {
    add(to, low), add(to, high);
    return;
  }
  to.tight = false;
  for (int corner = 0; corner < 8; ++corner) {
    add(to, apply(place, {corner & 1 ? box.high[0] : box.low[0], corner & 2 ? box.high[1] : box.low[1],
                          corner & 4 ? box.high[2] : box.low[2]}));
  }
}

BoundsReport nothing() {
  return {.low = {kNothing, kNothing, kNothing}, .high = {-kNothing, -kNothing, -kNothing}};
}

}  // namespace

std::vector<BoundsReport> QueryScene::bounds() const {
  const ExactAffine here{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  std::vector<BoundsReport> rows{nothing()};
  std::vector<Box> boxes(table().shapes.size());
  const auto add_boxes = [&](const Level<Bvh>& level) {
    for (const Primitive& primitive : level.primitives) {
      if (primitive.shape >= 0) boxes[static_cast<std::size_t>(primitive.shape)].add(box_of(primitive));
    }
  };
  add_boxes(structure_.world());
  for (std::size_t i = 0; i < table().objects.size(); ++i)
    add_boxes(structure_.object(static_cast<std::int32_t>(i)));

  const auto add_row = [&](BoundsReport row) {
    row.low += parts_.origin, row.high += parts_.origin;
    if (!row.unbounded && row.low.x <= row.high.x) {
      add(rows[0], row.low), add(rows[0], row.high);
      rows[0].tight = rows[0].tight && row.tight;
    }
    rows.push_back(row);
  };
  for (std::int32_t s = 0; s < table().world_shape_count; ++s) {
    BoundsReport row = nothing();
    row.shape = s;
    row.unbounded = is_unbounded(record(s));
    add_shape(table(), record(s), *parts_.kernel, boxes[static_cast<std::size_t>(s)], here, row);
    add_row(row);
  }
  // An object's corners are gone through for each of its instances.
  std::int64_t corners = 0;
  for (const InstanceRecord& instance : table().instances) {
    const ObjectRange& object = table().objects[static_cast<std::size_t>(instance.object)];
    for (std::int32_t s = 0; s < object.shape_count; ++s)
      corners += 3 * std::int64_t{record(object.first_shape + s).triangle_count};
  }
  constexpr std::int64_t kMostCorners = 1'000'000'000;
  for (std::size_t i = 0; i < table().instances.size(); ++i) {
    const InstanceRecord& instance = table().instances[i];
    const ObjectRange& object = table().objects[static_cast<std::size_t>(instance.object)];
    const ExactAffine place = structure_.render_from_instance(static_cast<std::int32_t>(i), parts_.time);
    BoundsReport row = nothing();
    row.instance = static_cast<std::int32_t>(i);
    row.unbounded = is_unbounded(table(), instance);
    if (object.shape_count == 1) row.shape = object.first_shape;
    for (std::int32_t s = object.first_shape; s < object.first_shape + object.shape_count; ++s) {
      ShapeRecord shape = record(s);
      if (corners > kMostCorners && shape.kind == ShapeKind::kTriangles) shape.kind = ShapeKind::kCount;
      add_shape(table(), shape, *parts_.kernel, boxes[static_cast<std::size_t>(s)], place, row);
    }
    add_row(row);
  }
  return rows;
}

std::vector<ShapeReport> QueryScene::inspect() const {
  std::vector<ShapeReport> reports;
  for (const ShapeRecord& shape : table().placed()) {
    ShapeReport report;
    report.shape = static_cast<std::int32_t>(reports.size());
    report.is_mesh = shape.kind == ShapeKind::kTriangles;
    if (report.is_mesh) {
      report.mesh = inspect_mesh(table(), shape);
    } else {
      report.mesh.closed =
          shape.kind != ShapeKind::kCurves && bounds_solid(table(), shape, *parts_.kernel).value_or(true);
    }
    reports.push_back(std::move(report));
  }
  return reports;
}

}  // namespace tessera::render
