#include "import/mitsuba/document/transform_reader.h"

#include <cmath>
#include <initializer_list>
#include <string_view>

#include "import/input/concat.h"
#include "import/mitsuba/document/value_text.h"
#include "wire/scene_numbers.h"

namespace tessera::client::mitsuba {
namespace {

std::string check_attributes(const pugi::xml_node& node, std::initializer_list<std::string_view> known) {
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    bool found = false;
    for (const std::string_view name : known) found = found || name == attribute.name();
    if (!found) return concat("<", node.name(), "> has no attribute \"", attribute.name(), "\"");
  }
  return "";
}

std::string read_three(const pugi::xml_node& node, const char* name, Imath::V3d& vector) {
  const auto numbers = parse_floats(node.attribute(name).value());
  if (!numbers || numbers->size() != 3) {
    return concat("expected three numbers as \"", name, "\", found \"", node.attribute(name).value(), "\"");
  }
  vector = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
  return "";
}

std::string translate(const pugi::xml_node& node, Imath::M44d& transform) {
  if (std::string problem = check_attributes(node, {"x", "y", "z", "value"}); !problem.empty())
    return problem;
  Imath::V3d v;
  if (std::string problem = read_vector(node, 0, v); !problem.empty()) return problem;
  transform = transform * translation(v[0], v[1], v[2]);
  return "";
}

std::string scale(const pugi::xml_node& node, Imath::M44d& transform) {
  if (std::string problem = check_attributes(node, {"x", "y", "z", "value"}); !problem.empty())
    return problem;
  Imath::V3d v;
  if (std::string problem = read_vector(node, 1, v); !problem.empty()) return problem;
  transform = transform * scaling(v[0], v[1], v[2]);
  return "";
}

std::string rotate(const pugi::xml_node& node, Imath::M44d& transform) {
  if (std::string problem = check_attributes(node, {"x", "y", "z", "value", "angle"}); !problem.empty())
    return problem;
  Imath::V3d axis;
  if (std::string problem = read_vector(node, 0, axis); !problem.empty()) return problem;
  const std::optional<double> angle = parse_float(node.attribute("angle").value());
  if (!angle)
    return concat("expected ", wire::kSceneNumberRange, " as \"angle\", found \"",
                  node.attribute("angle").value(), "\"");
  if (!(std::hypot(axis[0], axis[1], axis[2]) > 0)) return "the axis of the rotation is zero";
  transform = transform * rotation(*angle, axis);
  return "";
}

/// A direction across `n`, as Mitsuba chooses it where nothing else is said [Duff et al. 2017].
Imath::V3d some_direction_across(const Imath::V3d& n) {
  const double sign = std::copysign(1.0, n[2]);
  const double a = -1 / (sign + n[2]);
  return {1 + sign * n[0] * n[0] * a, sign * n[0] * n[1] * a, -sign * n[0]};
}

std::string lookat(const pugi::xml_node& node, Imath::M44d& transform) {
  if (std::string problem = check_attributes(node, {"origin", "target", "up"}); !problem.empty())
    return problem;
  Imath::V3d origin, target, up = {0, 0, 0};
  if (std::string problem = read_three(node, "origin", origin); !problem.empty()) return problem;
  if (std::string problem = read_three(node, "target", target); !problem.empty()) return problem;
  if (node.attribute("up")) {
    if (std::string problem = read_three(node, "up", up); !problem.empty()) return problem;
  }
  const Imath::V3d view = {target[0] - origin[0], target[1] - origin[1], target[2] - origin[2]};
  const double distance = std::hypot(view[0], view[1], view[2]);
  if (!(distance > 0)) return "lookat: origin and target coincide";
  if (up == Imath::V3d{0, 0, 0})
    up = some_direction_across({view[0] / distance, view[1] / distance, view[2] / distance});
  const std::optional<Imath::M44d> local_from_parent = look_at(origin, target, up);
  const std::optional<Imath::M44d> parent_from_local =
      local_from_parent ? inverse(*local_from_parent) : std::nullopt;
  if (!parent_from_local) return "lookat: \"up\" is parallel to the view";
  transform = transform * *parent_from_local;
  return "";
}

std::string matrix(const pugi::xml_node& node, Imath::M44d& transform) {
  if (std::string problem = check_attributes(node, {"value"}); !problem.empty()) return problem;
  const auto numbers = parse_floats(node.attribute("value").value());
  if (!numbers) return concat("expected numbers, found \"", node.attribute("value").value(), "\"");
  if (numbers->size() != 16 && numbers->size() != 9) {
    return concat("a matrix has 16 or 9 numbers, found ", numbers->size());
  }
  const int size = numbers->size() == 16 ? 4 : 3;
  Imath::M44d m;
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) m[c][r] = (*numbers)[r * size + c];
  }
  transform = transform * m;
  return "";
}

}  // namespace

std::string read_vector(const pugi::xml_node& node, double fallback, Imath::V3d& vector) {
  vector = {fallback, fallback, fallback};
  const char* const names[] = {"x", "y", "z"};
  if (node.attribute("value")) {
    for (const char* name : names) {
      if (node.attribute(name)) return "\"value\" and x, y, z exclude each other";
    }
    const auto numbers = parse_floats(node.attribute("value").value());
    if (!numbers || (numbers->size() != 1 && numbers->size() != 3)) {
      return concat("expected one or three numbers, found \"", node.attribute("value").value(), "\"");
    }
    for (int a = 0; a < 3; ++a) vector[a] = (*numbers)[numbers->size() == 3 ? a : 0];
    return "";
  }
  for (int a = 0; a < 3; ++a) {
    if (!node.attribute(names[a])) continue;
    const std::optional<double> number = parse_float(node.attribute(names[a]).value());
    if (!number)
      return concat("expected ", wire::kSceneNumberRange, ", found \"", node.attribute(names[a]).value(),
                    "\"");
    vector[a] = *number;
  }
  return "";
}

std::string apply_operation(const pugi::xml_node& operation, Imath::M44d& transform) {
  const std::string_view name = operation.name();
  if (name == "translate") return translate(operation, transform);
  if (name == "scale") return scale(operation, transform);
  if (name == "rotate") return rotate(operation, transform);
  if (name == "lookat" || name == "lookAt" || name == "look_at") return lookat(operation, transform);
  if (name == "matrix") return matrix(operation, transform);
  return concat("<", name, "> is not a transformation: expected translate, rotate, scale, lookat or matrix");
}

}  // namespace tessera::client::mitsuba
