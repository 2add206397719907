// Light that is known in closed form: view factors, irradiance of simple sources, light within closed rooms.
// Each is held against numerical integration by tests/unit/lib/photometry/closed_forms_test.cpp.
//
// A view factor is the share of the light of an evenly bright diffuse surface that reaches another: an
// element of a surface that sees a source of exitance M (radiance M / pi) with the factor F has the
// irradiance M F. Numbers are those of the catalogue [Howell 2010], where a case has one here.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

namespace tessera::closed_forms {

inline constexpr double kPi = std::numbers::pi;

using Point = std::array<double, 3>;

inline Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Point& a) { return std::sqrt(dot(a, a)); }

// ---------------------------------------------------------------- from an element of a surface

/// Parallel rectangle, a by b, c away along the normal, which passes through a corner [Howell 2010, B-3].
inline double element_to_parallel_rectangle(double a, double b, double c) {
  const double x = a / c, y = b / c, root_x = std::sqrt(1 + x * x), root_y = std::sqrt(1 + y * y);
  return (x / root_x * std::atan(y / root_x) + y / root_y * std::atan(x / root_y)) / (2 * kPi);
}

/// Rectangle across the element's plane, on which its edge of length b lies, of height a along the normal; c
/// away from the element, which faces the edge's end [Howell 2010, B-4].
inline double element_to_perpendicular_rectangle(double a, double b, double c) {
  const double x = a / b, y = c / b, root = std::hypot(x, y);
  return (std::atan(1 / y) - y / root * std::atan(1 / root)) / (2 * kPi);
}

/// Parallel disk about the normal, h away.
inline double element_to_disk(double radius, double h) { return radius * radius / (h * h + radius * radius); }

/// Parallel disk whose axis is `offset` away from the element, h away along the normal.
inline double element_to_offset_disk(double radius, double h, double offset) {
  const double H = h / offset, R = radius / offset, Z = 1 + H * H + R * R;
  return (1 - (1 + H * H - R * R) / std::sqrt(Z * Z - 4 * R * R)) / 2;
}

/// Disk in a plane along the normal, `distance` away from the element; its middle is h above the element's
/// plane, h >= radius, and nearest to the element.
inline double element_to_perpendicular_disk(double radius, double h, double distance) {
  const double H = distance / h, R = radius / h, Z = 1 + H * H + R * R;
  return H / 2 * (Z / std::sqrt(Z * Z - 4 * R * R) - 1);
}

/// Sphere whose middle is `distance` away at an angle off the normal, all of it above the element's plane.
inline double element_to_sphere(double radius, double distance, double cos_angle) {
  return radius * radius / (distance * distance) * cos_angle;
}

/// Sphere whose middle lies in the element's plane: half of it is seen.
inline double element_to_half_sphere(double radius, double distance) {
  const double h = distance / radius, root = std::sqrt(h * h - 1);
  return (std::atan(1 / root) - root / (h * h)) / kPi;
}

/// Outside of a cylinder, whose axis is h away and across the normal, which passes through the middle of an
/// end [Siegel & Howell 2002].
inline double element_to_cylinder(double radius, double height, double h) {
  const double L = height / radius, H = h / radius, X = (1 + H) * (1 + H) + L * L,
               Y = (1 - H) * (1 - H) + L * L;
  return std::atan(L / std::sqrt(H * H - 1)) / (kPi * H) +
         L / kPi *
             ((X - 2 * H) / (H * std::sqrt(X * Y)) * std::atan(std::sqrt(X * (H - 1) / (Y * (H + 1)))) -
              std::atan(std::sqrt((H - 1) / (H + 1))) / H);
}

/// Strip without ends, parallel to an axis in the element's plane, seen between two angles off the normal.
inline double element_to_strip(double angle_from, double angle_to) {
  return (std::sin(angle_to) - std::sin(angle_from)) / 2;
}

/// Any polygon above the plane of an element at the origin with normal +z: its corners in order,
/// anticlockwise as seen from the element's back [Lambert 1760].
inline double element_to_polygon(std::span<const Point> corners) {
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point &a = corners[i], &b = corners[(i + 1) % corners.size()], n = cross(a, b);
    const double size = length(n);
    if (size > 0) sum += std::atan2(size, dot(a, b)) * n[2] / size;
  }
  return std::abs(sum) / (2 * kPi);
}

