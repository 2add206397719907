// Mitsuba's packed meshes.
#include "fuzz/targets/sound_mesh.h"
#include "import/mitsuba/shapes/serialized_mesh.h"

namespace tessera::fuzz {
namespace {

bool accepts_serialized(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  bool any = false;
  for (const std::int64_t index : {0, 1}) {
    any |= is_sound_mesh(client::mitsuba::read_serialized_mesh({input.data(), input.size()}, index));
  }
  return any;
}

}  // namespace

const Target kSerialized = {"serialized", accepts_serialized};

}  // namespace tessera::fuzz
