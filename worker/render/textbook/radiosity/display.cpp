#include "render/textbook/radiosity/display.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>
#include <unordered_map>

#include "base/split_mix.h"

namespace tessera::render::TESSERA_ISA::radiosity {

namespace {

using wire::SolutionPatch;
using wire::SolutionVertex;

constexpr std::uint32_t kWhole = 1u << Name::kDeepest;  // weights of corners in whole numbers
constexpr double kCosSmooth = 0.8660254037844386;       // cosine of 30 degrees

/// A point of a triangle on the finest grid that patches have.
using GridPoint = std::array<std::uint32_t, 3>;

GridPoint grid_point(const Weights& at) {
  GridPoint point;
  for (std::size_t i = 0; i < 3; ++i) point[i] = static_cast<std::uint32_t>(at.w[i] * kWhole);
  return point;
}
GridPoint middle(const GridPoint& a, const GridPoint& b) {
  return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
}

/// Equal where patches of different sides have a vertex in common.
struct VertexKey {
  std::uint64_t where, at;
  bool operator==(const VertexKey&) const = default;
};
struct VertexHash {
  std::size_t operator()(const VertexKey& key) const {
    return static_cast<std::size_t>(base::split_mix(base::split_mix(key.where) ^ key.at));
  }
};

/// Numbers for the corners of sides: neighbours that go on smoothly have the same number. A triangle without
/// area has no normal that could go on.
std::vector<std::array<std::uint32_t, 3>> join_corners(const ShapeTable& shapes, const Surfaces& surfaces) {
  struct Corner {
    Vec p, normal;
    Side side;
    std::uint32_t corner;
    std::int32_t material;
  };
  std::vector<Corner> corners;
  std::vector<std::array<std::uint32_t, 3>> numbers(surfaces.sides());
  std::uint32_t next = 0;
  for (Side side = 0; side < surfaces.sides(); ++side) {
    if (!(surfaces.area(side) > 0)) {
      numbers[side] = {next, next + 1, next + 2};
      next += 3;
      continue;
    }
    const Patch patch = surfaces.patch(Name::of_side(side));
    const auto shape = static_cast<std::size_t>(surfaces.origin(side).shape);
    for (std::uint32_t i = 0; i < 3; ++i)
      corners.push_back({patch.corner[i], patch.normal, side, i, shapes.shapes[shape].material});
  }
  const auto place = [](const Corner& c) {
    return std::tuple(c.p[0], c.p[1], c.p[2], c.material, c.side, c.corner);
  };
  std::sort(corners.begin(), corners.end(),
            [&](const Corner& a, const Corner& b) { return place(a) < place(b); });
  for (std::size_t first = 0, end; first < corners.size(); first = end) {
    for (end = first + 1; end < corners.size(); ++end) {
      const Corner &a = corners[first], &b = corners[end];
      if (a.p[0] != b.p[0] || a.p[1] != b.p[1] || a.p[2] != b.p[2] || a.material != b.material) break;
    }
    // Each joins the first before it that it goes on from.
    const std::uint32_t own = next;
    std::vector<const Corner*> leaders;
    for (std::size_t i = first; i < end; ++i) {
      const auto leader = std::find_if(leaders.begin(), leaders.end(), [&](const Corner* other) {
        return dot(other->normal, corners[i].normal) > kCosSmooth;
      });
      numbers[corners[i].side][corners[i].corner] =
          own + static_cast<std::uint32_t>(leader - leaders.begin());
      if (leader == leaders.end()) leaders.push_back(&corners[i]);
    }
    next += static_cast<std::uint32_t>(leaders.size());
  }
  return numbers;
}

/// Makes the vertices of a solution.
class Vertices {
 public:
  Vertices(const ShapeTable& shapes, const Surfaces& surfaces)
      : surfaces_(surfaces), corners_(join_corners(shapes, surfaces)) {}

  /// The vertex there, which is made where there is none, with more light. Triangles without area have none.
  std::uint32_t add(Side side, const GridPoint& at, const Forest::Node& node) {
    const auto [found, is_new] =
        numbers_.try_emplace(key(side, at), static_cast<std::uint32_t>(vertices_.size()));
    if (is_new) {
      SolutionVertex vertex{};
      const Patch whole = surfaces_.patch(Name::of_side(side));
      const Vec p = whole.point({{double(at[0]) / kWhole, double(at[1]) / kWhole, double(at[2]) / kWhole}});
      for (std::size_t i = 0; i < 3; ++i) vertex.position[i] = static_cast<float>(p[i]);
      vertices_.push_back(vertex);
      patches_.push_back(0);
    }
    const std::uint32_t number = found->second;
    if (!(surfaces_.area(side) > 0)) return number;
    ++patches_[number];
    for (int band = 0; band < kBands; ++band) {
      vertices_[number].irradiance[band] += node.irradiance.band[band];
      vertices_[number].radiosity[band] += node.radiosity.band[band];
    }
    return number;
  }

  void divide_sums() {
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (patches_[i] == 0) continue;
      for (int band = 0; band < kBands; ++band) {
        vertices_[i].irradiance[band] /= static_cast<float>(patches_[i]);
        vertices_[i].radiosity[band] /= static_cast<float>(patches_[i]);
      }
    }
  }

