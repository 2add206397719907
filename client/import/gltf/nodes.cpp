#include "import/gltf/nodes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tessera::client::gltf {
namespace {

Imath::V3d vector_of(const Json* object, const char* name, const Imath::V3d& fallback) {
  const Json* value = member(object, name);
  if (value == nullptr) return fallback;
  return {(*value)[0].get<double>(), (*value)[1].get<double>(), (*value)[2].get<double>()};
}

/// Axes at right angles to one another, none without length.
bool is_decomposable(const Imath::M44d& t) {
  const Imath::V3d axes[3] = {
      {t[0][0], t[0][1], t[0][2]}, {t[1][0], t[1][1], t[1][2]}, {t[2][0], t[2][1], t[2][2]}};
  constexpr double kRounding = 1e-3;  // error of matrices written with few digits
  for (int i = 0; i < 3; ++i) {
    const Imath::V3d &a = axes[i], &b = axes[(i + 1) % 3];
    const double lengths = length(a) * length(b);
    if (!(lengths > 0) || std::abs(a.dot(b)) > kRounding * lengths) return false;
  }
  return true;
}

void read_pose(Context& context, Node& node) {
  Pose& pose = node.pose;
  const Json* matrix = member(node.json, "matrix");
  for (const char* name : {"translation", "rotation", "scale"}) {
    if (matrix != nullptr && member(node.json, name) != nullptr)
      context.error(below(node.place, name), "a node with a matrix has no other placing");
  }
  if (matrix != nullptr) {
    pose.matrix.emplace();
    // Columns, for column vectors, become rows, for row vectors.
    for (int i = 0; i < 16; ++i)
      (*pose.matrix)[i / 4][i % 4] = (*matrix)[static_cast<std::size_t>(i)].get<double>();
    for (int i = 0; i < 4; ++i) {
      if ((*pose.matrix)[i][3] != (i == 3 ? 1 : 0)) {
        context.error(below(node.place, "matrix"), "the last row of the matrix is not 0 0 0 1");
        return;
      }
    }
    if (!is_decomposable(*pose.matrix))
      context.error(below(node.place, "matrix"), "the matrix is no scale, rotation and translation");
  }
  pose.translation = vector_of(node.json, "translation", pose.translation);
  pose.scale = vector_of(node.json, "scale", pose.scale);
  if (const Json* rotation = member(node.json, "rotation")) {
    double squared = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      pose.rotation[i] = (*rotation)[i].get<double>();
      squared += pose.rotation[i] * pose.rotation[i];
    }
    // The error of quaternions of 8 bits a component.
    if (!(std::abs(std::sqrt(squared) - 1) < 0.01))
      context.error(below(node.place, "rotation"),
                    concat("a quaternion of length ", std::sqrt(squared), ", not 1"));
  }
  for (std::size_t i = 0; i < size_of(node.json, "weights"); ++i)
    pose.weights.push_back(element(node.json, "weights", i)->get<double>());
}

/// The parent of each node; nodes.size() for roots.
std::vector<std::size_t> parents_of(Context& context, const std::vector<Node>& nodes) {
  std::vector<std::size_t> parents(nodes.size(), nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t k = 0; k < size_of(nodes[i].json, "children"); ++k) {
      const auto child = static_cast<std::size_t>(element(nodes[i].json, "children", k)->get<double>());
      if (parents[child] != nodes.size() || child == i)
        context.error(below(below(nodes[i].place, "children"), k),
                      child == i ? concat("node ", child, " is its own child")
                                 : concat("node ", child, " has another parent: node ", parents[child]));
      parents[child] = i;
    }
  }
  return parents;
}

/// Parents before children. What is in a cycle is reported, and not in the list.
std::vector<std::size_t> in_order(Context& context, const std::vector<Node>& nodes,
                                  const std::vector<std::size_t>& parents) {
  std::vector<std::size_t> order;
  std::vector<bool> met(nodes.size(), false);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (parents[i] == nodes.size()) order.push_back(i);
  }
  for (std::size_t next = 0; next < order.size(); ++next) {
    const std::size_t parent = order[next];
    const Json* const json = nodes[parent].json;
    met[parent] = true;
    for (std::size_t k = 0; k < size_of(json, "children"); ++k) {
      const auto child = static_cast<std::size_t>(element(json, "children", k)->get<double>());
      // A node that several others claim, or one twice, is met once: ways to it may be without end.
      if (parents[child] != parent || met[child]) continue;
      met[child] = true;
      order.push_back(child);
    }
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (met[i]) continue;
    context.error(below(nodes[i].place, "children"), concat("node ", i, " is among its own descendants"));
    break;
  }
  return order;
}

