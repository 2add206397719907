// Where the numbers of a text stand, and what to put in their places.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::stress {

enum class TextKind {
  kPbrt,   // numbers outside of quotes; '#' begins a comment
  kProto,  // protobuf's text form: likewise
  kXml,    // numbers within quotes
  kPlain,  // OBJ and ASCII PLY: everywhere; '#' begins a comment in neither's numbers
};

struct NumberSite {
  std::size_t begin, length;
};

/// Every number of `text`, in order.
std::vector<NumberSite> number_sites(std::string_view text, TextKind kind);

/// `text` with the number at `site` replaced.
std::string with_number(std::string_view text, NumberSite site, std::string_view replacement);

/// Numbers that no reader expects: not a number, infinite, beyond float and double, denormal, zero, negative,
/// beyond integers.
inline constexpr std::string_view kBadNumbers[] = {
    "nan", "inf", "-inf", "1e38",  "-1e38",      "1e300",       "1e-45",
    "0",   "-1",  "1e12", "1e-12", "2147483648", "-2147483649", "99999999999999999999"};

}  // namespace tessera::stress
