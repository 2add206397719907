#include "wire/volume_blob.h"

#include "fuzz/target.h"

namespace tessera::fuzz {
namespace {

bool accepts_volume_blob(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  const auto volume = wire::decode_volume({input.data(), input.size()});
  if (!volume.ok()) return false;
  require(volume->samples.size() == std::size_t{volume->nx} * volume->ny * volume->nz * volume->channels,
          "a volume of the wrong size");
  require(wire::encode_volume(*volume).size() == bytes.size(), "a volume does not survive encoding");
  return true;
}

}  // namespace

const Target kVolumeBlob = {"volume_blob", accepts_volume_blob};

}  // namespace tessera::fuzz