// ---------------------------------------------------------------- from a small sphere

/// Rectangle a by b, c away from a point on the line through one of its corners [Howell 2010, B-106].
inline double point_to_rectangle(double a, double b, double c) {
  return std::atan(a * b / (c * std::sqrt(a * a + b * b + c * c))) / (4 * kPi);
}

/// Disk whose axis passes through the point; of a sphere of any size that does not touch it, too.
inline double sphere_to_disk(double radius, double h) { return (1 - h / std::hypot(h, radius)) / 2; }

// ---------------------------------------------------------------- between surfaces

/// Directly opposed rectangles, a by b, c apart [Howell 2010, C-11].
inline double opposed_rectangles(double a, double b, double c) {
  const double x = a / c, y = b / c, root_x = std::sqrt(1 + x * x), root_y = std::sqrt(1 + y * y);
  return 2 / (kPi * x * y) *
         (std::log(std::sqrt((1 + x * x) * (1 + y * y) / (1 + x * x + y * y))) +
          x * root_y * std::atan(x / root_y) + y * root_x * std::atan(y / root_x) - x * std::atan(x) -
          y * std::atan(y));
}

/// Parallel rectangles with parallel sides, z apart, each from one corner to the opposite: (x, y) of the
/// first and (u, v) of the second [Howell 2010, C-13].
inline double parallel_rectangles(std::array<double, 2> x, std::array<double, 2> y, std::array<double, 2> u,
                                  std::array<double, 2> v, double z) {
  const auto part = [z](double p, double q) {
    const double root_p = std::sqrt(p * p + z * z), root_q = std::sqrt(q * q + z * z);
    return (q * root_p * std::atan(q / root_p) + p * root_q * std::atan(p / root_q) -
            z * z / 2 * std::log(p * p + q * q + z * z)) /
           (2 * kPi);
  };
  double sum = 0;
  for (int i = 0; i < 16; ++i) {
    const int a = i & 1, b = i >> 1 & 1, c = i >> 2 & 1, d = i >> 3;
    const double sign = (a + b + c + d) % 2 == 0 ? 1 : -1;
    sum += sign * part(x[static_cast<std::size_t>(a)] - u[static_cast<std::size_t>(c)],
                       y[static_cast<std::size_t>(b)] - v[static_cast<std::size_t>(d)]);
  }
  return sum / ((x[1] - x[0]) * (y[1] - y[0]));
}

/// Rectangles at right angles with a common edge of length l: from the one of width w to that of height h
/// [Howell 2010, C-14].
inline double perpendicular_rectangles(double l, double w, double h) {
  const double H = h / l, W = w / l, h2 = H * H, w2 = W * W, root = std::hypot(H, W);
  return (W * std::atan(1 / W) + H * std::atan(1 / H) - root * std::atan(1 / root) +
          std::log((1 + w2) * (1 + h2) / (1 + w2 + h2) *
                   std::pow(w2 * (1 + w2 + h2) / ((1 + w2) * (w2 + h2)), w2) *
                   std::pow(h2 * (1 + w2 + h2) / ((1 + h2) * (w2 + h2)), h2)) /
              4) /
         (kPi * W);
}

/// Disks with a common axis, h apart: from the first to the second [Howell 2010, C-41; of equal ones, C-40].
inline double coaxial_disks(double first_radius, double second_radius, double h) {
  const double r1 = first_radius / h, r2 = second_radius / h, x = 1 + (1 + r2 * r2) / (r1 * r1);
  return (x - std::sqrt(x * x - 4 * (r2 / r1) * (r2 / r1))) / 2;
}

/// Within a closed cylinder: from its base to its wall.
inline double base_to_wall(double radius, double height) {
  const double h = height / (2 * radius);
  return 2 * h * (std::sqrt(1 + h * h) - h);
}

/// Within a cylinder: from its wall to itself.
inline double wall_to_itself(double radius, double height) {
  const double h = height / (2 * radius);
  return 1 + h - std::sqrt(1 + h * h);
}

