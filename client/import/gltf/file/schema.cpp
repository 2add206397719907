#include "import/gltf/file/schema.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace tessera::client::gltf {
namespace {

constexpr double kLargestInteger = 9007199254740991;  // 2^53 - 1: glTF's bound, too

bool is_in_list(std::string_view list, std::string_view word) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(' '), list.size());
    if (list.substr(0, end) == word) return true;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return false;
}

std::string range_text(const Member& member) {
  if (std::isinf(member.low)) return concat("at most ", member.high);
  if (std::isinf(member.high)) return concat("at least ", member.low);
  return concat("from ", member.low, " to ", member.high);
}

class FormCheck {
 public:
  explicit FormCheck(Context& context) : context_(context) {
    const Json* used = member(&context.document, "extensionsUsed");
    if (used == nullptr || !used->is_array()) return;
    for (const Json& name : *used) {
      if (name.is_string()) used_.insert(name.get<std::string>());
    }
  }

  void check_object(const Json& object, const Schema& schema, const std::string& place) {
    if (!expect(object.is_object(), object, place, "an object")) return;
    for (const Member& member : schema.members) {
      if (context_.diagnostics.full()) return;
      const auto found = object.find(member.name);
      if (found != object.end()) {
        check_member(*found, member, below(place, member.name));
      } else if (member.required) {
        context_.error(place, concat("\"", member.name, "\" is missing"));
      }
    }
    check_extensions(object, schema, place);
  }

 private:
  bool expect(bool holds, const Json& value, const std::string& place, const std::string& what) {
    if (!holds) context_.error(place, concat("expected ", what, ", found ", brief(value)));
    return holds;
  }

  static std::string brief(const Json& value) {
    if (value.is_structured()) return value.is_array() ? "an array" : "an object";
    constexpr std::size_t kMostCharacters = 40;
    const std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
    return text.size() > kMostCharacters ? text.substr(0, kMostCharacters) + "..." : text;
  }

  void check_number(const Json& value, const Member& member, const std::string& place, bool whole) {
    if (!expect(value.is_number(), value, place, whole ? "an integer" : "a number")) return;
    const double number = value.get<double>();
    if (whole && !expect(value.is_number_integer() && std::abs(number) <= kLargestInteger, value, place,
                         "an integer, without fraction or exponent"))
      return;
    expect(number >= member.low && number <= member.high, value, place, range_text(member));
  }

  void check_index(const Json& value, const Member& member, const std::string& place) {
    if (!expect(value.is_number(), value, place, "an index")) return;
    const double number = value.get<double>();
    const std::size_t count = collection_size(member.of);
    if (value.is_number_integer() && number >= 0 && number < static_cast<double>(count)) return;
    context_.error(place,
                   concat("expected an index of one of ", count, " ", member.of, ", found ", brief(value)));
  }

  /// The name of an array of the document: "meshes", or "KHR_lights_punctual/lights".
  std::size_t collection_size(const std::string& name) const {
    const std::size_t slash = name.find('/');
    const Json* array = slash == std::string::npos
                            ? member(&context_.document, name.c_str())
                            : member(extension(&context_.document, name.substr(0, slash).c_str()),
                                     name.substr(slash + 1).c_str());
    return array != nullptr && array->is_array() ? array->size() : 0;
  }

  void check_array(const Json& value, const Member& array, const std::string& place) {
    if (!expect(value.is_array(), value, place, "an array")) return;
    if (value.size() < array.least || value.size() > array.most) {
      const std::string bounds = array.least == array.most     ? concat(array.least)
                                 : array.most == Member{}.most ? concat("at least ", array.least)
                                                               : concat(array.least, " to ", array.most);
      context_.error(place, concat("expected ", bounds, " elements, found ", value.size()));
      return;
    }
    std::set<double> seen;
    std::set<std::string> seen_texts;
    for (std::size_t i = 0; i < value.size() && !context_.diagnostics.full(); ++i) {
      const Json& entry = value[i];
      const std::string at = below(place, i);
      if (array.kind == Kind::kNumbers) {
        check_number(entry, array, at, false);
      } else if (array.kind == Kind::kTexts) {
        if (expect(entry.is_string(), entry, at, "a text") &&
            !seen_texts.insert(entry.get<std::string>()).second)
          context_.error(at, concat("the text ", brief(entry), " stands there twice"));
      } else if (array.kind == Kind::kObjects) {
        check_object(entry, *find_schema(array.of), at);
      } else if (array.kind == Kind::kIndexMaps) {
        check_map(entry, array, at);
      } else {
        check_index(entry, array, at);
        if (entry.is_number() && !seen.insert(entry.get<double>()).second)
          context_.error(at, concat("the index ", brief(entry), " stands there twice"));
      }
    }
  }

  void check_map(const Json& value, const Member& map, const std::string& place) {
    if (!expect(value.is_object(), value, place, "an object")) return;
    if (value.size() < map.least) context_.error(place, "the object is empty");
    for (const auto& [name, index] : value.items()) check_index(index, map, below(place, name));
  }

  void check_member(const Json& value, const Member& member, const std::string& place) {
    switch (member.kind) {
      case Kind::kFlag:
        expect(value.is_boolean(), value, place, "true or false");
        return;
      case Kind::kInteger:
      case Kind::kNumber:
        check_number(value, member, place, member.kind == Kind::kInteger);
        return;
      case Kind::kText:
        expect(value.is_string(), value, place, "a text");
        return;
      case Kind::kWord:
        expect(value.is_string() && is_in_list(member.of, value.get<std::string>()), value, place,
               concat("one of ", member.of));
        return;
      case Kind::kCode:
        expect(value.is_number_integer() && is_in_list(member.of, concat(value.get<double>())), value, place,
               concat("one of ", member.of));
        return;
      case Kind::kIndex:
        check_index(value, member, place);
        return;
      case Kind::kObject:
        check_object(value, *find_schema(member.of), place);
        return;
      case Kind::kIndexMap:
        check_map(value, member, place);
        return;
      case Kind::kNumbers:
      case Kind::kTexts:
      case Kind::kIndices:
      case Kind::kObjects:
      case Kind::kIndexMaps:
        check_array(value, member, place);
        return;
    }
  }

  void check_extensions(const Json& object, const Schema& schema, const std::string& place) {
    const auto extensions = object.find("extensions");
    if (extensions == object.end()) return;
    const std::string at = below(place, "extensions");
    if (!expect(extensions->is_object(), *extensions, at, "an object")) return;
    for (const auto& [name, value] : extensions->items()) {
      const std::string inside = below(at, name);
      if (!expect(value.is_object(), value, inside, "an object")) continue;
      if (!used_.contains(name)) context_.error(inside, "the extension is not declared in extensionsUsed");
      if (const Schema* known = find_schema(concat(schema.name, "/", name))) {
        check_object(value, *known, inside);
      } else if (is_known_extension(name) && find_schema(concat("/", name)) == nullptr) {
        context_.error(inside, "the extension does not belong here");
      }
    }
  }

  Context& context_;
  std::set<std::string> used_;  // extensions
};

}  // namespace

void check_form(Context& context) {
  FormCheck(context).check_object(context.document, *find_schema("glTF"), "");
}

}  // namespace tessera::client::gltf
