// A hierarchy of lights from which one is picked by what it may bring to a point: a light tree [Conty Estevez
// & Kulla 2018], but sixteen children wide.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

inline constexpr int kLightTreeWidth = 16;

/// Sixteen children, each one light or many: where they are, where they shine, how brightly. What is not
/// there has no intensity.
struct alignas(64) LightTreeNode {
  template <class T>
  using Each = T[kLightTreeWidth];

  Each<float> centre[3] = {};  // centre of their bounding sphere, render space
  Each<float> radius = {};
  Each<float> most_spread = {};  // 1 over the square of half the radius: nearer they are not taken to be
  Each<float> axis[3] = {};      // their mean normal, weighed by intensity; unit length
  /// Length of the mean of the unit normals: 1 when all are the same, 0 when there is no telling.
  Each<float> mean = {};
  /// Cosine and sine of the largest angle off the axis at which one of them shines; -2 and 0: all around.
  Each<float> cos_reach = {}, sin_reach = {};
  Each<float> intensity = {};         // a mean over colours; lights without a normal count four times
  Each<std::int32_t> two_sided = {};  // they shine to both sides of their normals
  Each<std::int32_t> link = {};       // a node; ~light where there is only one
};
static_assert(sizeof(LightTreeNode) == 64 * 14);

struct LightTree {
  std::vector<LightTreeNode> nodes;  // the root first; empty when all lights are at infinity
  int root_children = 0;
  /// For each light, the children that lead to it, the root's in the lowest four bits.
  std::vector<std::uint32_t> paths;
  // Lights at infinity have no place among the nodes. Each is picked as often as the root.
  std::vector<std::int32_t> unbounded;
  /// For each light, the probability that it, or the root, is picked; 0 for lights in neither.
  std::vector<float> shares;

  bool empty() const { return shares.empty(); }
};

}  // namespace tessera::render
