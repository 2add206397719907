// The nodes of a scene where they stand at the time asked for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "import/geometry/transform.h"
#include "import/gltf/context.h"
#include "import/gltf/file/accessors.h"

namespace tessera::client::gltf {

/// A node's own placing, by its parts or as a matrix.
struct Pose {
  std::optional<Imath::M44d> matrix;
  Imath::V3d translation{0, 0, 0}, scale{1, 1, 1};
  double rotation[4] = {0, 0, 0, 1};  // a quaternion, x y z w
  std::vector<double> weights;        // weights of morph targets; empty: those of the mesh

  Imath::M44d parent_from_node() const;
};

struct Node {
  const Json* json = nullptr;
  std::string place;
  std::string name;
  Pose pose;
  Imath::M44d world_from_node;
  bool is_in_scene = false;
};

/// scale, then the rotation of a unit quaternion, then translation.
Imath::M44d placing(const Imath::V3d& translation, const double (&rotation)[4], const Imath::V3d& scale);

/// All nodes, also those of other scenes: joints may be there. Reports cycles, nodes with two parents, and
/// poses that are none.
std::vector<Node> read_nodes(Context& context, AccessorTable& accessors);

/// Moves nodes to where the animations of `options` have them at their time (animation.cpp).
void animate(Context& context, AccessorTable& accessors, std::vector<Node>& nodes);

}  // namespace tessera::client::gltf