/// The joints of a skin hang together.
void check_joints(Context& context, const std::vector<std::size_t>& parents,
                  const std::vector<std::size_t>& order) {
  std::vector<std::size_t> roots(parents.size());
  for (const std::size_t i : order) roots[i] = parents[i] == parents.size() ? i : roots[parents[i]];
  for (std::size_t s = 0; s < size_of(&context.document, "skins"); ++s) {
    const Json* skin = element(&context.document, "skins", s);
    std::optional<std::size_t> root;
    for (std::size_t j = 0; j < size_of(skin, "joints"); ++j) {
      const std::size_t own = roots[static_cast<std::size_t>(element(skin, "joints", j)->get<double>())];
      if (!root) root = own;
      if (*root == own) continue;
      context.error(below(below("/skins", s), "joints"), "the joints have no common root");
      break;
    }
  }
}

/// The nodes that the scene names; without scenes all that have no parent.
std::vector<std::size_t> roots_of_scene(Context& context, const std::vector<std::size_t>& parents) {
  std::vector<std::size_t> roots;
  const std::size_t scenes = size_of(&context.document, "scenes");
  if (scenes == 0) {
    context.warn("", "the file has no scene: all its nodes are shown");
    for (std::size_t i = 0; i < parents.size(); ++i) {
      if (parents[i] == parents.size()) roots.push_back(i);
    }
    return roots;
  }
  const std::size_t shown = index_of(&context.document, "scene").value_or(0);
  if (scenes > 1)
    context.warn("/scenes", concat("the file has ", scenes, " scenes: number ", shown, " is shown"));
  for (std::size_t s = 0; s < scenes; ++s) {
    const Json* scene = element(&context.document, "scenes", s);
    for (std::size_t k = 0; k < size_of(scene, "nodes"); ++k) {
      const auto root = static_cast<std::size_t>(element(scene, "nodes", k)->get<double>());
      if (parents[root] != parents.size())
        context.error(below(below(below("/scenes", s), "nodes"), k),
                      concat("node ", root, " is the child of node ", parents[root], ": no root"));
      if (s == shown) roots.push_back(root);
    }
  }
  return roots;
}

/// Where animations have the nodes, at any time.
class Choreography {
 public:
  Choreography(const std::vector<Node>& nodes, const std::vector<std::size_t>& parents,
               const std::vector<Channel>& channels)
      : nodes_(nodes), parents_(parents), channels_(nodes.size()) {
    for (const Channel& channel : channels) channels_[channel.node].push_back(&channel);
  }

  Pose pose_at(std::size_t node, double time) const {
    Pose pose = nodes_[node].pose;
    for (const Channel* const channel : channels_[node]) apply(*channel, time, pose);
    return pose;
  }

  /// The placings in the world between two times; one alone where nothing moves the node.
  std::vector<TimedPlacing> motion_of(std::size_t node, double open, double close) const {
    std::vector<double> times = {0, 1};
    bool moves = false;
    for (std::size_t at = node; at != nodes_.size(); at = parents_[at]) {
      for (const Channel* const channel : channels_[at]) {
        if (channel->part == PosePart::kWeights) continue;
        moves = true;
        for (const double key : channel->keys.times) {
          // Neighbours are not told apart; a step is no bend.
          const double time = (key - open) / (close - open);
          if (time > kNear && time < 1 - kNear && !channel->keys.steps) times.push_back(time);
        }
      }
    }
    if (!moves) return {};
    std::ranges::sort(times);
    const auto last =
        std::unique(times.begin(), times.end(), [](double a, double b) { return b - a <= kNear; });
    times.erase(last, times.end());
    return followed([&](double t) { return world_at(node, open + t * (close - open)); }, std::move(times));
  }

