// Closed forms against numerical integration: a formula that is wrong is found here, not by the meters that
// are held against it.
#include "support/light/closed_forms.h"

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace tessera::closed_forms {
namespace {

using Hit = std::function<bool(const Point& origin, const Point& direction)>;

Point along(const Point& origin, const Point& direction, double t) {
  return {origin[0] + t * direction[0], origin[1] + t * direction[1], origin[2] + t * direction[2]};
}

struct Element {
  Point position;
  Point normal;  // unit length
  double weight = 1;
};

Point unit(const Point& v) {
  const double l = length(v);
  return {v[0] / l, v[1] / l, v[2] / l};
}

/// Points of the unit square, which fill it evenly whatever its regions' edges are parallel to [Roberts
/// 2018].
struct Square {
  double u, v;
};
Square point_of_square(int i) {
  constexpr double kRoot = 1.32471795724474602596;  // of x^3 = x + 1
  const double u = 0.5 + (i + 1) / kRoot, v = 0.5 + (i + 1) / (kRoot * kRoot);
  return {u - std::floor(u), v - std::floor(v)};
}

/// The share of `count` cosine-weighted directions that hit. The area of a region of the square is off by
/// about count^(-3/4), for its boundary's length is some units.
double element_factor(const Element& element, int count, const Hit& hit) {
  const Point& w = element.normal;
  const Point u = unit(cross(std::abs(w[0]) < 0.5 ? Point{1, 0, 0} : Point{0, 1, 0}, w)), v = cross(w, u);
  int hits = 0;
  for (int i = 0; i < count; ++i) {
    const Square square = point_of_square(i);
    const double sine = std::sqrt(square.u), cosine = std::sqrt(1 - square.u), phi = 2 * kPi * square.v;
    const double x = sine * std::cos(phi), y = sine * std::sin(phi);
    const Point direction = {x * u[0] + y * v[0] + cosine * w[0], x * u[1] + y * v[1] + cosine * w[1],
                             x * u[2] + y * v[2] + cosine * w[2]};
    hits += hit(element.position, direction);
  }
  return static_cast<double>(hits) / count;
}

constexpr int kFine = 1 << 20, kCoarse = 1 << 13;
// Three times count^(-3/4), and, of means over many elements, whose errors have many signs, half of that.
constexpr double kElementError = 1e-4, kMeanError = 1.7e-3;

/// The mean over elements by their weights.
double mean_factor(const std::vector<Element>& elements, const Hit& hit) {
  double sum = 0, weights = 0;
  for (const Element& element : elements) {
    sum += element.weight * element_factor(element, kCoarse, hit);
    weights += element.weight;
  }
  return sum / weights;
}

/// Midpoints of a rectangle, n x n.
std::vector<Element> rectangle(const Point& corner, const Point& edge_u, const Point& edge_v,
                               const Point& normal, int n = 12) {
  std::vector<Element> elements;
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k)
      elements.push_back({along(along(corner, edge_u, (i + 0.5) / n), edge_v, (k + 0.5) / n), normal});
  }
  return elements;
}

/// A disk about the z axis, seen along +z: rings by area on one radius, for what is the same all around.
std::vector<Element> disk_radius(double radius, double z, int n = 96) {
  std::vector<Element> elements;
  for (int i = 0; i < n; ++i) elements.push_back({{radius * std::sqrt((i + 0.5) / n), 0, z}, {0, 0, 1}});
  return elements;
}

/// The point of a ray on the plane where coordinate `axis` is `at`.
std::optional<Point> on_plane(const Point& o, const Point& d, std::size_t axis, double at) {
  if (d[axis] == 0) return std::nullopt;
  const double t = (at - o[axis]) / d[axis];
  if (!(t > 1e-12)) return std::nullopt;
  return along(o, d, t);
}

Hit plane_hit(std::size_t axis, double at, const std::function<bool(const Point&)>& inside) {
  return [=](const Point& o, const Point& d) {
    const auto p = on_plane(o, d, axis, at);
    return p && inside(*p);
  };
}

bool within(double x, double low, double high) { return x >= low && x <= high; }

Hit disk_hit(double z, double radius, double x = 0) {
  return plane_hit(2, z, [=](const Point& p) { return std::hypot(p[0] - x, p[1]) <= radius; });
}

Hit sphere_hit(const Point& middle, double radius) {
  return [=](const Point& o, const Point& d) {
    const Point to = middle - o;
    const double t = dot(to, d);
    return t > 0 && dot(to, to) - t * t <= radius * radius;
  };
}

