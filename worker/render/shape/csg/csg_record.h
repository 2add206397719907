// Solids that are combined, as the kernels read them: filled by scene/shape/csg.cpp.
#pragma once

#include <cstdint>
#include <vector>

#include "render/core/affine_data.h"

namespace tessera::render {

/// A node of the tree in preorder: a solid, or a group of the nodes behind it.
///
/// A ray is inside a group where `sum` >= `threshold`, `sum` being that of the weights of the children that
/// it is inside of. That is Roth's table of each operation [Roth1982] for any number of operands: a union of
/// n has threshold 1, an intersection n, a difference 1 and weights of -1 from its second operand on.
struct CsgNode {
  // Unit space; rays that miss it are outside of the node wherever that matters to the whole. Within the
  // parent's box.
  float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
  std::int32_t parent = -1;
  std::int32_t end = 0;  // index behind its last descendant
  std::int32_t weight = 1;
  std::int32_t threshold = 1;
  std::int32_t solid = -1;          // index in CsgRecord::solids; -1: a group
  std::int32_t keeps_material = 0;  // a difference whose cut faces have the material of what is cut
};

/// One of the solids, in the order in which the scene names them.
struct CsgSolid {
  double object_from_unit[12] = {};
  std::int32_t node = 0;
  std::int32_t shape = -1;  // index of its record in ShapeTable::shapes, where no structure looks
  std::int32_t turned = 0;  // 1: its own normal points into the whole
  std::int32_t mesh = -1;   // index in CsgRecord::meshes; else a model of analytic_shape.h, or kImplicit
};

/// A closed mesh in unit space, with a tree of boxes over its triangles.
struct CsgMesh {
  struct Node {
    double low[3], high[3];
    std::int32_t first = 0, count = 0;  // a range of `order`; empty: an inner node, its first child follows
    std::int32_t second = 0;            // the second child
  };
  std::vector<double> positions;         // x y z; triangles that touch share them
  std::vector<std::uint32_t> triangles;  // three indices each
  std::vector<std::int32_t> order;       // triangles
  std::vector<Node> nodes;
};

/// The unit space has the whole in the cube from -1 to 1.
struct CsgRecord {
  Affine render_from_unit;
  Affine unit_from_render;
  float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
  std::vector<CsgNode> nodes;
  std::vector<CsgSolid> solids;
  std::vector<CsgMesh> meshes;
};

/// Surfaces that are as near to each other as this, along a ray, are at one place: what floats tell apart of
/// positions in the unit space.
inline constexpr double kCsgCoincidence = 0x1p-22;

}  // namespace tessera::render
