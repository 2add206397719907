// The nodes of a scene where they stand at the time asked for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "import/geometry/motion_keys.h"
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

/// Pose and place of a node at one moment while the shutter is open.
struct LaterPose {
  std::vector<double> weights;  // as in Pose
  Imath::M44d world_from_node;
};

struct Node {
  const Json* json = nullptr;
  std::string place;
  std::string name;
  Pose pose;
  Imath::M44d world_from_node;       // when the shutter opens
  std::vector<TimedPlacing> motion;  // of it while the shutter is open; fewer than two: it stands still
  std::vector<LaterPose> later;      // at evenly spaced times until it closes; empty: it is not open
  bool is_in_scene = false;
};

/// scale, then the rotation of a unit quaternion, then translation.
Imath::M44d placing(const Imath::V3d& translation, const double (&rotation)[4], const Imath::V3d& scale);

/// All nodes, also those of other scenes: joints may be there. Reports cycles, nodes with two parents, and
/// poses that are none.
std::vector<Node> read_nodes(Context& context, AccessorTable& accessors);

/// A pose's parts that animations change.
enum class PosePart { kTranslation, kRotation, kScale, kWeights };

/// The keys of one sampler. Of a cubic spline, each has an in-tangent, a value and an out-tangent.
struct Keys {
  std::vector<float> times, values;
  std::size_t width = 0;  // numbers a value
  bool steps = false, cubic = false;

  double at(std::size_t key, std::size_t part, std::size_t i) const {
    return values[(cubic ? 3 * key + part : key) * width + i];
  }
  double value(std::size_t key, std::size_t i) const { return at(key, 1, i); }
};

struct Channel {
  std::size_t node;
  PosePart part;
  Keys keys;
};

/// The channels of the animations that `options` choose, where they have a time; checks all of them.
std::vector<Channel> read_animations(Context& context, AccessorTable& accessors,
                                     const std::vector<Node>& nodes);
/// Sets the part of a pose to what the channel has at a time, in seconds.
void apply(const Channel& channel, double time, Pose& pose);

}  // namespace tessera::client::gltf