  /// The poses that skins and morph targets follow by straight pieces, between two times.
  std::vector<LaterPose> later_poses(std::size_t node, double open, double close) const {
    constexpr int kPieces = 4;
    std::vector<LaterPose> poses;
    for (int piece = 1; piece <= kPieces; ++piece) {
      const double time = open + (close - open) * piece / kPieces;
      poses.push_back({pose_at(node, time).weights, world_at(node, time)});
    }
    return poses;
  }

 private:
  static constexpr double kNear = 1e-6;

  Imath::M44d world_at(std::size_t node, double time) const {
    Imath::M44d world = pose_at(node, time).parent_from_node();
    for (std::size_t at = parents_[node]; at != nodes_.size(); at = parents_[at])
      world = world * pose_at(at, time).parent_from_node();
    return world;
  }

  const std::vector<Node>& nodes_;
  const std::vector<std::size_t>& parents_;
  std::vector<std::vector<const Channel*>> channels_;  // by node
};

/// Moves nodes to where they are when the shutter opens, and says how they go on until it closes.
void animate(Context& context, const std::vector<Channel>& channels, const std::vector<std::size_t>& parents,
             std::vector<Node>& nodes) {
  if (channels.empty()) return;
  const Choreography animated(nodes, parents, channels);
  const GltfOptions& options = context.options;
  const double open = opening_time(options, *options.time);
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (options.shutter > 0) {
      nodes[i].motion = animated.motion_of(i, open, open + options.shutter);
      nodes[i].later = animated.later_poses(i, open, open + options.shutter);
    }
    poses.push_back(animated.pose_at(i, open));
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i].pose = std::move(poses[i]);
}

}  // namespace

Imath::M44d placing(const Imath::V3d& translation, const double (&rotation)[4], const Imath::V3d& scale) {
  const double norm = std::sqrt(rotation[0] * rotation[0] + rotation[1] * rotation[1] +
                                rotation[2] * rotation[2] + rotation[3] * rotation[3]);
  const double n = norm > 0 ? 1 / norm : 0;
  const double x = rotation[0] * n, y = rotation[1] * n, z = rotation[2] * n,
               w = norm > 0 ? rotation[3] * n : 1;
  const double rows[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
                             {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
                             {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
  Imath::M44d result;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) result[r][c] = scale[r] * rows[r][c];
    result[3][r] = translation[r];
  }
  return result;
}

Imath::M44d Pose::parent_from_node() const {
  return matrix ? *matrix : placing(translation, rotation, scale);
}

std::vector<Node> read_nodes(Context& context, AccessorTable& accessors) {
  std::vector<Node> nodes(size_of(&context.document, "nodes"));
  for (std::size_t i = 0; i < nodes.size() && !context.diagnostics.full(); ++i) {
    nodes[i].json = element(&context.document, "nodes", i);
    nodes[i].place = below("/nodes", i);
    nodes[i].name = text_of(nodes[i].json, "name");
    read_pose(context, nodes[i]);
  }
  if (context.diagnostics.has_errors()) return nodes;
  const std::vector<std::size_t> parents = parents_of(context, nodes);
  const std::vector<std::size_t> order = in_order(context, nodes, parents);
  if (context.diagnostics.has_errors()) return nodes;
  check_joints(context, parents, order);
  const std::vector<std::size_t> roots = roots_of_scene(context, parents);
  const std::vector<Channel> channels = read_animations(context, accessors, nodes);
  if (context.diagnostics.has_errors()) return nodes;
  animate(context, channels, parents, nodes);
  for (const std::size_t root : roots) nodes[root].is_in_scene = true;
  for (const std::size_t i : order) {
    Node& node = nodes[i];
    node.world_from_node = node.pose.parent_from_node();
    if (parents[i] != nodes.size()) {
      node.world_from_node = node.world_from_node * nodes[parents[i]].world_from_node;
      node.is_in_scene = node.is_in_scene || nodes[parents[i]].is_in_scene;
    }
    if (!is_finite(node.world_from_node)) context.error(node.place, "its place in the world is not finite");
  }
  return nodes;
}

}  // namespace tessera::client::gltf
