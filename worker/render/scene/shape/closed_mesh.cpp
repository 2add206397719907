#include "render/scene/shape/closed_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <set>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace tessera::render {

namespace {

using Position = std::array<float, 3>;

struct PositionHash {
  std::size_t operator()(const Position& p) const {
    std::size_t hash = 0;
    for (const float x : p) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, &x, sizeof bits);
      hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 29;
    }
    return hash;
  }
};

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// An edge that an odd number of triangles has.
struct OddEdge {
  Edge edge;
  std::ptrdiff_t triangles;
};

/// Each once, in order.
std::vector<OddEdge> odd_edges(const std::vector<std::uint32_t>& triangles) {
  std::vector<Edge> edges;
  edges.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[i + k], b = triangles[i + (k + 1) % 3];
      if (a != b) edges.emplace_back(std::min(a, b), std::max(a, b));
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<OddEdge> odd;
  for (auto first = edges.begin(); first != edges.end();) {
    const auto last = std::upper_bound(first, edges.end(), *first);
    if ((last - first) % 2 != 0) odd.push_back({*first, last - first});
    first = last;
  }
  return odd;
}

/// The first triangle that has the same three corners as one before it; -1 where there is none.
std::ptrdiff_t first_twin(const std::vector<std::uint32_t>& triangles) {
  std::set<std::array<std::uint32_t, 3>> known;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    std::array<std::uint32_t, 3> corners{triangles[i], triangles[i + 1], triangles[i + 2]};
    std::ranges::sort(corners);
    if (!known.insert(corners).second) return static_cast<std::ptrdiff_t>(i / 3);
  }
  return -1;
}

absl::Status error_of(std::vector<OddEdge> odd, const std::vector<std::uint32_t>& triangles,
                      const std::vector<Position>& positions) {
  const auto is_open = [](const OddEdge& one) { return one.triangles == 1; };
  const bool open = std::ranges::any_of(odd, is_open);
  if (open) std::erase_if(odd, [&](const OddEdge& one) { return !is_open(one); });
  std::string places;
  constexpr std::size_t kMostPlaces = 3;
  for (std::size_t i = 0; i < std::min(odd.size(), kMostPlaces); ++i) {
    const Position &a = positions[odd[i].edge.first], &b = positions[odd[i].edge.second];
    absl::StrAppendFormat(&places, "%s(%g, %g, %g) to (%g, %g, %g)", i == 0 ? "" : "; ", a[0], a[1], a[2],
                          b[0], b[1], b[2]);
  }
  if (odd.size() > kMostPlaces) places += "; and others";
  const bool one = odd.size() == 1;
  if (open) {
    return absl::InvalidArgumentError(absl::StrCat("its mesh is not closed: ", odd.size(),
                                                   one ? " edge is" : " edges are", " open, from ", places));
  }
  const std::ptrdiff_t twin = first_twin(triangles);
  return absl::InvalidArgumentError(absl::StrCat(
      "its mesh bounds no solid: ",
      twin < 0 ? "" : absl::StrCat("triangle ", twin + 1, " is there twice, so that "), odd.size(),
      one ? " edge has" : " edges have", " an odd number of triangles, from ", places));
}

/// Boxes about halves of triangles in order of their middles, along the longest axis.
class TreeBuilder {
 public:
  explicit TreeBuilder(CsgMesh& mesh) : mesh_(mesh) {
    mesh_.order.resize(mesh.triangles.size() / 3);
    std::iota(mesh_.order.begin(), mesh_.order.end(), 0);
    build(0, static_cast<std::int32_t>(mesh_.order.size()));
  }

 private:
  const double* corner(std::int32_t triangle, std::size_t k) const {
    return mesh_.positions.data() +
           std::size_t{3} * mesh_.triangles[std::size_t{3} * static_cast<std::size_t>(triangle) + k];
  }
  double middle(std::int32_t triangle, int axis) const {
    return corner(triangle, 0)[axis] + corner(triangle, 1)[axis] + corner(triangle, 2)[axis];
  }

  void build(std::int32_t first, std::int32_t count) {
    constexpr std::int32_t kMostInLeaf = 4;
    const std::size_t index = mesh_.nodes.size();
    CsgMesh::Node& node = mesh_.nodes.emplace_back();
    std::fill_n(node.low, 3, HUGE_VAL);
    std::fill_n(node.high, 3, -HUGE_VAL);
    for (std::int32_t i = first; i < first + count; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double* p = corner(mesh_.order[static_cast<std::size_t>(i)], k);
        // A little wider than what roundings of the test take off.
        for (int a = 0; a < 3; ++a) {
          node.low[a] = std::min(node.low[a], p[a] - 1e-9),
          node.high[a] = std::max(node.high[a], p[a] + 1e-9);
        }
      }
    }
    if (count <= kMostInLeaf) {
      node.first = first, node.count = count;
      return;
    }
    int axis = 0;
    for (int a = 1; a < 3; ++a) {
      if (node.high[a] - node.low[a] > node.high[axis] - node.low[axis]) axis = a;
    }
    const std::int32_t half = count / 2;
    const auto begin = mesh_.order.begin() + first;
    std::nth_element(begin, begin + half, begin + count, [&](std::int32_t a, std::int32_t b) {
      return std::pair(middle(a, axis), a) < std::pair(middle(b, axis), b);
    });
    build(first, half);
    mesh_.nodes[index].second = static_cast<std::int32_t>(mesh_.nodes.size());
    build(first + half, count - half);
  }

  CsgMesh& mesh_;
};

}  // namespace

absl::StatusOr<CsgMesh> closed_mesh(const wire::MeshView& mesh, const Transform& placed_from_object) {
  CsgMesh solid;
  std::vector<Position> positions;
  std::vector<std::uint32_t> welded(mesh.vertex_count());
  std::unordered_map<Position, std::uint32_t, PositionHash> known;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    Position p;
    for (std::size_t a = 0; a < 3; ++a) p[a] = mesh.positions[3 * i + a] + 0.0f;  // -0 is 0
    const auto [found, is_new] = known.try_emplace(p, static_cast<std::uint32_t>(positions.size()));
    welded[i] = found->second;
    if (!is_new) continue;
    positions.push_back(p);
    const Imath::V3d placed = placed_from_object.apply({p[0], p[1], p[2]});
    for (const double x : {placed.x, placed.y, placed.z}) {
      if (!std::isfinite(x)) return absl::InvalidArgumentError("a vertex is not finite once it is placed");
      solid.positions.push_back(x);
    }
  }
  for (const std::uint32_t index : mesh.indices) solid.triangles.push_back(welded[index]);
  if (std::vector<OddEdge> odd = odd_edges(solid.triangles); !odd.empty())
    return error_of(std::move(odd), solid.triangles, positions);
  if (solid.triangles.empty()) return absl::InvalidArgumentError("its mesh has no triangles");
  TreeBuilder{solid};
  return solid;
}

}  // namespace tessera::render
