// Queries as text: a line of a file, or the value of an option.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "local/geometry_query.h"

namespace tessera::client {

/// Coordinates may be as large as the renderer's; the largest component of a direction is no smaller than
/// the inverse.
inline constexpr double kLargestQueryNumber = 1e18;
/// Bytes of a line.
inline constexpr std::size_t kLongestQueryLine = 4096;

/// "ray", "inside" or "closest".
std::optional<QueryKind> query_kind(std::string_view word);

/// A query, or what is wrong and where: `column` counts from 1.
struct ParsedQuery {
  std::optional<Query> query;  // none and no error: the line is empty or a comment
  std::string error;
  std::uint32_t column = 0;
};

/// "ray OX OY OZ DX DY DZ", "inside X Y Z" or "closest X Y Z"; the word may be left out where `kind` says
/// which. Numbers stand apart by blanks or commas; from # on it is a comment.
ParsedQuery parse_query(std::string_view line, std::optional<QueryKind> kind);

}  // namespace tessera::client
