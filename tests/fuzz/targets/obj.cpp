#include "import/obj/obj_reader.h"

#include "fuzz/targets/sound_mesh.h"

namespace tessera::fuzz {
namespace {

bool accepts_obj(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  return is_sound_mesh(client::read_obj({input.data(), input.size()}));
}

}  // namespace

const Target kObj = {"obj", accepts_obj};

}  // namespace tessera::fuzz
