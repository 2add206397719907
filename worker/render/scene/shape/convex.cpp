#include "render/scene/shape/convex.h"

#include <algorithm>
#include <cmath>

namespace tessera::render {

namespace {

using Imath::V3d;

/// Planes closer than this, in direction and in units of the farthest one, are the same, and so are corners.
constexpr double kSame = 1e-9;
/// Faces begin this much larger than the farthest plane is away; what still reaches half of that has no end.
constexpr double kBeyond = 1e6;

/// Returns the planes with normals of unit length, each once.
std::vector<Plane> distinct(const std::vector<Plane>& planes, double& farthest) {
  std::vector<Plane> result;
  farthest = 0;
  for (Plane plane : planes) {
    const double length = plane.normal.length();
    plane.normal /= length;
    plane.offset /= length;
    farthest = std::max(farthest, std::abs(plane.offset));
    result.push_back(plane);
  }
  std::vector<Plane> kept;
  for (const Plane& plane : result) {
    const auto same = [&](const Plane& other) {
      return (other.normal - plane.normal).length() < kSame &&
             std::abs(other.offset - plane.offset) < kSame * farthest;
    };
    if (std::none_of(kept.begin(), kept.end(), same)) kept.push_back(plane);
  }
  return kept;
}

/// A square in the plane about the point of it next to the origin.
std::vector<V3d> square_in(const Plane& plane, double half) {
  const V3d& n = plane.normal;
  const V3d other = std::abs(n.x) < 0.5 ? V3d(1, 0, 0) : V3d(0, 1, 0);
  const V3d x = n.cross(other).normalized() * half, y = n.cross(x), middle = n * plane.offset;
  return {middle - x - y, middle + x - y, middle + x + y, middle - x + y};
}

/// The part of a convex polygon behind a plane [Sutherland & Hodgman 1974].
std::vector<V3d> clip(const std::vector<V3d>& polygon, const Plane& plane, double slack) {
  std::vector<V3d> kept;
  const auto above = [&](const V3d& p) { return p.dot(plane.normal) - plane.offset; };
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const double from = above(polygon[j]), to = above(polygon[i]);
    if ((from > slack) != (to > slack))
      kept.push_back(polygon[j] + (polygon[i] - polygon[j]) * (from / (from - to)));
    if (to <= slack) kept.push_back(polygon[i]);
  }
  return kept;
}

/// Makes corners that are the same equal, and leaves out those that follow one another.
void weld(std::vector<ConvexFace>& faces, double distance) {
  std::vector<V3d> known;
  for (ConvexFace& face : faces) {
    std::vector<V3d> corners;
    for (const V3d& p : face.corners) {
      const auto same = [&](const V3d& q) { return (p - q).length() < distance; };
      auto at = std::find_if(known.begin(), known.end(), same);
      if (at == known.end()) at = known.insert(known.end(), p);
      if (corners.empty() || (corners.back() != *at && corners.front() != *at)) corners.push_back(*at);
    }
    face.corners = corners;
  }
  std::erase_if(faces, [](const ConvexFace& face) { return face.corners.size() < 3; });
}

}  // namespace

absl::StatusOr<std::vector<ConvexFace>> faces_behind(const std::vector<Plane>& planes) {
  double farthest = 0;
  const std::vector<Plane> kept = distinct(planes, farthest);
  std::vector<ConvexFace> faces;
  double reach = 0;
  for (const Plane& plane : kept) {
    std::vector<V3d> polygon = square_in(plane, kBeyond * farthest);
    for (const Plane& other : kept) {
      if (&other != &plane && !polygon.empty()) polygon = clip(polygon, other, 1e-12 * farthest);
    }
    for (const V3d& p : polygon) reach = std::max(reach, p.length());
    if (polygon.size() >= 3) faces.push_back({plane, polygon});
  }
  if (reach > kBeyond / 2 * farthest) {
    return absl::InvalidArgumentError(
        "the planes of a polyhedron leave it open, or a million times too long");
  }
  weld(faces, 1e-8 * std::max(reach, 1e-300));
  if (faces.size() < 4) return absl::InvalidArgumentError("a polyhedron has nothing inside");
  return faces;
}

absl::StatusOr<std::vector<Plane>> hull_of(const std::vector<V3d>& points) {
  // Polar to the solid of planes p . point <= 1 about a point inside: its corners are the hull's planes.
  V3d middle(0, 0, 0);
  for (const V3d& p : points) middle += p / static_cast<double>(points.size());
  std::vector<Plane> polar;
  double size = 0;
  for (const V3d& p : points) size = std::max(size, (p - middle).length());
  for (const V3d& p : points) {
    // Points that close to the middle are no corners.
    if ((p - middle).length() > 1e-6 * size) polar.push_back({(p - middle) / size, 1});
  }
  const auto corners = faces_behind(polar);
  if (!corners.ok()) return absl::InvalidArgumentError("the vertices of a polyhedron lie in one plane");
  std::vector<Plane> planes;
  for (const ConvexFace& face : *corners) {
    for (const V3d& corner : face.corners) planes.push_back({corner, 1 + corner.dot(middle / size)});
  }
  for (Plane& plane : planes) plane.offset *= size;
  return planes;
}

}  // namespace tessera::render
