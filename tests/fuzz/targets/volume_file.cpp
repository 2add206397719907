// Mitsuba's volumes.
#include "import/mitsuba/matter/volume_file.h"
#include "fuzz/target.h"
#include "wire/volume_blob.h"

namespace tessera::fuzz {
namespace {

bool accepts_volume_file(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  const auto volume = client::mitsuba::read_volume_file({input.data(), input.size()});
  if (volume.ok()) {
    require(wire::decode_volume(volume->blob).ok(), "the volume reader made an unsound volume");
  } else {
    require(!volume.status().message().empty(), "an error without a message");
  }
  return volume.ok();
}

}  // namespace

const Target kVolumeFile = {"volume_file", accepts_volume_file};

}  // namespace tessera::fuzz
