#include <cstddef>

#include "images/readers.h"

namespace tessera::images {
namespace {

constexpr std::size_t kHeaderBytes = 18;

/// Walks over the pixels of the file, `size` bytes each.
class Pixels {
 public:
  Pixels(std::string_view data, std::size_t size, bool runs) : data_(data), size_(size), runs_(runs) {}

  /// The next one; false where the file ends.
  bool next(std::uint32_t& rgba) {
    if (runs_ && left_in_packet_ == 0) {
      if (data_.empty()) return false;
      const auto packet = static_cast<unsigned char>(data_.front());
      data_.remove_prefix(1);
      left_in_packet_ = (packet & 127) + 1;
      repeats_ = (packet & 128) != 0;
    }
    if (data_.size() < size_) return false;
    const auto channel = [&](std::size_t i) { return std::uint32_t{static_cast<unsigned char>(data_[i])}; };
    rgba =
        0xff000000u | (size_ == 1 ? channel(0) * 0x010101u : channel(2) | channel(1) << 8 | channel(0) << 16);
    if (runs_) --left_in_packet_;
    if (!repeats_ || left_in_packet_ == 0) data_.remove_prefix(size_);
    return true;
  }

 private:
  std::string_view data_;
  const std::size_t size_;
  const bool runs_;
  unsigned left_in_packet_ = 0;
  bool repeats_ = false;
};

}  // namespace

bool read_tga(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels) {
  if (blob.size() < kHeaderBytes) return false;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(blob[i]); };
  const auto word = [&](std::size_t i) { return byte(i) | byte(i + 1) << 8; };
  const unsigned char kind = byte(2), depth = byte(16), descriptor = byte(17);
  const bool grey = kind == 3 || kind == 11, color = kind == 2 || kind == 10;
  constexpr unsigned char kFromTheTop = 0x20;
  const bool plain =
      byte(1) == 0 && ((grey && depth == 8) || (color && depth == 24)) && (descriptor & ~kFromTheTop) == 0;
  const std::size_t first = kHeaderBytes + byte(0);
  if (!plain || blob.size() < first || !allot(word(12), word(14), false, max_pixels, pixels)) return false;

  Pixels source(blob.substr(first), depth / 8, kind > 8);
  const std::int32_t height = pixels.size.height;
  const auto width = static_cast<std::size_t>(pixels.size.width);
  for (std::int32_t i = 0; i < height; ++i) {
    const std::int32_t y = descriptor & kFromTheTop ? i : height - 1 - i;
    std::uint32_t* const row = pixels.bytes.data() + static_cast<std::size_t>(y) * width;
    for (std::size_t x = 0; x < width; ++x) {
      if (!source.next(row[x])) return false;
    }
  }
  return true;
}

}  // namespace tessera::images
