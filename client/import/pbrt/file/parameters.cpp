#include "import/pbrt/file/parameters.h"

#include <algorithm>
#include <iterator>

#include "import/input/concat.h"

namespace tessera::client::pbrt {
namespace {

struct TypeInfo {
  std::string_view name;
  ParameterType type;
  int numbers;
};

// The first entry of a type is its name in messages.
constexpr TypeInfo kParameterTypes[] = {
    {"integer", ParameterType::kInteger, 1}, {"float", ParameterType::kFloat, 1},
    {"point2", ParameterType::kPoint2, 2},   {"vector2", ParameterType::kVector2, 2},
    {"point3", ParameterType::kPoint3, 3},   {"vector3", ParameterType::kVector3, 3},
    {"normal", ParameterType::kNormal, 3},   {"spectrum", ParameterType::kSpectrum, 2},
    {"rgb", ParameterType::kRgb, 3},         {"blackbody", ParameterType::kBlackbody, 1},
    {"bool", ParameterType::kBool, 1},       {"string", ParameterType::kString, 0},
    {"texture", ParameterType::kTexture, 0}, {"point", ParameterType::kPoint3, 3},
    {"vector", ParameterType::kVector3, 3},  {"normal3", ParameterType::kNormal, 3}};

/// Kind of a named material: it is read where the material is defined, though no shape may ever use it, which
/// is no look yet.
constexpr std::string_view kKind = "type";

const TypeInfo& info_of(ParameterType type) {
  return *std::find_if(std::begin(kParameterTypes), std::end(kParameterTypes),
                       [&](const TypeInfo& info) { return info.type == type; });
}

}  // namespace

std::optional<ParameterType> parameter_type_of(std::string_view name) {
  for (const TypeInfo& info : kParameterTypes) {
    if (info.name == name) return info.type;
  }
  return std::nullopt;
}

std::string_view name_of(ParameterType type) { return info_of(type).name; }
int numbers_per_value(ParameterType type) { return info_of(type).numbers; }

ParameterList::ParameterList(std::vector<Parameter> parameters, const std::vector<Parameter>& defaults,
                             std::string owner, SourceLocation where, ColorSpace color_space,
                             Diagnostics& diagnostics)
    : defaults_(defaults), where_(where), color_space_(color_space) {
  own_->parameters = std::move(parameters);
  own_->owner = std::move(owner);
  own_->diagnostics = &diagnostics;
}

ParameterList::Own::~Own() {
  if (!looked_at) return;
  for (const Parameter& parameter : parameters) {
    if (parameter.used) continue;
    diagnostics->warning(parameter.where, concat("parameter \"", name_of(parameter.type), " ", parameter.name,
                                                 "\" of ", owner, " is not known: it is ignored"));
  }
}

bool ParameterList::has(std::string_view name) const {
  const auto matches = [&](const Parameter& parameter) { return parameter.name == name; };
  own_->looked_at = own_->looked_at || name != kKind;
  const std::vector<Parameter>& own = own_->parameters;
  return std::any_of(own.begin(), own.end(), matches) ||
         std::any_of(defaults_.begin(), defaults_.end(), matches);
}

const Parameter* ParameterList::find(std::string_view name, std::initializer_list<ParameterType> accepted,
                                     Diagnostics& diagnostics) {
  own_->looked_at = own_->looked_at || name != kKind;
  for (std::vector<Parameter>* list : {&own_->parameters, &defaults_}) {
    for (Parameter& parameter : *list) {
      if (parameter.name != name) continue;
      if (std::find(accepted.begin(), accepted.end(), parameter.type) != accepted.end()) {
        parameter.used = true;
        return &parameter;
      }
      if (parameter.used) return nullptr;  // reported before
      parameter.used = true;
      std::string types;
      for (const ParameterType type : accepted) types += concat(types.empty() ? "" : " or ", name_of(type));
      diagnostics.error(parameter.where, concat("parameter \"", name, "\" of ", owner(), ": expected type ",
                                                types, ", found ", name_of(parameter.type)));
      return nullptr;
    }
  }
  return nullptr;
}

std::optional<double> ParameterList::single_number(std::string_view name, ParameterType type,
                                                   Diagnostics& diagnostics) {
  const Parameter* parameter = find(name, {type}, diagnostics);
  if (parameter == nullptr) return std::nullopt;
  if (parameter->numbers.size() == 1) return parameter->numbers.front();
  diagnostics.error(parameter->where, concat("parameter \"", name, "\" of ", owner(),
                                             ": expected one value, found ", parameter->numbers.size()));
  return std::nullopt;
}

double ParameterList::get_float(std::string_view name, double fallback, Diagnostics& diagnostics) {
  return single_number(name, ParameterType::kFloat, diagnostics).value_or(fallback);
}

std::int64_t ParameterList::get_integer(std::string_view name, std::int64_t fallback,
                                        Diagnostics& diagnostics) {
  const std::optional<double> value = single_number(name, ParameterType::kInteger, diagnostics);
  return value ? static_cast<std::int64_t>(*value) : fallback;
}

bool ParameterList::get_bool(std::string_view name, bool fallback, Diagnostics& diagnostics) {
  const std::optional<double> value = single_number(name, ParameterType::kBool, diagnostics);
  return value ? *value != 0 : fallback;
}

std::string ParameterList::get_string(std::string_view name, const std::string& fallback,
                                      Diagnostics& diagnostics) {
  const Parameter* parameter = find(name, {ParameterType::kString}, diagnostics);
  if (parameter == nullptr) return fallback;
  if (parameter->strings.size() == 1) return parameter->strings.front();
  diagnostics.error(parameter->where, concat("parameter \"", name, "\" of ", owner(),
                                             ": expected one string, found ", parameter->strings.size()));
  return fallback;
}

Imath::V3d ParameterList::get_point(std::string_view name, const Imath::V3d& fallback,
                                    Diagnostics& diagnostics) {
  const Parameter* parameter = find(name, {ParameterType::kPoint3}, diagnostics);
  if (parameter == nullptr) return fallback;
  if (parameter->numbers.size() == 3)
    return {parameter->numbers[0], parameter->numbers[1], parameter->numbers[2]};
  diagnostics.error(parameter->where, concat("parameter \"", name, "\" of ", owner(),
                                             ": expected one point, found ", parameter->numbers.size() / 3));
  return fallback;
}

void ParameterList::ignore(std::initializer_list<std::string_view> names) {
  for (Parameter& parameter : own_->parameters) {
    if (std::find(names.begin(), names.end(), parameter.name) != names.end()) parameter.used = true;
  }
}

}  // namespace tessera::client::pbrt
