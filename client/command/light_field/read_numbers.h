// Options of several numbers: "17x17", "0,1.5,-3".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"

namespace tessera::client {

/// "17x9". InvalidArgument, with what was expected, for others, and for 0.
absl::StatusOr<std::pair<std::uint32_t, std::uint32_t>> parse_counts(std::string_view text);

/// Reads so many finite numbers with commas between them. InvalidArgument otherwise.
absl::StatusOr<std::array<double, 2>> parse_pair(std::string_view text);
absl::StatusOr<std::array<double, 3>> parse_triple(std::string_view text);
absl::StatusOr<std::array<double, 6>> parse_six(std::string_view text);

}  // namespace tessera::client
