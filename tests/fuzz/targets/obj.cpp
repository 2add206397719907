#include "import/obj/obj_reader.h"

#include "fuzz/targets/sound_mesh.h"

namespace tessera::fuzz {
namespace {

bool accepts(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  return is_sound_mesh(client::read_obj({input.data(), input.size()}));
}

}  // namespace

const Target kObj = {"obj", accepts};

}  // namespace tessera::fuzz
