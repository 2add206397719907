// The frames of an animation: which, in what order, and names of files with their numbers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace tessera::client {

enum class FrameOrder {
  kForward,
  kReverse,
  kBinary  // the first, the last, the middle, then the middles of what is left: an early look at all of it
};

/// "1-100x2,200": ranges, with a step behind an x, and single numbers, each frame once, in the order of the
/// list. InvalidArgument, with what was expected, otherwise, and for more than 2^20 frames.
absl::StatusOr<std::vector<std::int64_t>> parse_frames(std::string_view text);

/// `frames`, which ascend or not, in another order.
std::vector<std::int64_t> in_order(std::vector<std::int64_t> frames, FrameOrder order);

/// Whether the name of a file has a place for the frame's number.
bool has_frame_mark(std::string_view path);
/// "name.####.exr" with the number in place of the last row of #, and as many digits at least.
std::string path_of_frame(const std::string& path, std::int64_t frame);
/// "angle={frame}" with the number.
std::string text_of_frame(std::string text, std::int64_t frame);

}  // namespace tessera::client