  /// Lets all vertices between the ends of a patch's edge have what is linear between these.
  void straighten(Side side, const GridPoint& a, const GridPoint& b) {
    const GridPoint m = middle(a, b);
    if (m == a || m == b) return;
    const auto found = numbers_.find(key(side, m));
    if (found == numbers_.end()) return;
    SolutionVertex& to = vertices_[found->second];
    const SolutionVertex& from_a = vertices_[numbers_.find(key(side, a))->second];
    const SolutionVertex& from_b = vertices_[numbers_.find(key(side, b))->second];
    for (int band = 0; band < kBands; ++band) {
      to.irradiance[band] = (from_a.irradiance[band] + from_b.irradiance[band]) / 2;
      to.radiosity[band] = (from_a.radiosity[band] + from_b.radiosity[band]) / 2;
    }
    straighten(side, a, m);
    straighten(side, m, b);
  }

  std::vector<SolutionVertex> take() { return std::move(vertices_); }

 private:
  VertexKey key(Side side, const GridPoint& at) const {
    const std::array<std::uint32_t, 3>& corner = corners_[side];
    for (std::size_t i = 0; i < 3; ++i) {
      if (at[i] == kWhole) return {corner[i], ~std::uint64_t{0}};
    }
    for (std::size_t i = 0; i < 3; ++i) {
      if (at[i] != 0) continue;
      std::size_t a = (i + 1) % 3, b = (i + 2) % 3;
      if (corner[a] == corner[b]) break;  // not told apart: the side's own
      if (corner[a] > corner[b]) std::swap(a, b);
      return {std::uint64_t{corner[a]} << 32 | corner[b], at[a]};
    }
    return {std::uint64_t{1} << 63 | side, std::uint64_t{at[0]} << 32 | at[1]};
  }

  const Surfaces& surfaces_;
  const std::vector<std::array<std::uint32_t, 3>> corners_;
  std::unordered_map<VertexKey, std::uint32_t, VertexHash> numbers_;
  std::vector<SolutionVertex> vertices_;
  std::vector<std::uint32_t> patches_;  // around each
};

}  // namespace

Solution show(const ShapeTable& shapes, const Surfaces& surfaces, const Forest& forest) {
  Solution solution;
  solution.sides = surfaces.sides();
  for (Side side = 0; side < surfaces.sides(); side += 2) solution.turned.push_back(surfaces.is_turned(side));
  Vertices vertices(shapes, surfaces);
  std::vector<std::vector<Name>> by_level(Name::kDeepest + 1);
  const auto grid_of = [](Name name) {
    const Corners corners = corners_of(name);
    return std::array{grid_point(corners.at[0]), grid_point(corners.at[1]), grid_point(corners.at[2])};
  };
  for (const Forest::Node& node : forest.nodes()) {
    if (node.first_part != 0) {
      solution.nodes.push_back(static_cast<std::int32_t>(node.first_part));
      continue;
    }
    SolutionPatch patch{};
    const auto corners = grid_of(node.name);
    for (std::size_t i = 0; i < 3; ++i) patch.corners[i] = vertices.add(node.name.side(), corners[i], node);
    for (int band = 0; band < kBands; ++band) patch.irradiance[band] = node.irradiance.band[band];
    by_level[static_cast<std::size_t>(node.name.level())].push_back(node.name);
    solution.nodes.push_back(-1 - static_cast<std::int32_t>(solution.patches.size()));
    solution.patches.push_back(patch);
  }
  vertices.divide_sums();
  // The largest first: an end of an edge may itself stand in the middle of a larger patch's.
  for (const std::vector<Name>& names : by_level) {
    for (const Name name : names) {
      const auto corners = grid_of(name);
      for (std::size_t i = 0; i < 3; ++i) vertices.straighten(name.side(), corners[i], corners[(i + 1) % 3]);
    }
  }
  solution.vertices = vertices.take();
  return solution;
}

Shown look_up(const Solution& solution, Side side, Weights at) {
  Shown shown;
  std::int32_t node = solution.nodes[side];
  while (node > 0) {
    // Into the part that has the point, in weights of its corners (corners_of).
    int part = 3;
    for (int i = 0; i < 3; ++i) {
      if (at.w[i] >= 0.5) part = i;
    }
    for (int i = 0; i < 3; ++i) at.w[i] = part == 3 ? 1 - 2 * at.w[i] : 2 * at.w[i] - (i == part ? 1 : 0);
    node = solution.nodes[static_cast<std::size_t>(node + part)];
    ++shown.patch_level;
  }
  const SolutionPatch& patch = solution.patches[static_cast<std::size_t>(-1 - node)];
  for (int corner = 0; corner < 3; ++corner) {
    const SolutionVertex& vertex = solution.vertices[patch.corners[corner]];
    for (int band = 0; band < kBands; ++band)
      shown.irradiance.band[band] += static_cast<float>(at.w[corner]) * vertex.irradiance[band];
  }
  return shown;
}

}  // namespace tessera::render::TESSERA_ISA::radiosity
