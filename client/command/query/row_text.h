// Rows of a table as CSV [RFC 4180] or as JSON, an object a line.
#pragma once

#include <string>

#include "local/geometry_query.h"

namespace tessera::client {

enum class RowFormat : std::uint8_t { kCsv, kJson };

/// The line of names: CSV alone.
void append_header(Columns columns, RowFormat format, std::string& text);
/// Numbers are the shortest that read as the same double or float. What does not apply is empty, or left out
/// of the object; so is what is not finite.
void append_row(Columns columns, const Row& row, RowFormat format, std::string& text);

}  // namespace tessera::client
