// Options whose texts are read into other values than numbers and strings.
#pragma once

#include <optional>
#include <string>
#include <utility>

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

}  // namespace tessera::client
