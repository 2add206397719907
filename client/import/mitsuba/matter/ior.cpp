#include "import/mitsuba/matter/ior.h"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "import/input/concat.h"

namespace tessera::client::mitsuba {
namespace {

struct NamedIor {
  std::string_view name;
  double value;
};

// [Hecht, Optics, 4th ed.], at about 589 nm; the names and digits of Mitsuba 3.
constexpr NamedIor kNamed[] = {
    {"vacuum", 1.0},      {"helium", 1.000036},        {"hydrogen", 1.000132},
    {"air", 1.000277},    {"carbon dioxide", 1.00045}, {"water", 1.3330},
    {"acetone", 1.36},    {"ethanol", 1.361},          {"carbon tetrachloride", 1.461},
    {"glycerol", 1.4729}, {"benzene", 1.501},          {"silicone oil", 1.52045},
    {"bromine", 1.661},   {"water ice", 1.31},         {"fused quartz", 1.458},
    {"pyrex", 1.470},     {"acrylic glass", 1.49},     {"polypropylene", 1.49},
    {"bk7", 1.5046},      {"sodium chloride", 1.544},  {"amber", 1.55},
    {"pet", 1.5750},      {"diamond", 2.419}};

// Upper bound of what the renderer takes, and more than there is.
constexpr double kLeastIor = 1e-4, kLargestIor = 1e4;

double read_ior(PropertyReader& reader, std::string_view parameter, const std::string& fallback) {
  const Property* property = reader.find(parameter);
  if (property != nullptr && !std::holds_alternative<String>(property->value)) {
    const double value = reader.number(parameter, 1);
    if (value >= kLeastIor && value <= kLargestIor) return value;
    reader.error(*property, concat("expected an index of refraction from ", kLeastIor, " to ", kLargestIor,
                                   ", found ", value));
    return 1;
  }
  const std::string name = reader.keyword(parameter, fallback);
  const auto known = std::find_if(std::begin(kNamed), std::end(kNamed),
                                  [&](const NamedIor& ior) { return ior.name == name; });
  if (known != std::end(kNamed)) return known->value;
  std::string names;
  for (const NamedIor& ior : kNamed) names += concat(names.empty() ? "" : ", ", ior.name);
  reader.error(*property, concat("\"", name, "\" is not a known substance: expected a number or ", names));
  return 1;
}

}  // namespace

double read_relative_ior(PropertyReader& reader, const std::string& interior) {
  const double inside = read_ior(reader, "int_ior", interior);
  return inside / read_ior(reader, "ext_ior", "air");
}

}  // namespace tessera::client::mitsuba
