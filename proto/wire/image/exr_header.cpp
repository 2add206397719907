#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>

#include "wire/image/readers.h"

namespace tessera::wire {
namespace {

/// Removes a string and the zero behind it; false where there is none.
bool take_string(std::string_view& bytes, std::string_view& text) {
  const std::size_t end = bytes.find('\0');
  if (end == std::string_view::npos) return false;
  text = bytes.substr(0, end);
  bytes.remove_prefix(end + 1);
  return true;
}

template <class T>
T read_at(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

/// What OpenEXR makes room for when it opens a part, before it reads a pixel.
class Part {
 public:
  void note(std::string_view name, std::string_view value) {
    ++attributes_;
    if (name == "dataWindow" && value.size() == 16) {
      const std::int64_t last = read_at<std::int32_t>(value, 8), first = read_at<std::int32_t>(value, 0);
      width_ = std::max(width_, static_cast<double>(last - first + 1));
    } else if (name == "tiles" && value.size() >= 8) {
      tile_ = std::max(tile_, 1.0 * read_at<std::uint32_t>(value, 0) * read_at<std::uint32_t>(value, 4));
    } else if (name == "channels") {
      channels_ = std::max(channels_, count_channels(value));
    } else if (name == "compression" && value.size() == 1) {
      constexpr int kLines[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};  // that are compressed together
      lines_ = std::max(lines_, kLines[std::min<std::size_t>(read_at<std::uint8_t>(value, 0), std::size(kLines) - 1)]);
    }
  }
  bool empty() const { return attributes_ == 0; }

  /// Lines or a tile of all channels, as floats: what a worker can hold a few of.
  bool has_plausible_blocks() const {
    constexpr double kMaxBlockBytes = 1 << 28;
    return std::max(width_ * lines_, tile_) * channels_ * sizeof(float) <= kMaxBlockBytes;
  }

 private:
  static double count_channels(std::string_view list) {
    constexpr std::size_t kRest = 16;  // of a channel, behind its name
    double count = 0;
    for (std::string_view name; take_string(list, name) && !name.empty() && list.size() >= kRest; ++count) {
      list.remove_prefix(kRest);
    }
    return count;
  }

  int attributes_ = 0, lines_ = 1;
  double width_ = 0, tile_ = 0, channels_ = 0;
};

}  // namespace

bool is_plausible_exr(std::string_view blob) {
  constexpr std::size_t kMarkAndVersion = 8;
  constexpr std::uint32_t kMultiPart = 0x1000;
  if (blob.size() < kMarkAndVersion) return false;
  const auto version = read_at<std::uint32_t>(blob, 4);
  blob.remove_prefix(kMarkAndVersion);
  Part part;
  for (std::string_view name, type; take_string(blob, name);) {
    if (name.empty()) {
      // The end of a header; of a file of several parts, an empty header is the last.
      if (!part.has_plausible_blocks()) return false;
      if ((version & kMultiPart) == 0 || part.empty()) return true;
      part = {};
      continue;
    }
    if (!take_string(blob, type) || blob.size() < sizeof(std::int32_t)) return false;
    const auto size = read_at<std::int32_t>(blob, 0);
    blob.remove_prefix(sizeof(size));
    if (size < 0 || static_cast<std::size_t>(size) > blob.size()) return false;
    part.note(name, blob.substr(0, static_cast<std::size_t>(size)));
    blob.remove_prefix(static_cast<std::size_t>(size));
  }
  return false;
}

}  // namespace tessera::wire
