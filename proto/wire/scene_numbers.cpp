#include "wire/scene_numbers.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "google/protobuf/message.h"
#include "google/protobuf/reflection.h"

namespace tessera::wire {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// Of a field without presence; a name is asked for only where something is wrong.
std::string name_of(const Message& message) {
  const FieldDescriptor* name = message.GetDescriptor()->FindFieldByName("name");
  const bool known = name != nullptr && name->cpp_type() == FieldDescriptor::CPPTYPE_STRING && !name->is_repeated();
  return known ? message.GetReflection()->GetString(message, name) : std::string();
}

/// Index of the first bad number of a repeated field, -1 where all are sound.
template <typename T>
int first_bad(const google::protobuf::RepeatedFieldRef<T>& values) {
  int index = 0;
  for (const T value : values) {
    if (!is_scene_number(value)) return index;
    ++index;
  }
  return -1;
}

/// Looks at one field that holds numbers.
bool find_in_numbers(const Message& message, const FieldDescriptor* field, BadNumber& found) {
  const auto* reflection = message.GetReflection();
  const bool is_float = field->cpp_type() == FieldDescriptor::CPPTYPE_FLOAT;
  int index = -1;
  if (field->is_repeated()) {
    index = is_float ? first_bad(reflection->GetRepeatedFieldRef<float>(message, field))
                     : first_bad(reflection->GetRepeatedFieldRef<double>(message, field));
    if (index < 0) return false;
    found.value = is_float ? reflection->GetRepeatedFloat(message, field, index)
                           : reflection->GetRepeatedDouble(message, field, index);
  } else {
    found.value = is_float ? reflection->GetFloat(message, field) : reflection->GetDouble(message, field);
    if (is_scene_number(found.value)) return false;
  }
  found.path.emplace_back(field, index);
  return true;
}

/// On success the path stands in `found` from the number upwards.
bool find_in(const Message& message, BadNumber& found) {
  const auto* reflection = message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const auto type = field->cpp_type();
    if (type == FieldDescriptor::CPPTYPE_FLOAT || type == FieldDescriptor::CPPTYPE_DOUBLE) {
      if (find_in_numbers(message, field, found)) return true;
    }
    if (type != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    const int count = field->is_repeated() ? reflection->FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const Message& child = field->is_repeated() ? reflection->GetRepeatedMessage(message, field, i)
                                                  : reflection->GetMessage(message, field);
      if (!find_in(child, found)) continue;
      found.path.emplace_back(field, field->is_repeated() ? i : -1);
      if (found.element.empty()) found.element = name_of(child);
      return true;
    }
  }
  return false;
}

}  // namespace

std::string BadNumber::to_string() const {
  std::string text;
  for (const auto& [field, index] : path) {
    absl::StrAppend(&text, text.empty() ? "" : ".", std::string(field->name()));
    if (index >= 0) absl::StrAppend(&text, "[", index, "]");
  }
  if (!element.empty()) absl::StrAppend(&text, " (", element, ")");
  if (!std::isfinite(value)) return absl::StrCat(text, ": ", value, " is not finite");
  return absl::StrCat(text, ": ", value, " is beyond ", kLargestSceneNumber,
                      ", the largest magnitude of a number of a scene");
}

std::optional<BadNumber> find_bad_number(const v1::Scene& scene) {
  BadNumber found;
  if (!find_in(scene, found)) return std::nullopt;
  std::reverse(found.path.begin(), found.path.end());
  return found;
}

absl::Status check_scene_numbers(const v1::Scene& scene) {
  const auto bad = find_bad_number(scene);
  return bad ? absl::InvalidArgumentError(bad->to_string()) : absl::OkStatus();
}

}  // namespace tessera::wire
