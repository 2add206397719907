// Images as commands read them: any number of parts, scanlines or tiles, with mip levels.
#include "image/exr.h"

#include "fuzz/target.h"

namespace tessera::fuzz {
namespace {

bool accepts_exr(std::string_view bytes) {
  constexpr std::size_t kMaxPixels = std::size_t{1} << 16;
  const std::string path = scratch_file("fuzz.exr", bytes);
  const auto facts = client::read_exr_facts(path);
  require(facts.ok() || !facts.status().message().empty(), "an error without a message");
  const auto image = client::read_exr(path, kMaxPixels);
  if (!image.ok()) {
    require(!image.status().message().empty(), "an error without a message");
    return false;
  }
  require(facts.ok(), "pixels without a header");
  require(image->pixel_count() > 0 && image->pixel_count() <= kMaxPixels, "an image of a size not allowed");
  for (const client::Channel& channel : image->channels)
    require(channel.values.size() == image->pixel_count(), "a channel of the wrong size");
  return true;
}

}  // namespace

const Target kExr = {"exr", accepts_exr};

}  // namespace tessera::fuzz
