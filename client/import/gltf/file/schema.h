// The form of glTF files: which members objects have, of what type and within what bounds. What is beyond is
// refused before anything is read, so that readers need not look again.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "import/gltf/context.h"

namespace tessera::client::gltf {

enum class Kind {
  kFlag,
  kInteger,
  kNumber,
  kText,
  kWord,     // a text of the list `of`, which spaces separate
  kCode,     // an integer of the list `of`
  kIndex,    // into the array `of` of the document
  kObject,   // an object of the schema `of`
  kNumbers,  // arrays of those, from `least` to `most` elements
  kTexts,
  kIndices,  // each once
  kObjects,
  kIndexMap,  // names to indices
  kIndexMaps
};

/// A member of an object. Numbers are from `low` to `high`.
struct Member {
  const char* name;
  Kind kind;
  const char* of = "";
  bool required = false;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  std::size_t least = 1;
  std::size_t most = std::numeric_limits<std::size_t>::max();
};

struct Schema {
  const char* name;  // an extension's: "material/KHR_materials_ior"
  std::span<const Member> members;
};

/// schema_tables.cpp. Null where there is none.
const Schema* find_schema(std::string_view name);

/// Whether an extension is known that is an object of some kind, or says something by its name alone.
bool is_known_extension(std::string_view name);

/// Reports all that is not as the schemas have it, with its place.
void check_form(Context& context);

}  // namespace tessera::client::gltf
