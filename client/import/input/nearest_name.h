// The name that was probably meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tessera::client {

/// The one of `names` that takes the fewest insertions, deletions, replacements and swaps of neighbours to make of
/// `name` [Damerau 1964]; the first of equals. Empty where none is within a third of the longer name's length, at least
/// one edit.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

}  // namespace tessera::client
