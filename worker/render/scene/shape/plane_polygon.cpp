#include "render/scene/shape/plane_polygon.h"

#include <algorithm>
#include <cmath>

namespace tessera::render {

namespace {

using Imath::V2d;
using Imath::V3d;

/// Twice the area of a triangle, positive where it runs counterclockwise.
double turn(const V2d& a, const V2d& b, const V2d& c) { return (b - a).cross(c - a); }

bool edges_cross(const V2d& a, const V2d& b, const V2d& c, const V2d& d) {
  return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

bool has_crossing_edges(const std::vector<V2d>& corners) {
  const std::size_t n = corners.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i + 2; k < n; ++k) {
      if (i == 0 && k == n - 1) continue;  // neighbours
      if (edges_cross(corners[i], corners[i + 1], corners[k], corners[(k + 1) % n])) return true;
    }
  }
  return false;
}

/// A polygon that loses one corner after the other.
class Remaining {
 public:
  explicit Remaining(const std::vector<V2d>& corners) : corners_(corners), left_(corners.size()) {
    const auto n = static_cast<std::uint32_t>(corners.size());
    for (std::uint32_t i = 0; i < n; ++i) {
      before_.push_back(i == 0 ? n - 1 : i - 1);
      after_.push_back(i == n - 1 ? 0 : i + 1);
    }
  }
  std::size_t left() const { return left_; }
  std::uint32_t before(std::uint32_t i) const { return before_[i]; }
  std::uint32_t after(std::uint32_t i) const { return after_[i]; }
  double turn_at(std::uint32_t i) const {
    return turn(corners_[before_[i]], corners_[i], corners_[after_[i]]);
  }
  /// Whether the triangle at corner `i` is in the polygon.
  bool is_ear(std::uint32_t i) const {
    const double area = turn_at(i);
    if (area < 0) return false;
    if (area == 0) return true;
    const V2d &a = corners_[before_[i]], &b = corners_[i], &c = corners_[after_[i]];
    for (std::uint32_t k = after_[after_[i]]; k != before_[i]; k = after_[k]) {
      const V2d& p = corners_[k];
      if (p != a && p != b && p != c && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0)
        return false;
    }
    return true;
  }
  void remove(std::uint32_t i) {
    after_[before_[i]] = after_[i];
    before_[after_[i]] = before_[i];
    --left_;
  }

 private:
  const std::vector<V2d>& corners_;
  std::vector<std::uint32_t> before_, after_;
  std::size_t left_;
};

/// The normal, as long as twice the area.
V3d area_normal(const std::vector<V3d>& corners) {
  V3d n(0, 0, 0);
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++)
    n += (corners[j] - corners[0]).cross(corners[i] - corners[0]);
  return n;
}

}  // namespace

absl::StatusOr<PlanePolygon> plane_polygon(const std::vector<V3d>& corners) {
  constexpr std::size_t kMostCorners = 4096;
  if (corners.size() < 3 || corners.size() > kMostCorners)
    return absl::InvalidArgumentError("a polygon wants 3 to 4096 corners of three numbers each");
  double size = 0;
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    if (corners[i] == corners[j])
      return absl::InvalidArgumentError("two corners of a polygon that follow one another are the same");
    size = std::max(size, (corners[i] - corners[0]).length());
  }
  const V3d area = area_normal(corners);
  if (!std::isfinite(size) || !(area.length() > 1e-10 * size * size))
    return absl::InvalidArgumentError("a polygon has no area");
  const V3d n = area.normalized(), edge = corners[1] - corners[0];
  constexpr double kFlat = 1e-5;
  for (const V3d& p : corners) {
    if (std::abs((p - corners[0]).dot(n)) > kFlat * size)
      return absl::InvalidArgumentError("the corners of a polygon do not lie in one plane");
  }
  const V3d x = (edge - n * edge.dot(n)).normalized(), y = n.cross(x);

  PlanePolygon polygon;
  V2d low(HUGE_VAL, HUGE_VAL), high(-HUGE_VAL, -HUGE_VAL);
  double height = 0;  // the plane's, in the middle of the corners
  for (const V3d& p : corners) {
    const V3d from_first = p - corners[0];
    const V2d at(from_first.dot(x), from_first.dot(y));
    height += from_first.dot(n) / static_cast<double>(corners.size());
    low = {std::min(low.x, at.x), std::min(low.y, at.y)};
    high = {std::max(high.x, at.x), std::max(high.y, at.y)};
    polygon.corners.push_back(at);
  }
  const V2d middle = (low + high) / 2;
  const double half = std::max(high.x - low.x, high.y - low.y) / 2;
  for (V2d& p : polygon.corners) p = (p - middle) / half;
  const V3d at = corners[0] + x * middle.x + y * middle.y + n * height;
  polygon.object_from_unit.m = {x.x * half, y.x * half, n.x * half, at.x,       x.y * half, y.y * half,
                                n.y * half, at.y,       x.z * half, y.z * half, n.z * half, at.z};
  const double length = edge.length();
  const double map[] = {half / length, 0, middle.x / length, 0, half / length, middle.y / length};
  std::copy(map, map + 6, polygon.uv_map);
  return polygon;
}

absl::StatusOr<std::vector<std::uint32_t>> triangulate(const std::vector<V2d>& corners) {
  const auto refused = [] {
    return absl::InvalidArgumentError("edges of a polygon cross, and so it cannot become triangles");
  };
  if (has_crossing_edges(corners)) return refused();
  // Ears are cut off one after the other [Meisters 1975].
  std::vector<std::uint32_t> triangles;
  Remaining polygon(corners);
  std::uint32_t at = 0;
  for (std::size_t since_last = 0; polygon.left() > 2;) {
    if (!polygon.is_ear(at)) {
      if (++since_last > polygon.left()) return refused();
      at = polygon.after(at);
      continue;
    }
    since_last = 0;
    if (polygon.turn_at(at) > 0)
      triangles.insert(triangles.end(), {polygon.before(at), at, polygon.after(at)});
    polygon.remove(at);
    at = polygon.after(polygon.after(at));
  }
  return triangles;
}

}  // namespace tessera::render