/// Disk to a sphere on its axis, whose middle is h away.
inline double disk_to_sphere(double disk_radius, double sphere_radius, double h) {
  return 4 * sphere_radius * sphere_radius / (disk_radius * disk_radius) * sphere_to_disk(disk_radius, h);
}

/// Inside of a sphere to a smaller one about the same middle.
inline double sphere_to_inner_sphere(double radius, double inner_radius) {
  return inner_radius * inner_radius / (radius * radius);
}

/// Any part of the inside of a sphere to a part of this area.
inline double within_sphere(double radius, double area) { return area / (4 * kPi * radius * radius); }

/// Inside of a cone with this half-angle, without its base, to itself.
inline double cone_to_itself(double half_angle) { return 1 - std::sin(half_angle); }

/// Outside of a cylinder to the inside of a larger one about it, both of this height [Howell 2010, C-91].
inline double cylinder_to_outer_cylinder(double inner, double outer, double height) {
  const double r1 = inner / height, r2 = outer / height, a = r2 + r1, b = r2 - r1;
  return ((r2 * r2 - r1 * r1 - 1) / 2 * std::acos(r1 / r2) + kPi * r1 - kPi * a * b / 2 -
          2 * r1 * std::atan(std::sqrt(r2 * r2 - r1 * r1)) +
          std::sqrt((1 + a * a) * (1 + b * b)) * std::atan(std::sqrt((1 + a * a) * b / ((1 + b * b) * a)))) /
         (kPi * r1);
}

// ---------------------------------------------------------------- sources

/// Flux of a point of even intensity.
inline double flux_of_point(double intensity) { return 4 * kPi * intensity; }

/// Irradiance by a point: the inverse square and the cosine law.
inline double irradiance_of_point(double intensity, double distance, double cos_angle) {
  return intensity * cos_angle / (distance * distance);
}

/// Flux of a point through a disk about its axis.
inline double flux_through_disk(double intensity, double radius, double h) {
  return 2 * kPi * intensity * (1 - h / std::hypot(h, radius));
}

/// Irradiance by a surface that is seen with a factor.
inline double irradiance_of_radiance(double radiance, double factor) { return kPi * radiance * factor; }

/// Exitance, and flux, of a diffuse surface.
inline double exitance_of_radiance(double radiance) { return kPi * radiance; }
inline double flux_of_surface(double radiance, double area) { return kPi * radiance * area; }

// ---------------------------------------------------------------- closed rooms and matter

/// Irradiance of the wall of a sphere of reflectance rho by light that has been reflected, once a flux has
/// entered and met it for the first time.
inline double indirect_irradiance_in_sphere(double flux, double radius, double rho) {
  return flux / (4 * kPi * radius * radius) * rho / (1 - rho);
}

/// Radiance within a closed room all of whose walls have an exitance of their own and a reflectance: the
/// furnace.
inline double radiance_in_furnace(double own_exitance, double rho) {
  return own_exitance / (kPi * (1 - rho));
}

/// Share of light that goes through matter of this extinction [Lambert 1760; Beer 1852].
inline double transmittance(double extinction, double distance) { return std::exp(-extinction * distance); }

/// Radiance within a medium of index n, of light that enters it without loss.
inline double radiance_in_medium(double radiance_in_air, double n) { return radiance_in_air * n * n; }

/// Fresnel reflectance of a clear plate's both faces together, at right angles, all inner reflections
/// counted.
inline double transmittance_of_plate(double n) {
  const double r = (n - 1) * (n - 1) / ((n + 1) * (n + 1));
  return (1 - r) / (1 + r);
}

/// Two facing squares or disks of factor F, one with its own exitance and reflectance, one reflecting alone:
/// the radiosities (of an evenly lit pair: by means over the surfaces).
struct PairRadiosity {
  double first, second;
};
inline PairRadiosity radiosity_of_parallel_planes(double own_exitance, double rho_first, double rho_second) {
  // Planes without end: F = 1.
  const double first = own_exitance / (1 - rho_first * rho_second);
  return {first, rho_second * first};
}

}  // namespace tessera::closed_forms
