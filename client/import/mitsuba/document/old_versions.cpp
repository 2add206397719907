#include "import/mitsuba/document/old_versions.h"

#include <algorithm>
#include <cctype>
#include <optional>

namespace tessera::client::mitsuba {
namespace {

bool is_lower(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }
bool is_upper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }
char to_lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

std::optional<double> take_number(Object& object, std::string_view name) {
  const auto found = std::find_if(object.properties.begin(), object.properties.end(),
                                  [&](const Property& p) { return p.name == name; });
  if (found == object.properties.end()) return std::nullopt;
  std::optional<double> number;
  if (const double* value = std::get_if<double>(&found->value)) number = *value;
  if (const std::int64_t* value = std::get_if<std::int64_t>(&found->value))
    number = static_cast<double>(*value);
  if (number) object.properties.erase(found);
  return number;
}

}  // namespace

std::string underscore_case(std::string_view camel_case) {
  std::string result;
  for (std::size_t i = 0; i < camel_case.size(); ++i) {
    if (i == 0 || !is_lower(camel_case[i - 1]) || !is_upper(camel_case[i])) {
      result.push_back(camel_case[i]);
      continue;
    }
    result.push_back('_');
    for (; i < camel_case.size() && is_upper(camel_case[i]); ++i) result.push_back(to_lower(camel_case[i]));
    --i;
  }
  return result;
}

void upgrade_from_version_1(Object& object) {
  for (Property& property : object.properties) {
    property.name = underscore_case(property.name);
    if (object.type == "diffuse" && property.name == "diffuse_reflectance") property.name = "reflectance";
  }
  const auto u_offset = take_number(object, "uoffset"), v_offset = take_number(object, "voffset");
  const auto u_scale = take_number(object, "uscale"), v_scale = take_number(object, "vscale");
  if (!u_offset && !v_offset && !u_scale && !v_scale) return;
  Property to_uv;
  to_uv.name = "to_uv";
  to_uv.where = object.where;
  to_uv.value = translation(u_offset.value_or(0), v_offset.value_or(0), 0) *
                scaling(u_scale.value_or(1), v_scale.value_or(1), 1);
  object.properties.push_back(std::move(to_uv));
}

}  // namespace tessera::client::mitsuba
