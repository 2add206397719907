// The words that people write for values of the contract's enums: names of values without that of the enum,
// in lower case, with hyphens. "light selection" is LightSelection, "tree" its LIGHT_SELECTION_TREE, and
// "kd-sah" is ACCELERATOR_KD_SAH.
#pragma once

#include <google/protobuf/generated_enum_reflection.h>
#include <google/protobuf/message.h>

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace tessera::wire {

using EnumType = google::protobuf::EnumDescriptor;

/// The number itself where this version has no name for it.
std::string word_of(const EnumType& type, int number);

/// Words in the order of declaration, without that of UNSPECIFIED.
std::vector<std::string> words_of(const EnumType& type);

/// Returns what settings.proto tells people of the value with this word; empty: nothing.
std::string meaning_of(const EnumType& type, const std::string& word);

/// InvalidArgument, with the nearest word and all words, where there is no such value. `what` is the enum's
/// name for people.
absl::StatusOr<int> number_of(const EnumType& type, const std::string& word, const std::string& what);

/// "light selection" of LightSelection, "AOV" of AOV.
std::string name_of(const EnumType& type);

template <class Enum>
std::string word_of(Enum value) {
  return word_of(*google::protobuf::GetEnumDescriptor<Enum>(), value);
}

template <class Enum>
absl::StatusOr<Enum> value_of(const std::string& word) {
  const EnumType& type = *google::protobuf::GetEnumDescriptor<Enum>();
  const absl::StatusOr<int> number = number_of(type, word, name_of(type));
  if (!number.ok()) return number.status();
  return static_cast<Enum>(*number);
}

/// The value, or where it is UNSPECIFIED the default: every enum's first value after that.
template <class Enum>
Enum or_default(Enum value) {
  return value == Enum{} ? static_cast<Enum>(1) : value;
}

/// InvalidArgument, by name or number, where the message or one within it has a field, or a value of an enum,
/// that this version does not know.
absl::Status check_known(const google::protobuf::Message& message);

}  // namespace tessera::wire
