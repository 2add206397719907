#include "render/query/mesh_defects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "render/query/query_structure.h"

namespace tessera::render {
namespace {

using Corners = std::array<std::int32_t, 3>;  // vertices

struct EdgeUse {
  std::int32_t low, high;  // vertices
  std::int32_t triangle;
  bool upwards;  // the triangle goes from low to high
};

/// For each of the mesh's vertices the first one in the same place.
std::vector<std::int32_t> merged_vertices(const ShapeTable& table, const ShapeRecord& mesh) {
  const Vertex* const vertices = table.vertices.data() + mesh.first_vertex;
  const auto place = [&](std::int32_t v) {
    const float* const p = vertices[v].position;
    return std::array<float, 3>{p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f};  // -0 is 0
  };
  const auto finite = [&](std::int32_t v) {
    return std::ranges::all_of(place(v), [](float x) { return std::isfinite(x); });
  };
  std::vector<std::int32_t> order(static_cast<std::size_t>(mesh.vertex_count)), merged(order.size());
  std::iota(order.begin(), order.end(), 0);
  merged = order;
  std::erase_if(order, [&](std::int32_t v) { return !finite(v); });
  std::ranges::sort(order, {}, [&](std::int32_t v) { return std::tuple_cat(place(v), std::tuple(v)); });
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (place(order[i]) == place(order[i - 1]))
      merged[static_cast<std::size_t>(order[i])] = merged[static_cast<std::size_t>(order[i - 1])];
  }
  return merged;
}

class Inspection {
 public:
  Inspection(const ShapeTable& table, const ShapeRecord& mesh) : table_(table), mesh_(mesh) {}

  MeshReport run() {
    const std::vector<std::int32_t> merged = merged_vertices(table_, mesh_);
    report_.triangles = mesh_.triangle_count;
    std::vector<bool> used(merged.size());
    std::vector<std::pair<Corners, std::int32_t>> sound;  // triangles with three vertices
    std::vector<EdgeUse> edges;
    for (std::int32_t t = 0; t < mesh_.triangle_count; ++t) {
      float p[3][3];
      triangle_corners(table_, mesh_, t, p);
      if (!all_finite(p)) {
        add(MeshDefect::kNotFinite, t, 1, p[0], p[1]);
        report_.closed = false;
        continue;
      }
      const std::uint32_t* const row =
          table_.triangles.data() +
          3 * (static_cast<std::size_t>(mesh_.first_triangle) + static_cast<std::size_t>(t));
      Corners corners{merged[row[0]], merged[row[1]], merged[row[2]]};
      if (in_one_line(p)) add(MeshDefect::kDegenerate, t, 1, p[0], p[1]);
      for (const std::int32_t v : corners) used[static_cast<std::size_t>(v)] = true;
      if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
      for (int c = 0; c < 3; ++c) {
        const std::int32_t a = corners[static_cast<std::size_t>(c)],
                           b = corners[static_cast<std::size_t>((c + 1) % 3)];
        edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
      }
      std::ranges::sort(corners);
      sound.emplace_back(corners, t);
    }
    report_.vertices = std::ranges::count(used, true);
    look_for_duplicates(sound);
    look_at_edges(edges);
    std::ranges::stable_sort(report_.defects, {},
                             [](const DefectPlace& d) { return std::tuple(d.defect, d.primitive); });
    return std::move(report_);
  }

 private:
  static bool all_finite(const float (&p)[3][3]) {
    return std::all_of(&p[0][0], &p[0][0] + 9, [](float x) { return std::isfinite(x); });
  }
  /// Exact unless coordinates differ by more than 2^29 of each other: differences and products of floats are
  /// doubles then.
  static bool in_one_line(const float (&p)[3][3]) {
    const V3d a = to_point(p[1]) - to_point(p[0]), b = to_point(p[2]) - to_point(p[0]);
    return a.cross(b) == V3d(0, 0, 0);
  }
  void add(MeshDefect defect, std::int32_t triangle, std::int32_t faces, const float* from, const float* to) {
    report_.defects.push_back({defect, triangle, faces, {from[0], from[1], from[2]}, {to[0], to[1], to[2]}});
  }
  const float* position(std::int32_t vertex) const {
    return table_.vertices[static_cast<std::size_t>(mesh_.first_vertex + vertex)].position;
  }

  void look_for_duplicates(std::vector<std::pair<Corners, std::int32_t>>& sound) {
    std::ranges::sort(sound);
    for (std::size_t begin = 0, end = 0; begin < sound.size(); begin = end) {
      while (end < sound.size() && sound[end].first == sound[begin].first) ++end;
      for (std::size_t i = begin + 1; i < end; ++i) {
        float p[3][3];
        triangle_corners(table_, mesh_, sound[i].second, p);
        add(MeshDefect::kDuplicate, sound[i].second, static_cast<std::int32_t>(end - begin), p[0], p[1]);
      }
    }
  }

  void look_at_edges(std::vector<EdgeUse>& uses) {
    std::ranges::sort(uses, {}, [](const EdgeUse& e) { return std::tuple(e.low, e.high, e.triangle); });
    for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
      std::int32_t upwards = 0;
      for (; end < uses.size() && uses[end].low == uses[begin].low && uses[end].high == uses[begin].high;
           ++end)
        upwards += uses[end].upwards;
      ++report_.edges;
      const auto faces = static_cast<std::int32_t>(end - begin);
      report_.closed = report_.closed && faces % 2 == 0;
      if (faces == 2 && upwards == 1) continue;
      const MeshDefect defect = faces == 1   ? MeshDefect::kOpenEdge
                                : faces == 2 ? MeshDefect::kInconsistentEdge
                                             : MeshDefect::kCrowdedEdge;
      add(defect, uses[begin].triangle, faces, position(uses[begin].low), position(uses[begin].high));
    }
  }

  const ShapeTable& table_;
  const ShapeRecord& mesh_;
  MeshReport report_;
};

}  // namespace

std::string_view name_of(MeshDefect defect) {
  switch (defect) {
    case MeshDefect::kNotFinite:
      return "not-finite";
    case MeshDefect::kDegenerate:
      return "degenerate";
    case MeshDefect::kDuplicate:
      return "duplicate";
    case MeshDefect::kOpenEdge:
      return "open-edge";
    case MeshDefect::kCrowdedEdge:
      return "crowded-edge";
    case MeshDefect::kInconsistentEdge:
      return "inconsistent-edge";
  }
  return "";
}

MeshReport inspect_mesh(const ShapeTable& table, const ShapeRecord& mesh) {
  return Inspection(table, mesh).run();
}

}  // namespace tessera::render
