#include "import/ply/ply_reader.h"

#include "fuzz/targets/sound_mesh.h"

namespace tessera::fuzz {
namespace {

bool accepts_ply(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  bool accepted = false;
  for (const bool with_attributes : {false, true}) {
    const auto ply = client::read_ply({input.data(), input.size()}, with_attributes);
    accepted = is_sound_mesh(ply);
    if (!accepted) continue;
    for (const client::PlyAttribute& attribute : ply->attributes) {
      const std::size_t elements =
          attribute.per_face ? ply->mesh.indices.size() / 3 : ply->mesh.positions.size() / 3;
      require(attribute.values.size() == elements * attribute.channels,
              "the PLY reader made an unsound attribute");
    }
  }
  return accepted;
}

}  // namespace

const Target kPly = {"ply", accepts_ply};

}  // namespace tessera::fuzz
