// Text of others, made safe for a terminal and for a log: what moves the cursor, recolours, or begins a line
// is spelled out.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tessera::base {

/// `text` with "\n" for a newline and "\x1b" for every other control character: those of ASCII, those of ISO
/// 6429 beyond it (U+0080 to U+009F, which terminals obey too), marks that turn the direction of writing, and
/// bytes that are not UTF-8. All else stays, so that names in any language can be read.
std::string printable(std::string_view text);

/// The same, but lines stay lines.
std::string printable_lines(std::string_view text);

/// The longest beginning of `text` that has at most `bytes` bytes and cuts no UTF-8 character in two.
std::string_view beginning_of(std::string_view text, std::size_t bytes);

}  // namespace tessera::base
