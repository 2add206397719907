// Defects that keep a mesh from being the surface of a solid.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "render/query/maps.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

enum class MeshDefect : std::uint8_t {
  kNotFinite,        // a corner of the triangle
  kDegenerate,       // a triangle without area: corners in one point or in one line
  kDuplicate,        // a triangle with the corners of one before it, in any order
  kOpenEdge,         // an edge of one triangle alone
  kCrowdedEdge,      // an edge of more than two
  kInconsistentEdge  // an edge of two, which are wound against each other: one of them shows its back
};
/// "not-finite", "degenerate", "duplicate", "open-edge", "crowded-edge", "inconsistent-edge".
std::string_view name_of(MeshDefect defect);

struct DefectPlace {
  MeshDefect defect;
  std::int32_t primitive;  // the triangle, or the first one at the edge
  std::int32_t faces = 1;  // triangles at the edge, or with these corners
  V3d from, to;            // ends of the edge; of triangles the first two corners
};

struct MeshReport {
  std::int64_t triangles = 0, vertices = 0, edges = 0;  // corners in one place are one vertex
  /// Every line crosses the mesh an even number of times: all edges have an even number of faces.
  bool closed = true;
  std::vector<DefectPlace> defects;  // sorted by kind, then in order of the triangles

  bool watertight() const { return defects.empty(); }
};

/// Corners are the same vertex where their coordinates are equal. Triangles that intersect each other are not
/// looked for.
MeshReport inspect_mesh(const ShapeTable& table, const ShapeRecord& mesh);

}  // namespace tessera::render
