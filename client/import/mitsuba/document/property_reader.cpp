#include "import/mitsuba/document/property_reader.h"

#include <cctype>
#include <limits>

#include "import/input/concat.h"

namespace tessera::client::mitsuba {

std::string Context::unique_name(const Object& object, const std::string& kind,
                                 std::set<std::string>& taken) {
  std::string name = object.id.empty() ? kind : object.id;
  for (int i = 2; !taken.insert(name).second; ++i)
    name = concat(object.id.empty() ? kind : object.id, "-", i);
  return name;
}

std::string Context::name_with_place(const Object& object) const {
  const std::filesystem::path file = diagnostics.file_name(object.where.file);
  return concat(object.id.empty() ? object.type : object.id, ", ", file.filename().string(), ":",
                object.where.line);
}

void Context::note(const google::protobuf::Message& element, const Object& object) {
  places[&element] = {diagnostics.file_name(object.where.file), object.where.line, object.where.column,
                      concat(object.title(), ": ")};
}

bool PropertyReader::has(std::string_view name) const {
  for (const Property& property : object_.properties) {
    if (property.name == name) return true;
  }
  return false;
}

Property* PropertyReader::find(std::string_view name) {
  for (Property& property : object_.properties) {
    if (property.name != name) continue;
    property.used = true;
    return &property;
  }
  return nullptr;
}

void PropertyReader::error(const Property& property, std::string_view what) {
  diagnostics().error(property.where,
                      concat("parameter \"", property.name, "\" of ", object_.title(), ": ", what));
}

double PropertyReader::number(std::string_view name, double fallback) {
  const Property* property = find(name);
  if (property == nullptr) return fallback;
  double value = fallback;
  if (const double* number = std::get_if<double>(&property->value)) {
    value = *number;
  } else if (const std::int64_t* whole = std::get_if<std::int64_t>(&property->value)) {
    value = static_cast<double>(*whole);
  } else {
    error(*property, "expected a number");
  }
  if (value <= std::numeric_limits<float>::max() && value >= std::numeric_limits<float>::lowest())
    return value;
  error(*property, "the number is beyond the range of a float");
  return fallback;
}

std::int64_t PropertyReader::integer(std::string_view name, std::int64_t fallback) {
  const Property* property = find(name);
  if (property == nullptr) return fallback;
  if (const std::int64_t* whole = std::get_if<std::int64_t>(&property->value)) return *whole;
  error(*property, "expected an integer");
  return fallback;
}

bool PropertyReader::boolean(std::string_view name, bool fallback) {
  const Property* property = find(name);
  if (property == nullptr) return fallback;
  if (const bool* value = std::get_if<bool>(&property->value)) return *value;
  error(*property, "expected true or false");
  return fallback;
}

std::string PropertyReader::text(std::string_view name, const std::string& fallback) {
  const Property* property = find(name);
  if (property == nullptr) return fallback;
  if (const String* value = std::get_if<String>(&property->value)) return value->text;
  error(*property, "expected a string");
  return fallback;
}

std::string PropertyReader::keyword(std::string_view name, const std::string& fallback) {
  std::string word = text(name, fallback);
  for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return word;
}

Imath::M44d PropertyReader::transform(std::string_view name) {
  const Property* property = find(name);
  if (property == nullptr) return {};
  if (const Imath::M44d* value = std::get_if<Imath::M44d>(&property->value)) return *value;
  if (std::holds_alternative<Animation>(property->value)) {
    const std::vector<TimedPlacing> placings = motion(name);
    if (placings.size() > 1)
      diagnostics().warning(
          property->where,
          concat("a ", object_.title(), " does not move: it stays where it is when the shutter opens"));
    return placings.front().place;
  }
  error(*property, "expected a transform");
  return {};
}

std::vector<TimedPlacing> PropertyReader::motion(std::string_view name) {
  const Property* property = find(name);
  const auto* const animation = property == nullptr ? nullptr : std::get_if<Animation>(&property->value);
  if (animation == nullptr) return {{0, transform(name)}};
  for (const TimedPlacing& key : animation->keys) {
    if (is_decomposable(key.place)) continue;
    error(*property, concat("its transform at time ", key.time, " is singular"));
    return {{0, Imath::M44d()}};
  }
  return during_shutter(animation->keys, context_.shutter_open, context_.shutter_close);
}

std::optional<Imath::V3d> PropertyReader::vector(std::string_view name) {
  const Property* property = find(name);
  if (property == nullptr) return std::nullopt;
  if (const Imath::V3d* value = std::get_if<Imath::V3d>(&property->value)) return *value;
  error(*property, "expected a point or vector");
  return std::nullopt;
}

std::vector<Property*> PropertyReader::children(std::string_view tag) {
  std::vector<Property*> result;
  for (Property& property : object_.properties) {
    Object* const* child = std::get_if<Object*>(&property.value);
    if (child == nullptr || (*child)->tag != tag) continue;
    property.used = true;
    result.push_back(&property);
  }
  return result;
}

Object* PropertyReader::child(std::string_view tag) {
  const std::vector<Property*> found = children(tag);
  if (found.size() > 1) {
    diagnostics().error(found[1]->where,
                        concat("a second ", tag, " in the ", object_.title(), ": expected one"));
  }
  return found.empty() ? nullptr : std::get<Object*>(found.front()->value);
}

Object* PropertyReader::named_child(std::string_view name, std::string_view tag) {
  Property* property = find(name);
  if (property == nullptr) return nullptr;
  Object* const* child = std::get_if<Object*>(&property->value);
  if (child != nullptr && (*child)->tag == tag) return *child;
  error(*property, concat("expected a ", tag));
  return nullptr;
}

std::optional<std::filesystem::path> PropertyReader::file(std::string_view name) {
  const std::string file = text(name, "");
  if (file.empty()) {
    error(concat(object_.title(), ": expected a file as parameter \"", name, "\""));
    return std::nullopt;
  }
  std::filesystem::path path = context_.document.resolve(file);
  std::error_code system_error;
  if (std::filesystem::is_regular_file(path, system_error)) return path;
  error(*find(name), concat("there is no file \"", file, "\""));
  return std::nullopt;
}

void PropertyReader::ignore(std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) find(name);
}

void warn_of_unused(Context& context) {
  for (const Object& object : context.document.objects) {
    if (!object.is_read) continue;
    for (const Property& property : object.properties) {
      if (property.used) continue;
      Object* const* child = std::get_if<Object*>(&property.value);
      const std::string what = child != nullptr && property.name.empty()
                                   ? concat("the ", (*child)->title())
                                   : concat("parameter \"", property.name, "\"");
      context.diagnostics.warning(
          property.where, concat(what, " of ", object.title(), " is not known here: it has no effect"));
    }
  }
}

}  // namespace tessera::client::mitsuba