/// The outside of a cylinder about the z axis, from 0 to `height`, moved by x.
Hit cylinder_hit(double radius, double height, double x = 0) {
  return [=](const Point& o, const Point& d) {
    const double ox = o[0] - x, a = d[0] * d[0] + d[1] * d[1], b = ox * d[0] + o[1] * d[1],
                 c = ox * ox + o[1] * o[1] - radius * radius, root = b * b - a * c;
    if (!(root >= 0) || a == 0) return false;
    const double t = (-b - std::sqrt(root)) / a;
    return t > 0 && within(o[2] + t * d[2], 0, height);
  };
}

const Element kUp = {{0, 0, 0}, {0, 0, 1}};

TEST(ElementFactors, OfRectangles) {
  const auto parallel =
      plane_hit(2, 0.8, [](const Point& p) { return within(p[0], 0, 1.3) && within(p[1], 0, 0.7); });
  EXPECT_NEAR(element_to_parallel_rectangle(1.3, 0.7, 0.8), element_factor(kUp, kFine, parallel),
              kElementError);
  const auto upright =
      plane_hit(0, 0.6, [](const Point& p) { return within(p[1], 0, 1.1) && within(p[2], 0, 0.9); });
  EXPECT_NEAR(element_to_perpendicular_rectangle(0.9, 1.1, 0.6), element_factor(kUp, kFine, upright),
              kElementError);
}

TEST(ElementFactors, OfPolygonsByLambert) {
  const std::vector<Point> rectangle = {{0, 0, 0.8}, {1.3, 0, 0.8}, {1.3, 0.7, 0.8}, {0, 0.7, 0.8}};
  EXPECT_NEAR(element_to_polygon(rectangle), element_to_parallel_rectangle(1.3, 0.7, 0.8), 1e-12);
  const std::vector<Point> upright = {{0.6, 0, 0}, {0.6, 1.1, 0}, {0.6, 1.1, 0.9}, {0.6, 0, 0.9}};
  EXPECT_NEAR(element_to_polygon(upright), element_to_perpendicular_rectangle(0.9, 1.1, 0.6), 1e-12);
  // A triangle in the plane x + y + z = 1, askew to everything.
  const std::vector<Point> triangle = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Hit hit = [](const Point& o, const Point& d) {
    const double across = d[0] + d[1] + d[2];
    if (!(across > 0)) return false;
    const Point p = along(o, d, 1 / across);
    return p[0] >= 0 && p[1] >= 0 && p[2] >= 0;
  };
  EXPECT_NEAR(element_to_polygon(triangle), element_factor(kUp, kFine, hit), kElementError);
}

TEST(ElementFactors, OfDisks) {
  EXPECT_NEAR(element_to_disk(0.7, 1.2), element_factor(kUp, kFine, disk_hit(1.2, 0.7)), kElementError);
  EXPECT_NEAR(element_to_offset_disk(0.7, 1.2, 1.5), element_factor(kUp, kFine, disk_hit(1.2, 0.7, 1.5)),
              kElementError);
  const auto upright = plane_hit(0, 1.1, [](const Point& p) { return std::hypot(p[1], p[2] - 0.9) <= 0.6; });
  EXPECT_NEAR(element_to_perpendicular_disk(0.6, 0.9, 1.1), element_factor(kUp, kFine, upright),
              kElementError);
}

TEST(ElementFactors, OfSpheres) {
  EXPECT_NEAR(element_to_sphere(0.5, 1.5, 1), element_factor(kUp, kFine, sphere_hit({0, 0, 1.5}, 0.5)),
              kElementError);
  // 50 degrees off the normal: the sphere ends 70 degrees off.
  const double angle = 50 * kPi / 180;
  EXPECT_NEAR(element_to_sphere(0.5, 1.5, std::cos(angle)),
              element_factor(kUp, kFine, sphere_hit({1.5 * std::sin(angle), 0, 1.5 * std::cos(angle)}, 0.5)),
              kElementError);
  EXPECT_NEAR(element_to_half_sphere(0.5, 1.5), element_factor(kUp, kFine, sphere_hit({1.5, 0, 0}, 0.5)),
              kElementError);
}

TEST(ElementFactors, OfATube) {
  // The element looks along +x at a cylinder whose lower end is at its height.
  const Element sideways = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_NEAR(element_to_cylinder(0.4, 1.7, 1.3),
              element_factor(sideways, kFine, cylinder_hit(0.4, 1.7, 1.3)), kElementError);
  EXPECT_NEAR(element_to_cylinder(0.05, 4, 1), element_factor(sideways, kFine, cylinder_hit(0.05, 4, 1)),
              kElementError);
}

TEST(ElementFactors, OfAStrip) {
  const double from = 0.3, to = 1.1;
  const Hit hit = [&](const Point&, const Point& d) { return within(std::atan2(d[0], d[2]), from, to); };
  EXPECT_NEAR(element_to_strip(from, to), element_factor(kUp, kFine, hit), kElementError);
}

