// JSON of glTF files: parsed within bounds, and read where its form is known to be right.
#pragma once

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::client::gltf {

using Json = nlohmann::json;

/// Bounds of what is taken for a scene: nothing sensible comes near them.
inline constexpr int kMostJsonLevels = 64;
inline constexpr std::size_t kMostJsonValues = std::size_t{1} << 24;

/// Parses a whole text. InvalidArgument says "line:column: what" for what is no JSON (RFC 8259, numbers that
/// doubles can hold, a name once an object), or is beyond the bounds.
absl::StatusOr<Json> parse_json(std::string_view text);

/// A step further down in a JSON pointer (RFC 6901).
std::string below(std::string_view place, std::string_view name);
std::string below(std::string_view place, std::size_t index);

// For objects that schema.h has found sound: members of the right type, or none. Null stands for no object.
const Json* member(const Json* object, const char* name);
double number_of(const Json* object, const char* name, double fallback);
std::int64_t integer_of(const Json* object, const char* name, std::int64_t fallback);
/// An integer that is not negative; 0 where it is absent.
std::size_t size_member(const Json& object, const char* name);
bool flag_of(const Json* object, const char* name, bool fallback);
std::string text_of(const Json* object, const char* name, const std::string& fallback = "");
std::optional<std::size_t> index_of(const Json* object, const char* name);
/// Elements of an array of the document, or of an object's; 0 where there is none.
std::size_t size_of(const Json* object, const char* name);
const Json* element(const Json* object, const char* name, std::size_t index);
const Json* extension(const Json* object, const char* name);

}  // namespace tessera::client::gltf
