// Options whose texts are read into other values than numbers and strings.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "options/program.h"
#include "wire/enum_words.h"

namespace tessera::client {

/// An option whose text `parse` turns into a value.
template <class Value, class Parse>
options::Option add_parsed(options::Command& command, const char* name, std::optional<Value>& value,
                           Parse parse, const char* description) {
  const auto read = [&value, parse](const std::string& text) {
    absl::StatusOr<Value> parsed = parse(text);
    if (!parsed.ok()) return parsed.status();
    value = *std::move(parsed);
    return absl::OkStatus();
  };
  return command.add_read_by(name, read, description);
}

/// An option whose value is a word for one of an enum's (wire/enum_words.h).
template <class Enum>
options::Option add_word(options::Command& command, const char* name, Enum& value, const char* description) {
  const auto read = [&value](const std::string& text) {
    const absl::StatusOr<Enum> known = wire::value_of<Enum>(text);
    if (known.ok()) value = *known;
    return known.status();
  };
  return command.add_read_by(name, read, description)
      .type_name("NAME")
      .completing(wire::words_of(*google::protobuf::GetEnumDescriptor<Enum>()));
}

template <class Value>
using WordList = std::vector<std::pair<std::string, Value>>;

/// An option whose value is one of a few words that stand for others.
template <class Value>
options::Option add_choice(options::Command& command, const char* name, WordList<Value> words, Value& value,
                           const char* description) {
  std::vector<std::string> names;
  for (const auto& [word, meaning] : words) names.push_back(word);
  const auto take = [words = std::move(words), &value](const std::string& text) {
    for (const auto& [word, meaning] : words) {
      if (word == text) value = meaning;
    }
    return absl::OkStatus();  // one_of() lets no other through
  };
  return command.add_read_by(name, take, description).one_of(std::move(names));
}

}  // namespace tessera::client
