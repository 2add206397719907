#include "command/frames/frame_list.h"

#include <algorithm>
#include <charconv>
#include <deque>
#include <set>
#include <utility>

#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"

namespace tessera::client {
namespace {

constexpr std::size_t kMostFrames = std::size_t{1} << 20;
constexpr std::int64_t kLargestFrame = 999'999'999;

absl::Status expected() {
  return absl::InvalidArgumentError(
      "expected frames, as in 1-100, 1-100x2 (every other one) or 1-10,20: numbers up to 999999999, at most "
      "1048576 of them");
}

/// A number at the beginning of `text`, which is taken away.
bool take_number(std::string_view& text, std::int64_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || number < 0 || number > kLargestFrame) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

bool take_letter(std::string_view& text, char letter) {
  if (text.empty() || text.front() != letter) return false;
  text.remove_prefix(1);
  return true;
}

/// The row of # that stands for the frame: the last one of the file's name.
std::pair<std::size_t, std::size_t> mark_in(std::string_view path) {
  const std::size_t last = path.rfind('#');
  const std::size_t slash = path.rfind('/');
  if (last == std::string_view::npos || (slash != std::string_view::npos && slash > last))
    return {std::string_view::npos, 0};
  std::size_t begin = last;
  while (begin > 0 && path[begin - 1] == '#') --begin;
  return {begin, last - begin + 1};
}

}  // namespace

absl::StatusOr<std::vector<std::int64_t>> parse_frames(std::string_view text) {
  std::vector<std::int64_t> frames;
  std::set<std::int64_t> known;
  do {
    std::int64_t first = 0, last = 0, step = 1;
    if (!take_number(text, first)) return expected();
    last = first;
    if (take_letter(text, '-') && !take_number(text, last)) return expected();
    if (take_letter(text, 'x') && !take_number(text, step)) return expected();
    if (last < first || step < 1 || static_cast<std::size_t>((last - first) / step) >= kMostFrames)
      return expected();
    for (std::int64_t frame = first; frame <= last; frame += step) {
      if (known.insert(frame).second) frames.push_back(frame);
    }
    if (frames.size() > kMostFrames) return expected();
  } while (take_letter(text, ','));
  if (!text.empty()) return expected();
  return frames;
}

std::vector<std::int64_t> in_order(std::vector<std::int64_t> frames, FrameOrder order) {
  if (order == FrameOrder::kReverse) std::ranges::reverse(frames);
  if (order != FrameOrder::kBinary || frames.size() < 3) return frames;
  std::ranges::sort(frames);
  std::vector<std::int64_t> result = {frames.front(), frames.back()};
  // Open ranges whose ends have been taken, the widest first.
  std::deque<std::pair<std::size_t, std::size_t>> open = {{0, frames.size() - 1}};
  for (; !open.empty(); open.pop_front()) {
    const auto [begin, end] = open.front();
    if (end - begin < 2) continue;
    const std::size_t middle = begin + (end - begin) / 2;
    result.push_back(frames[middle]);
    open.emplace_back(begin, middle);
    open.emplace_back(middle, end);
  }
  return result;
}

bool has_frame_mark(std::string_view path) { return mark_in(path).second > 0; }

std::string path_of_frame(const std::string& path, std::int64_t frame) {
  const auto [begin, length] = mark_in(path);
  if (length == 0) return path;
  return path.substr(0, begin) + absl::StrFormat("%0*d", static_cast<int>(length), frame) +
         path.substr(begin + length);
}

std::string text_of_frame(std::string text, std::int64_t frame) {
  return absl::StrReplaceAll(text, {{"{frame}", absl::StrFormat("%d", frame)}});
}

}  // namespace tessera::client
