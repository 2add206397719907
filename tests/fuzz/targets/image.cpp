// Textures as workers decode them: the own readers first, then OpenImageIO's.
#include "fuzz/target.h"
#include "images/image_blob.h"

namespace tessera::fuzz {
namespace {

bool accepts_image(std::string_view bytes) {
  constexpr std::uint64_t kMaxPixels = 1 << 16;
  const std::vector<char> input = exact(bytes);
  // TGA has no mark: its name tells it.
  const auto image = images::decode_image({input.data(), input.size()}, "fuzz.tga", kMaxPixels);
  if (!image.ok()) {
    require(!image.status().message().empty(), "an error without a message");
    return false;
  }
  const auto pixels =
      static_cast<std::size_t>(image->size.width) * static_cast<std::size_t>(image->size.height);
  require(pixels > 0 && pixels <= kMaxPixels, "an image of a size that was not allowed");
  require(image->bytes.size() == pixels || image->floats.size() == 4 * pixels, "an image of the wrong size");
  return true;
}

}  // namespace

const Target kImage = {"image", accepts_image};

}  // namespace tessera::fuzz
