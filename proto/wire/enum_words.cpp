#include "wire/enum_words.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/unknown_field_set.h>

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/nearest_name.h"
#include "tessera/v1/setting.pb.h"

namespace tessera::wire {
namespace {

using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

/// "LightSelection" with `separator` between its words; a row of capitals is one.
std::string spaced(const std::string& name, char separator) {
  std::string words;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const bool begins = i > 0 && absl::ascii_isupper(static_cast<unsigned char>(name[i])) &&
                        absl::ascii_islower(static_cast<unsigned char>(name[i - 1]));
    if (begins) words += separator;
    words += name[i];
  }
  return words;
}

std::string word_for(const EnumValueDescriptor& value) {
  const std::string prefix = absl::AsciiStrToUpper(spaced(value.type()->name(), '_')) + "_";
  const std::string& name = value.name();
  std::string word = absl::AsciiStrToLower(name.starts_with(prefix) ? name.substr(prefix.size()) : name);
  std::ranges::replace(word, '_', '-');
  return word;
}

bool is_unspecified(const EnumValueDescriptor& value) {
  return value.number() == 0 && value.name().ends_with("UNSPECIFIED");
}

absl::Status check_field(const Message& message, const FieldDescriptor& field, int index) {
  const Reflection& reflection = *message.GetReflection();
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    return check_known(index < 0 ? reflection.GetMessage(message, &field)
                                 : reflection.GetRepeatedMessage(message, &field, index));
  }
  if (field.cpp_type() != FieldDescriptor::CPPTYPE_ENUM) return absl::OkStatus();
  const int number = index < 0 ? reflection.GetEnumValue(message, &field)
                               : reflection.GetRepeatedEnumValue(message, &field, index);
  if (field.enum_type()->FindValueByNumber(number) != nullptr) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      field.name(), " is number ", number,
      ", which this version does not know; it knows: ", absl::StrJoin(words_of(*field.enum_type()), ", ")));
}

}  // namespace

std::string word_of(const EnumType& type, int number) {
  const EnumValueDescriptor* const value = type.FindValueByNumber(number);
  return value == nullptr ? absl::StrCat(number) : word_for(*value);
}

std::vector<std::string> words_of(const EnumType& type) {
  std::vector<std::string> words;
  for (int i = 0; i < type.value_count(); ++i) {
    if (!is_unspecified(*type.value(i))) words.push_back(word_for(*type.value(i)));
  }
  return words;
}

std::string meaning_of(const EnumType& type, const std::string& word) {
  for (int i = 0; i < type.value_count(); ++i) {
    if (word_for(*type.value(i)) == word) return type.value(i)->options().GetExtension(v1::meaning);
  }
  return "";
}

absl::StatusOr<int> number_of(const EnumType& type, const std::string& word, const std::string& what) {
  for (int i = 0; i < type.value_count(); ++i) {
    const EnumValueDescriptor& value = *type.value(i);
    if (!is_unspecified(value) && word_for(value) == word) return value.number();
  }
  const std::vector<std::string> words = words_of(type);
  return absl::InvalidArgumentError(absl::StrCat("there is no ", what, " '", word,
                                                 "'; there is: ", absl::StrJoin(words, ", "),
                                                 base::did_you_mean(word, words)));
}

std::string name_of(const EnumType& type) {
  const std::string name = spaced(type.name(), ' ');
  const bool is_acronym = absl::AsciiStrToUpper(name) == name;
  return is_acronym ? name : absl::AsciiStrToLower(name);
}

absl::Status check_known(const Message& message) {
  const google::protobuf::UnknownFieldSet& unknown = message.GetReflection()->GetUnknownFields(message);
  if (!unknown.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(message.GetDescriptor()->name(), " has field ",
                                                   unknown.field(0).number(),
                                                   ", which this version does not know"));
  }
  std::vector<const FieldDescriptor*> present;
  message.GetReflection()->ListFields(message, &present);
  for (const FieldDescriptor* const field : present) {
    const int count = field->is_repeated() ? message.GetReflection()->FieldSize(message, field) : 0;
    if (!field->is_repeated()) {
      if (absl::Status status = check_field(message, *field, -1); !status.ok()) return status;
    }
    for (int i = 0; i < count; ++i) {
      if (absl::Status status = check_field(message, *field, i); !status.ok()) return status;
    }
  }
  return absl::OkStatus();
}

}  // namespace tessera::wire
