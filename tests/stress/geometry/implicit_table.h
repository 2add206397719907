// Tables of one implicit surface, and rays that pass it by little.
#pragma once

#include <string>

#include "expression/polynomial.h"
#include "render/shape/implicit/set_polynomial.h"
#include "stress/geometry/traced_table.h"

namespace tessera::render::TESSERA_ISA {

struct NamedFunction {
  const char* name;
  const char* text;
  double radius;  // radius of the ball that it is clipped to
};

inline constexpr NamedFunction kPolynomials[] = {
    {"steiner", "x^2*y^2 + y^2*z^2 + z^2*x^2 + x*y*z", 1},
    {"barth",
     "4*(((1+sqrt(5))/2)^2*x^2-y^2)*(((1+sqrt(5))/2)^2*y^2-z^2)*(((1+sqrt(5))/2)^2*z^2-x^2)"
     " - (2+sqrt(5))*(x^2+y^2+z^2-1)^2",
     1.75},
    {"heart", "(x^2 + 9/4*y^2 + z^2 - 1)^3 - x^2*z^3 - 9/80*y^2*z^3", 1.5},
    {"tangle", "x^4 - 5*x^2 + y^4 - 5*y^2 + z^4 - 5*z^2 + 11.8", 4},
    {"sphere", "x^2 + y^2 + z^2 = 1", 1.5},
    {"double", "(x^2 + y^2 + z^2 - 1)^2", 1.5},
    {"tori",
     "((x^2+y^2+z^2+1-0.45^2)^2 - 4*(x^2+y^2)) * ((x^2+y^2+z^2+1-0.3^2)^2 - 4*(x^2+y^2))"
     " * ((x^2+y^2+z^2+1-0.15^2)^2 - 4*(x^2+y^2))",
     1.5}};

/// Turned, of that size, at `at`.
inline ShapeTable implicit_table(const NamedFunction& f, ImplicitRoots roots, double size, Point at) {
  const Point x = unit({0.6, 0.64, 0.48}), y = unit(cross({0.1, -0.2, 1}, x)), z = cross(x, y);
  ImplicitRecord record;
  int row = 0;
  for (const Point axis : {x, y, z}) {
    const double a[3] = {axis.x, axis.y, axis.z};
    for (int i = 0; i < 3; ++i) {
      record.object_from_render.m[4 * row + i] = static_cast<float>(a[i] / size);
      record.render_from_object.m[4 * i + row] = static_cast<float>(a[i] * size);
    }
    record.object_from_render.m[4 * row + 3] = static_cast<float>(-dot(axis, at) / size);
    ++row;
  }
  const double shift[3] = {at.x, at.y, at.z};
  for (int i = 0; i < 3; ++i) {
    record.render_from_object.m[4 * i + 3] = static_cast<float>(shift[i]);
    record.high[i] = std::nextafter(static_cast<float>(f.radius), HUGE_VALF), record.low[i] = -record.high[i];
  }
  record.in_sphere = 1;
  record.radius = static_cast<float>(f.radius);
  record.roots = roots;
  const auto parsed = expression::parse(f.text);
  EXPECT_TRUE(parsed.ok()) << parsed.status();
  const auto program = expression::compile(*parsed);
  EXPECT_TRUE(program.ok()) << program.status();
  record.program = *program;
  if (const auto polynomial = expression::expand(*parsed)) set_polynomial(*polynomial, record);
  ShapeTable table;
  table.implicits = {record};
  ShapeRecord shape;
  shape.kind = ShapeKind::kImplicit;
  table.shapes = {shape};
  table.world_shape_count = 1;
  return table;
}

}  // namespace tessera::render::TESSERA_ISA
