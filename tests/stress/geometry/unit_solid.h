// The shapes that are of size 1 in a space of their own, as records, and points on them.
#pragma once

#include <ostream>
#include <vector>

#include "stress/geometry/traced_table.h"

namespace tessera::render::TESSERA_ISA {

/// The six directions along the axes.
inline Point along_axis(int i) {
  double v[3] = {0, 0, 0};
  v[i / 2] = i % 2 ? 1 : -1;
  return {v[0], v[1], v[2]};
}

struct UnitSolid {
  const char* name;
  ShapeKind kind;
  QuadricRecord record;
  std::vector<Facet> facets;
};

inline void PrintTo(const UnitSolid& solid, std::ostream* out) { *out << solid.name; }

inline std::vector<UnitSolid> unit_solids() {
  std::vector<UnitSolid> solids;
  const auto add = [&](const char* name, ShapeKind kind) -> UnitSolid& {
    return solids.emplace_back(UnitSolid{name, kind, {}, {}});
  };
  add("HalfSpace", ShapeKind::kHalfSpace).record.radius = 1e9f;
  add("Box", ShapeKind::kBox);
  UnitSolid& cone = add("Cone", ShapeKind::kFrustum);
  cone.record.top_radius = 0, cone.record.capped = 1;
  UnitSolid& capped = add("CappedCylinder", ShapeKind::kFrustum);
  capped.record.capped = 1;
  UnitSolid& cut = add("CutFrustum", ShapeKind::kFrustum);
  cut.record.radius = 0.4f, cut.record.partial = 1, cut.record.phi_max = 4.2f;
  add("Torus", ShapeKind::kTorus).record.inner_radius = 0.4f;
  add("ThinTorus", ShapeKind::kTorus).record.inner_radius = 0.003f;
  UnitSolid& star = add("Polygon", ShapeKind::kPolygon);
  for (int i = 0; i < 10; ++i) {
    const double r = i % 2 ? 0.4 : 1, angle = i * M_PI / 5;
    star.facets.push_back(
        {{static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle)), 0}, 0});
  }
  UnitSolid& cut_ball = add("Polyhedron", ShapeKind::kPolyhedron);
  Numbers random(5);
  for (int i = 0; i < 30; ++i) {
    const Point n = i < 6 ? along_axis(i) : random.direction();
    cut_ball.facets.push_back({{static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)},
                               i < 6 ? 1 : static_cast<float>(0.8 + 0.2 * random())});
  }
  for (UnitSolid& solid : solids) solid.record.facet_count = static_cast<std::int32_t>(solid.facets.size());
  return solids;
}

/// A table of the solid alone, placed by `to`; `from` is the way back.
inline ShapeTable table_of(const UnitSolid& solid, const Affine& to, const Affine& from) {
  ShapeTable table;
  table.facets = solid.facets;
  table.quadrics = {solid.record};
  table.quadrics[0].render_from_object = to;
  table.quadrics[0].object_from_render = from;
  ShapeRecord shape;
  shape.kind = solid.kind;
  table.shapes = {shape};
  table.world_shape_count = 1;
  return table;
}

}  // namespace tessera::render::TESSERA_ISA
