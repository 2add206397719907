#include "import/ply/ply_attributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>

#include "import/input/concat.h"

namespace tessera::client {
namespace {

// One naming scheme a row: the last letters of neighbouring properties.
constexpr std::array<std::string_view, 4> kSchemes = {"xyzw", "rgba", "0123", "1234"};
constexpr std::size_t kColorScheme = 1;

double linear_from_srgb(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

bool is_geometry(std::string_view name) {
  static const std::set<std::string_view> names = {"x",         "y",         "z",         "nx",       "ny",
                                                   "nz",        "u",         "v",         "s",        "t",
                                                   "texture_u", "texture_v", "texture_s", "texture_t"};
  return names.contains(name);
}

/// Collects the attributes of one element.
class Planner {
 public:
  Planner(const PlyElement& element, bool per_face, std::vector<std::string>& warnings)
      : element_(element), per_face_(per_face), warnings_(warnings) {}

  std::vector<PlyAttribute> plan() {
    add_plain_color({"r", "g", "b", "a"});
    add_plain_color({"red", "green", "blue", "alpha"});
    for (std::size_t i = 0; i < element_.properties.size();) i = plan_from(i);
    return std::move(result_);
  }

 private:
  void add(const std::string& name, std::vector<int> properties) {
    const std::string full_name = concat(per_face_ ? "face_" : "vertex_", name);
    const bool taken =
        std::any_of(result_.begin(), result_.end(), [&](const auto& a) { return a.name == full_name; });
    if (taken) {
      warnings_.push_back(concat("the attribute \"", full_name, "\" is there twice: the second is left out"));
      return;
    }
    PlyAttribute attribute;
    attribute.name = full_name;
    attribute.channels = static_cast<std::uint32_t>(properties.size());
    attribute.per_face = per_face_;
    const PlyType type = element_.properties[properties.front()].type;
    if (is_integer(type)) attribute.integer_bits = static_cast<int>(8 * byte_size(type));
    attribute.properties = std::move(properties);
    result_.push_back(std::move(attribute));
  }

  void add_plain_color(const std::array<std::string_view, 4>& names) {
    std::vector<int> properties;
    for (int c = 0; c < 3; ++c) {
      const int index = element_.find(names[c]);
      if (index < 0 || element_.properties[index].is_list) return;
      properties.push_back(index);
    }
    add("color", properties);
    for (const std::string_view name : names) plain_.insert(name);
  }

  /// Looks at property `first` and its neighbours; the index behind what was looked at.
  std::size_t plan_from(std::size_t first) {
    const PlyProperty& property = element_.properties[first];
    const std::string_view name = property.name;
    if (property.is_list || is_geometry(name) || plain_.contains(name)) return first + 1;
    if (name.size() < 3 || name[name.size() - 2] != '_') return first + 1;
    const std::string_view prefix = name.substr(0, name.size() - 2);
    std::size_t scheme = 0;
    while (scheme < kSchemes.size() && kSchemes[scheme][0] != name.back()) ++scheme;
    if (scheme == kSchemes.size()) {
      warnings_.push_back(concat("the property \"", name, "\" does not begin an attribute: left out"));
      return first + 1;
    }
    std::vector<int> properties;
    std::size_t end = first;
    for (; end < element_.properties.size() && properties.size() < 4; ++end) {
      const PlyProperty& next = element_.properties[end];
      if (next.is_list || next.name != concat(prefix, "_", kSchemes[scheme].substr(properties.size(), 1)))
        break;
      properties.push_back(static_cast<int>(end));
    }
    if (properties.size() == 4) properties.pop_back();
    if (properties.size() == 2) {
      warnings_.push_back(
          concat("the attribute \"", prefix, "\" has two channels, not one or three: left out"));
    } else {
      add(concat(prefix, scheme == kColorScheme ? "_color" : ""), std::move(properties));
    }
    return end;
  }

  const PlyElement& element_;
  const bool per_face_;
  std::vector<std::string>& warnings_;
  std::vector<PlyAttribute> result_;
  std::set<std::string_view> plain_;  // properties of colours without a prefix
};

}  // namespace

void PlyAttribute::append(const std::vector<double>& properties_of_face, std::size_t triangles) {
  for (std::size_t t = 0; t < triangles; ++t) {
    for (const int property : properties) values.push_back(static_cast<float>(properties_of_face[property]));
  }
}

absl::Status PlyAttribute::finish() {
  if (integer_bits > 0) {
    const double all_ones = std::exp2(integer_bits) - 1;
    for (float& value : values) value = static_cast<float>(linear_from_srgb(std::max(0.0, value / all_ones)));
  }
  const auto bad = std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
  if (bad == values.end()) return absl::OkStatus();
  return absl::InvalidArgumentError(concat(per_face ? "triangle " : "vertex ",
                                           (bad - values.begin()) / channels, ": its attribute \"", name,
                                           "\" is not finite"));
}

std::vector<PlyAttribute> plan_attributes(const PlyElement& element, bool per_face,
                                          std::vector<std::string>& warnings) {
  return Planner(element, per_face, warnings).plan();
}

}  // namespace tessera::client
