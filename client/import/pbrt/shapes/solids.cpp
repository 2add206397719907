#include "import/pbrt/shapes/solids.h"

#include "import/input/concat.h"
#include "import/pbrt/shapes/mesh_parameters.h"

namespace tessera::client::pbrt {
namespace {

float number(ValueReader& values, std::string_view name, double fallback) {
  return static_cast<float>(values.get_float(name, fallback));
}

/// Groups of `group` numbers into `out`; an error where there are fewer than `least` groups, or a rest.
bool take_groups(ValueReader& values, std::string_view name, ParameterType type, std::size_t group,
                 std::size_t least, google::protobuf::RepeatedField<float>* out) {
  const std::vector<float> numbers = read_array(values, name, {type});
  out->Add(numbers.begin(), numbers.end());
  if (numbers.size() % group == 0 && numbers.size() >= least * group) return true;
  values.diagnostics().error(values.parameters().where(),
                             concat(values.parameters().owner(), ": \"", name, "\" wants ", least,
                                    " or more times ", group, " numbers, found ", numbers.size()));
  return false;
}

}  // namespace

ShapeResult write_half_space(ValueReader& values, v1::Shape& shape) {
  shape.mutable_half_space()->set_height(number(values, "height", 0));
  return {true, "", ""};
}

ShapeResult write_cone(ValueReader& values, v1::Shape& shape) {
  v1::Cone& cone = *shape.mutable_cone();
  cone.set_radius(number(values, "radius", 1));
  cone.set_height(number(values, "height", 1));
  cone.set_top_radius(number(values, "topradius", 0));
  cone.set_capped(values.get_bool("capped", false));
  const double phi_max = values.get_float("phimax", 360);
  if (phi_max < 360) cone.set_phi_max_degrees(static_cast<float>(phi_max));
  return {true, "", ""};
}

ShapeResult write_polygon(ValueReader& values, v1::Shape& shape) {
  return {take_groups(values, "P", ParameterType::kPoint3, 3, 3, shape.mutable_polygon()->mutable_corners()),
          "", ""};
}

ShapeResult write_box(ValueReader& values, v1::Shape& shape) {
  v1::Box& box = *shape.mutable_box();
  const bool low = take_groups(values, "p0", ParameterType::kPoint3, 3, 1, box.mutable_low());
  const bool high = take_groups(values, "p1", ParameterType::kPoint3, 3, 1, box.mutable_high());
  return {low && high, "", ""};
}

ShapeResult write_polyhedron(ValueReader& values, v1::Shape& shape) {
  v1::Polyhedron& solid = *shape.mutable_polyhedron();
  const bool by_planes = values.parameters().has("planes");
  const bool sound = by_planes
                         ? take_groups(values, "planes", ParameterType::kFloat, 4, 4, solid.mutable_planes())
                         : take_groups(values, "P", ParameterType::kPoint3, 3, 4, solid.mutable_vertices());
  return {sound, "", ""};
}

ShapeResult write_torus(ValueReader& values, v1::Shape& shape) {
  shape.mutable_torus()->set_major_radius(number(values, "majorradius", 1));
  shape.mutable_torus()->set_minor_radius(number(values, "minorradius", 0.25));
  return {true, "", ""};
}

ShapeResult write_ellipsoid(ValueReader& values, v1::Shape& shape) {
  return {
      take_groups(values, "radii", ParameterType::kVector3, 3, 1, shape.mutable_ellipsoid()->mutable_radii()),
      "", ""};
}

double area_of_flat(const v1::Shape& shape, const Imath::M44d& world_from_object) {
  const auto vector = [&](double x, double y, double z) {
    Imath::V3d out;
    world_from_object.multDirMatrix(Imath::V3d(x, y, z), out);
    return out;
  };
  if (shape.has_box()) {
    const v1::Box& box = shape.box();
    const Imath::V3d x = vector(box.high(0) - box.low(0), 0, 0), y = vector(0, box.high(1) - box.low(1), 0),
                     z = vector(0, 0, box.high(2) - box.low(2));
    return 2 * (x.cross(y).length() + y.cross(z).length() + z.cross(x).length());
  }
  Imath::V3d twice(0, 0, 0);
  const auto& p = shape.polygon().corners();
  const auto from_first = [&](int i) {
    return vector(p[3 * i] - p[0], p[3 * i + 1] - p[1], p[3 * i + 2] - p[2]);
  };
  for (int i = 2; i < p.size() / 3; ++i) twice += from_first(i - 1).cross(from_first(i));
  return twice.length() / 2;
}

}  // namespace tessera::client::pbrt
