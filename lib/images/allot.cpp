#include <limits>
#include <new>

#include "images/readers.h"

namespace tessera::images {

bool allot(std::int64_t width, std::int64_t height, bool floats, std::uint64_t max_pixels,
           ImagePixels& pixels) {
  constexpr std::int64_t kMostAlongASide = std::numeric_limits<std::int32_t>::max();
  if (width <= 0 || height <= 0 || width > kMostAlongASide || height > kMostAlongASide) return false;
  pixels.size = {static_cast<std::int32_t>(width), static_cast<std::int32_t>(height)};
  const std::uint64_t count = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  if (count > max_pixels) return false;
  pixels.floating_point = floats;
  try {
    if (floats) {
      pixels.floats.resize(4 * count);
    } else {
      pixels.bytes.resize(count);
    }
  } catch (const std::bad_alloc&) {
    return false;
  }
  return true;
}

}  // namespace tessera::images
