#include "render/query/winding.h"

#include <algorithm>
#include <cmath>

#include "render/query/query_structure.h"

namespace tessera::render {
namespace {

constexpr double kPi = 3.14159265358979323846;

}  // namespace

double solid_angle(const V3d& a, const V3d& b, const V3d& c) {
  const double la = a.length(), lb = b.length(), lc = c.length();
  const double volume = a.dot(b.cross(c));
  return 2 * std::atan2(volume, la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

WindingTree::Group WindingTree::triangle_group(const Primitive& triangle) const {
  const V3d a = to_point(triangle.corners[0]), b = to_point(triangle.corners[1]),
            c = to_point(triangle.corners[2]);
  Group group;
  group.centre = (a + b + c) / 3;
  group.normal = (b - a).cross(c - a) / 2;
  group.area = group.normal.length();
  for (const V3d& corner : {a, b, c}) group.radius = std::max(group.radius, (corner - group.centre).length());
  return group;
}

WindingTree::Group WindingTree::joined(std::span<const Group> parts) {
  Group all;
  V3d middle{0, 0, 0};
  for (const Group& part : parts) {
    all.area += part.area, all.normal += part.normal;
    all.centre += part.centre * part.area, middle += part.centre;
  }
  all.centre = all.area > 0 ? all.centre / all.area : middle / static_cast<double>(parts.size());
  for (const Group& part : parts) {
    const V3d away = part.centre - all.centre;
    all.radius = std::max(all.radius, away.length() + part.radius);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) all.moment[3 * i + j] += part.moment[3 * i + j] + away[i] * part.normal[j];
    }
  }
  return all;
}

WindingTree::WindingTree(const ShapeTable& table, const ShapeRecord& mesh, int threads) {
  for (std::int32_t t = 0; t < mesh.triangle_count; ++t) {
    Primitive primitive{};
    primitive.number = t;
    triangle_corners(table, mesh, t, primitive.corners);
    if (box_of(primitive).finite()) triangles_.push_back(primitive);
  }
  tree_ = build_bvh(BvhRule::kMedian, triangles_, threads);
  groups_.resize(2 * tree_.nodes.size());
  // Children stand behind their parents.
  std::vector<Group> parts;
  for (std::size_t n = tree_.nodes.size(); n-- > 0;) {
    for (std::size_t side = 0; side < 2; ++side) {
      const std::int32_t child = tree_.nodes[n].child[side], count = tree_.nodes[n].count[side];
      parts.clear();
      if (child >= 0) {
        const std::size_t of_child = 2 * static_cast<std::size_t>(child);
        parts.assign({groups_[of_child], groups_[of_child + 1]});
        if (parts[1].area == 0 && parts[1].radius == 0) parts.pop_back();
      }
      for (std::int32_t i = 0; child < 0 && i < count; ++i)
        parts.push_back(triangle_group(triangles_[static_cast<std::size_t>(~child + i)]));
      if (!parts.empty()) groups_[2 * n + side] = joined(parts);
    }
  }
}

double WindingTree::far_away(const Group& group, const V3d& p) const {
  const V3d r = group.centre - p;
  const double squared = r.length2(), cube = squared * std::sqrt(squared);
  double trace = 0, along = 0;
  for (int i = 0; i < 3; ++i) {
    trace += group.moment[4 * i];
    for (int j = 0; j < 3; ++j) along += r[i] * group.moment[3 * i + j] * r[j];
  }
  return (group.normal.dot(r) + trace - 3 * along / squared) / cube;
}

double WindingTree::at(const V3d& p) const {
  if (tree_.nodes.empty()) return 0;
  double sum = 0;
  std::int32_t stack[kBvhDepth + 1];
  int waiting = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const auto n = static_cast<std::size_t>(stack[--waiting]);
    for (std::size_t side = 0; side < 2; ++side) {
      const Group& group = groups_[2 * n + side];
      const std::int32_t child = tree_.nodes[n].child[side], count = tree_.nodes[n].count[side];
      if ((group.centre - p).length() > kFar * group.radius) {
        if (group.area > 0) sum += far_away(group, p);
      } else if (child >= 0) {
        stack[waiting++] = child;
      } else {
        for (std::int32_t i = 0; i < count; ++i) {
          const float(&c)[3][3] = triangles_[static_cast<std::size_t>(~child + i)].corners;
          sum += solid_angle(to_point(c[0]) - p, to_point(c[1]) - p, to_point(c[2]) - p);
        }
      }
    }
  }
  return sum / (4 * kPi);
}

}  // namespace tessera::render