TEST(PointFactors, OfRectanglesAndDisks) {
  // Directions by equal solid angle: the error is that of element_factor().
  const auto sphere_factor = [](const Hit& hit) {
    int hits = 0;
    for (int i = 0; i < kFine; ++i) {
      const Square square = point_of_square(i);
      const double z = 2 * square.u - 1, r = std::sqrt(1 - z * z), phi = 2 * kPi * square.v;
      hits += hit({0, 0, 0}, {r * std::cos(phi), r * std::sin(phi), z});
    }
    return static_cast<double>(hits) / kFine;
  };
  const auto corner =
      plane_hit(2, 0.5, [](const Point& p) { return within(p[0], 0, 1) && within(p[1], 0, 2); });
  EXPECT_NEAR(point_to_rectangle(1, 2, 0.5), sphere_factor(corner), kElementError);
  EXPECT_NEAR(sphere_to_disk(1.2, 0.7), sphere_factor(disk_hit(0.7, 1.2)), kElementError);
  EXPECT_NEAR(flux_through_disk(3, 1.2, 0.7), flux_of_point(3) * sphere_to_disk(1.2, 0.7), 1e-12);
}

TEST(SurfaceFactors, OfParallelRectangles) {
  const auto lower = rectangle({0, 0, 0}, {1.2, 0, 0}, {0, 0.8, 0}, {0, 0, 1});
  const auto opposed =
      plane_hit(2, 0.9, [](const Point& p) { return within(p[0], 0, 1.2) && within(p[1], 0, 0.8); });
  EXPECT_NEAR(opposed_rectangles(1.2, 0.8, 0.9), mean_factor(lower, opposed), kMeanError);
  EXPECT_NEAR(parallel_rectangles({0, 1.2}, {0, 0.8}, {0, 1.2}, {0, 0.8}, 0.9),
              opposed_rectangles(1.2, 0.8, 0.9), 1e-12);
  const auto offset =
      plane_hit(2, 0.9, [](const Point& p) { return within(p[0], 0.5, 2) && within(p[1], -1, 0.3); });
  EXPECT_NEAR(parallel_rectangles({0, 1.2}, {0, 0.8}, {0.5, 2}, {-1, 0.3}, 0.9), mean_factor(lower, offset),
              kMeanError);
}

TEST(SurfaceFactors, OfPerpendicularRectangles) {
  // Elements at the common edge see half of the other, whatever its size: they lie the closer, the nearer to
  // it.
  constexpr int kRows = 24;
  std::vector<Element> floor;
  for (int i = 0; i < kRows; ++i) {
    const double t = (i + 0.5) / kRows;
    for (int k = 0; k < kRows; ++k) floor.push_back({{0.7 * t * t, (k + 0.5) / kRows, 0}, {0, 0, 1}, 2 * t});
  }
  const auto wall =
      plane_hit(0, 0, [](const Point& p) { return within(p[1], 0, 1) && within(p[2], 0, 1.3); });
  EXPECT_NEAR(perpendicular_rectangles(1, 0.7, 1.3), mean_factor(floor, wall), kMeanError);
  // By reciprocity, and within a closed room of a cube's half.
  EXPECT_NEAR(0.7 * perpendicular_rectangles(1, 0.7, 1.3), 1.3 * perpendicular_rectangles(1, 1.3, 0.7),
              1e-12);
  EXPECT_NEAR(opposed_rectangles(1, 1, 1) + 4 * perpendicular_rectangles(1, 1, 1), 1, 1e-12);
}

TEST(SurfaceFactors, OfCoaxialDisks) {
  EXPECT_NEAR(coaxial_disks(0.8, 1.3, 0.6), mean_factor(disk_radius(0.8, 0), disk_hit(0.6, 1.3)), kMeanError);
  EXPECT_NEAR(coaxial_disks(0.8, 0.8, 0.6), mean_factor(disk_radius(0.8, 0), disk_hit(0.6, 0.8)), kMeanError);
}

TEST(SurfaceFactors, WithinACylinder) {
  const double radius = 0.8, height = 0.6;
  EXPECT_NEAR(base_to_wall(radius, height) + coaxial_disks(radius, radius, height), 1, 1e-12);
  std::vector<Element> wall;
  for (int i = 0; i < 96; ++i) wall.push_back({{radius, 0, height * (i + 0.5) / 96}, {-1, 0, 0}});
  // A ray from the wall inwards meets it again where it has not left through an end.
  const Hit wall_hit = [=](const Point& o, const Point& d) {
    const double across = d[0] * d[0] + d[1] * d[1];
    if (!(across > 0)) return false;
    return within(o[2] - 2 * (o[0] * d[0] + o[1] * d[1]) / across * d[2], 0, height);
  };
  EXPECT_NEAR(wall_to_itself(radius, height), mean_factor(wall, wall_hit), kMeanError);
}

