// Nearest name to one that there is not: suggestions for typing errors.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tessera::base {

/// The one of `names` that differs least from `name`, by letters inserted, left out, exchanged or swapped
/// with their neighbour [Damerau 1964], capitals aside; or that begins with it. Empty when none differs in a
/// third of its letters or less. Of several equally near the first.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

/// "; did you mean 'render'?", or nothing.
std::string did_you_mean(std::string_view name, const std::vector<std::string>& names);

}  // namespace tessera::base
