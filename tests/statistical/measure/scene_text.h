// Parts of scenes and meters in protobuf's text form.
#pragma once

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "support/light/closed_forms.h"

namespace tessera::test {

namespace forms = closed_forms;
using forms::Point;
using forms::operator-;

/// The number with all its digits.
inline std::string number(double x) { return absl::StrFormat("%.17g", x); }

inline std::string text_of(const Point& p) {
  return absl::StrCat("x: ", number(p[0]), " y: ", number(p[1]), " z: ", number(p[2]));
}

inline std::string point_receiver(const std::string& position, const std::string& normal) {
  return absl::StrCat("receivers { point { position { ", position, " } normal { ", normal, " } } } ");
}
inline std::string point_at(const Point& position, const Point& normal) {
  return point_receiver(text_of(position), text_of(normal));
}

/// A cell that looks along edge_u x edge_v. At an offset of 0 nothing of the scene may lie in it.
inline std::string plane_receiver(const Point& corner, const Point& edge_u, const Point& edge_v,
                                  double offset = 0) {
  return absl::StrCat("receivers { plane { corner { ", text_of(corner), " } edge_u { ", text_of(edge_u),
                      " } edge_v { ", text_of(edge_v), " } } offset: ", number(offset), " } ");
}

inline std::string surface_receiver(const std::string& shape, bool inside = false, double offset = 1e-5) {
  return absl::StrCat("receivers { surface { shape: '", shape, "' inside: ", inside ? "true" : "false",
                      " } offset: ", number(offset), " } ");
}

inline std::string irradiance_meter(const std::string& name, const std::string& receivers,
                                    const std::string& shape = "PLANE", const std::string& unit = "W/m2") {
  return absl::StrCat("meters { name: '", name, "' unit: '", unit, "' irradiance { shape: ", shape, " ",
                      receivers, "} } ");
}

inline std::string point_meter(const std::string& name, const std::string& position,
                               const std::string& normal, const std::string& shape = "PLANE",
                               const std::string& more = "") {
  return irradiance_meter(name, absl::StrCat(more, " ", point_receiver(position, normal)), shape);
}

inline std::string ray_meter(const std::string& name, const Point& from, const Point& toward) {
  return absl::StrCat("meters { name: '", name, "' unit: 'W/(m2 sr)' radiance { ray { from { ", text_of(from),
                      " } toward { ", text_of(toward), " } } } } ");
}

inline std::string grey(double value) {
  const std::string v = number(value);
  return absl::StrCat("rgb { r: ", v, " g: ", v, " b: ", v, " }");
}

/// A surface's own light, of this radiance on the side of its normal.
inline std::string glow(double radiance = 1) {
  return absl::StrCat("area_light { radiance { ", grey(radiance), " } } ");
}

inline std::string diffuse(const std::string& name, double reflectance) {
  return absl::StrCat("materials { name: '", name, "' diffuse { reflectance { constant { ", grey(reflectance),
                      " } } } } ");
}

/// A shape: its kind with its fields, and what else it has.
inline std::string shape_text(const std::string& kind, const std::string& more,
                              const std::string& material = "black") {
  return absl::StrCat("shapes { ", kind, " material: '", material, "' ", more, " } ");
}

/// A parallelogram whose normal is edge_u x edge_v.
inline std::string panel(const Point& corner, const Point& edge_u, const Point& edge_v,
                         const std::string& more = "", const std::string& material = "black") {
  std::string corners;
  for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    for (std::size_t a = 0; a < 3; ++a)
      absl::StrAppend(&corners, corners.empty() ? "" : ", ",
                      number(corner[a] + u * edge_u[a] + v * edge_v[a]));
  }
  return shape_text(absl::StrCat("polygon { corners: [", corners, "] }"), more, material);
}

/// Object space whose origin is at `middle` and whose z axis goes along `axis`, of unit length.
inline std::string placed(const Point& middle, const Point& axis) {
  const Point other = std::abs(axis[0]) < 0.5 ? Point{1, 0, 0} : Point{0, 1, 0};
  Point u = forms::cross(other, axis);
  const double size = forms::length(u);
  for (double& x : u) x /= size;
  const Point v = forms::cross(axis, u);
  std::string elements;
  for (std::size_t a = 0; a < 3; ++a)
    absl::StrAppend(&elements, number(u[a]), ", ", number(v[a]), ", ", number(axis[a]), ", ",
                    number(middle[a]), ", ");
  return absl::StrCat("world_from_object { elements: [", elements, "0, 0, 0, 1] } ");
}

inline std::string disk_text(double radius, const Point& middle, const Point& normal,
                             const std::string& more) {
  return shape_text(absl::StrCat("disk { radius: ", number(radius), " }"),
                    absl::StrCat(placed(middle, normal), more));
}

inline std::string sphere_text(double radius, const Point& middle, const std::string& more,
                               const std::string& material = "black") {
  return shape_text(absl::StrCat("sphere { radius: ", number(radius), " }"),
                    absl::StrCat(placed(middle, {0, 0, 1}), more), material);
}

/// About the z axis moved along x, from 0 to `height`.
inline std::string cylinder_text(double radius, double height, double x, const std::string& more) {
  return shape_text(absl::StrCat("cylinder { radius: ", number(radius), " z_max: ", number(height), " }"),
                    absl::StrCat(placed({x, 0, 0}, {0, 0, 1}), more));
}

/// Walls of a box, seen from its inside: normals inward.
struct Room {
  Point low, high;

  /// Walls by axis and side: -x, +x, -y, +y, -z, +z.
  struct Wall {
    Point corner, edge_u, edge_v;
  };
  Wall wall(std::size_t number) const {
    const std::size_t axis = number / 2, next = (axis + 1) % 3, last = (axis + 2) % 3;
    const bool is_high = number % 2 == 1;
    Wall w{low, {}, {}};
    if (is_high) w.corner[axis] = high[axis];
    // u x v is along the axis; from the other wall it goes against it.
    (is_high ? w.edge_v : w.edge_u)[next] = high[next] - low[next];
    (is_high ? w.edge_u : w.edge_v)[last] = high[last] - low[last];
    return w;
  }
};

}  // namespace tessera::test
