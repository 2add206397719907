#include <bit>
#include <charconv>
#include <cstring>

#include "images/readers.h"

namespace tessera::images {
namespace {

static_assert(std::endian::native == std::endian::little, "values are read in place");

/// The next word of the header, and the single white space behind it.
std::string_view take_word(std::string_view& bytes) {
  const std::size_t end = bytes.find_first_of(" \n");
  if (end == std::string_view::npos) return {};
  const std::string_view word = bytes.substr(0, end);
  bytes.remove_prefix(end + 1);
  return word;
}

template <class T>
bool parse(std::string_view word, T& value) {
  const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && rest == word.data() + word.size();
}

}  // namespace

bool read_pfm(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels) {
  const std::string_view kind = take_word(blob);
  std::int32_t width = 0, height = 0;
  double scale = 0;
  if (kind != "PF" && kind != "Pf") return false;
  if (!parse(take_word(blob), width) || !parse(take_word(blob), height) || !parse(take_word(blob), scale))
    return false;
  if (scale != -1 || !allot(width, height, true, max_pixels, pixels)) return false;  // below 0: little-endian

  const std::size_t channels = kind == "PF" ? 3 : 1;
  const std::size_t count = pixels.floats.size() / 4;
  if (blob.size() / sizeof(float) / channels < count) return false;
  const char* in = blob.data();
  for (std::int32_t y = height - 1; y >= 0; --y) {
    float* out = &pixels.floats[4 * static_cast<std::size_t>(y) * static_cast<std::size_t>(width)];
    for (std::int32_t x = 0; x < width; ++x, out += 4, in += channels * sizeof(float)) {
      std::memcpy(out, in, channels * sizeof(float));
      if (channels == 1) out[2] = out[1] = out[0];
      out[3] = 1;
    }
  }
  return true;
}

}  // namespace tessera::images
