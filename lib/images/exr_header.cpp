#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>

#include "images/readers.h"

namespace tessera::images {
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

/// Count of channels of a list that takes these bytes exactly; 0 for anything else.
std::size_t count_channels(std::string_view list) {
  constexpr std::size_t kRest = 16;  // bytes of a channel behind its name
  std::size_t count = 0;
  for (std::string_view name; take_string(list, name); ++count) {
    if (name.empty()) return list.empty() ? count : 0;
    if (list.size() < kRest) return 0;
    list.remove_prefix(kRest);
  }
  return 0;
}

/// Strings, each behind its length.
bool is_string_vector(std::string_view value) {
  while (value.size() >= sizeof(std::uint32_t)) {
    const std::size_t length = read_at<std::uint32_t>(value, 0);
    value.remove_prefix(sizeof(std::uint32_t));
    if (length > value.size()) return false;
    value.remove_prefix(length);
  }
  return value.empty();
}

bool is_preview(std::string_view value) {
  constexpr std::size_t kSides = 8, kPixel = 4;
  return value.size() >= kSides && (value.size() - kSides) % kPixel == 0 &&
         std::uint64_t{read_at<std::uint32_t>(value, 0)} * read_at<std::uint32_t>(value, 4) ==
             (value.size() - kSides) / kPixel;
}

/// Whether a value takes the bytes that its attribute says. OpenEXR reads values of these types without a
/// look at that, and goes on behind what it read: it would take other bytes for the next attribute than we
/// do.
bool has_its_size(std::string_view type, std::string_view value) {
  struct Fixed {
    std::string_view type;
    std::size_t bytes;
  };
  static constexpr Fixed kFixed[] = {
      {"box2i", 16},
      {"box2f", 16},
      {"chromaticities", 32},
      {"compression", 1},
      {"deepImageState", 1},
      {"double", 8},
      {"envmap", 1},
      {"float", 4},
      {"int", 4},
      {"keycode", 28},
      {"lineOrder", 1},
      {"m33f", 36},
      {"m33d", 72},
      {"m44f", 64},
      {"m44d", 128},
      {"rational", 8},
      {"tiledesc", 9},
      {"timecode", 8},
      {"v2i", 8},
      {"v2f", 8},
      {"v2d", 16},
      {"v3i", 12},
      {"v3f", 12},
      {"v3d", 24},
  };
  for (const Fixed& fixed : kFixed) {
    if (type == fixed.type) return value.size() == fixed.bytes;
  }
  if (type == "chlist") return count_channels(value) > 0;
  if (type == "preview") return is_preview(value);
  if (type == "stringvector") return is_string_vector(value);
  return true;
}

/// Bytes that OpenEXR makes room for when it opens a part, before it reads a pixel.
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
      channels_ = std::max(channels_, static_cast<double>(count_channels(value)));
    } else if (name == "compression" && value.size() == 1) {
      // The index is the compression.
      constexpr int kLinesPerBlock[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
      lines_ = std::max(lines_, kLinesPerBlock[std::min<std::size_t>(read_at<std::uint8_t>(value, 0),
                                                                     std::size(kLinesPerBlock) - 1)]);
    }
  }
  bool empty() const { return attributes_ == 0; }

  /// Lines or a tile of all channels, as floats: what a worker can hold a few of.
  bool has_plausible_blocks() const {
    constexpr double kMaxBlockBytes = 1 << 28;
    return std::max(width_ * lines_, tile_) * channels_ * sizeof(float) <= kMaxBlockBytes;
  }

 private:
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
    const std::string_view value = blob.substr(0, static_cast<std::size_t>(size));
    if (!has_its_size(type, value)) return false;
    part.note(name, value);
    blob.remove_prefix(static_cast<std::size_t>(size));
  }
  return false;
}

}  // namespace tessera::images
