#include "import/pbrt/shapes/implicit.h"

#include "expression/expression.h"
#include "import/input/concat.h"
#include "wire/enum_words.h"

namespace tessera::client::pbrt {
namespace {

ShapeResult refused(ValueReader& values, const std::string& why) {
  values.diagnostics().error(values.parameters().where(), concat("shape \"implicit\": ", why));
  return {};
}

v1::Point3 read_point(ValueReader& values, const char* name) {
  const Imath::V3d p = values.parameters().get_point(name, Imath::V3d(0, 0, 0), values.diagnostics());
  v1::Point3 point;
  point.set_x(p.x), point.set_y(p.y), point.set_z(p.z);
  return point;
}

}  // namespace

ShapeResult write_implicit(ValueReader& values, v1::Shape& shape) {
  v1::ImplicitSurface& surface = *shape.mutable_implicit();
  surface.set_expression(values.get_string("expression", ""));
  if (const auto parsed = expression::parse(surface.expression()); !parsed.ok())
    return refused(values, concat("expression, ", std::string(parsed.status().message())));

  ParameterList& given = values.parameters();
  if (given.has("pmin") && given.has("pmax")) {
    *surface.mutable_box()->mutable_low() = read_point(values, "pmin");
    *surface.mutable_box()->mutable_high() = read_point(values, "pmax");
  } else if (given.has("radius")) {
    surface.mutable_ball()->set_radius(values.get_float("radius", 1));
    *surface.mutable_ball()->mutable_center() = read_point(values, "center");
  } else {
    return refused(values, "expected bounds, \"point3 pmin\" and \"point3 pmax\" or \"float radius\"");
  }

  const auto roots = wire::value_of<v1::ImplicitSurface::Roots>(values.get_string("roots", "auto"));
  if (!roots.ok()) return refused(values, std::string(roots.status().message()));
  surface.set_roots(*roots);
  surface.set_lipschitz(values.get_float("lipschitz", 0));
  return {true, "", ""};
}

}  // namespace tessera::client::pbrt