TEST(SurfaceFactors, OfSpheresAndDisks) {
  EXPECT_NEAR(disk_to_sphere(0.9, 0.5, 1.2), mean_factor(disk_radius(0.9, 0), sphere_hit({0, 0, 1.2}, 0.5)),
              kMeanError);
  const Element wall = {{0, 0, -2}, {0, 0, 1}};
  EXPECT_NEAR(sphere_to_inner_sphere(2, 0.7), element_factor(wall, kFine, sphere_hit({0, 0, 0}, 0.7)),
              kElementError);
  // A cap of the same sphere, of height 0.5: its area is 2 pi R times that.
  const Hit cap = [&](const Point& o, const Point& d) { return along(o, d, -2 * dot(o, d))[2] >= 1.5; };
  EXPECT_NEAR(within_sphere(2, 2 * kPi * 2 * 0.5), element_factor(wall, kFine, cap), kElementError);
}

TEST(SurfaceFactors, WithinACone) {
  // Apex at the origin, open at z = 1: what does not leave through the base meets the wall.
  const double half_angle = 0.5, tangent = std::tan(half_angle);
  std::vector<Element> wall;
  for (int i = 0; i < 96; ++i) {
    const double z = std::sqrt((i + 0.5) / 96);
    wall.push_back({{z * tangent, 0, z}, {-std::cos(half_angle), 0, std::sin(half_angle)}});
  }
  const double through_base = mean_factor(wall, disk_hit(1, tangent));
  EXPECT_NEAR(cone_to_itself(half_angle), 1 - through_base, kMeanError);
}

TEST(SurfaceFactors, BetweenCylinders) {
  const double inner = 0.4, outer = 1, height = 0.9;
  std::vector<Element> wall;
  for (int i = 0; i < 96; ++i) wall.push_back({{inner, 0, height * (i + 0.5) / 96}, {1, 0, 0}});
  // From the outside of the inner one, nothing is in the way.
  const Hit outer_hit = [=](const Point& o, const Point& d) {
    const double a = d[0] * d[0] + d[1] * d[1], b = o[0] * d[0] + o[1] * d[1],
                 c = o[0] * o[0] + o[1] * o[1] - outer * outer;
    if (!(a > 0)) return false;
    return within(o[2] + (-b + std::sqrt(b * b - a * c)) / a * d[2], 0, height);
  };
  EXPECT_NEAR(cylinder_to_outer_cylinder(inner, outer, height), mean_factor(wall, outer_hit), kMeanError);
}

TEST(Rooms, SumsOfReflectionsAreTheirClosedForms) {
  // Light of a sphere's wall reaches all of it alike: after k reflections rho^k of it is left.
  double sum = 0, share = 1;
  for (int k = 0; k < 4000; ++k) sum += share *= 0.98;
  EXPECT_NEAR(indirect_irradiance_in_sphere(5, 2, 0.98), 5 / (16 * kPi) * sum, 1e-9);
  sum = 0, share = 1;
  for (int k = 0; k < 4000; ++k) sum += share, share *= 0.5;
  EXPECT_NEAR(radiance_in_furnace(3, 0.5), 3 * sum / kPi, 1e-12);
  // Planes that face each other.
  double first = 0, second = 0;
  for (int k = 0; k < 200; ++k) first = 3 + 0.6 * second, second = 0.7 * first;
  const PairRadiosity pair = radiosity_of_parallel_planes(3, 0.6, 0.7);
  EXPECT_NEAR(pair.first, first, 1e-12);
  EXPECT_NEAR(pair.second, second, 1e-12);
}

TEST(Matter, ThinSlabsAndInnerReflectionsAddUp) {
  double left = 1;
  const int slabs = 1 << 20;
  for (int i = 0; i < slabs; ++i) left *= 1 - 0.7 * 2 / slabs;
  EXPECT_NEAR(transmittance(0.7, 2), left, 1e-6);  // (1 - x/n)^n = e^-x (1 - x^2 / 2n)
  const double r = 0.04;                           // of one face, n = 1.5
  double through = 0, inside = 1 - r;
  for (int k = 0; k < 50; ++k) through += inside * (1 - r), inside *= r * r;
  EXPECT_NEAR(transmittance_of_plate(1.5), through, 1e-12);
  // Solid angles shrink by n^2 where light enters: Snell's law about the normal.
  const double outside = 1e-4, within_angle = outside / 1.5;
  EXPECT_NEAR(radiance_in_medium(1, 1.5), outside * outside / (within_angle * within_angle), 1e-12);
}

}  // namespace
}  // namespace tessera::closed_forms
