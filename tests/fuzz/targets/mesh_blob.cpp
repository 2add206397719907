#include "wire/mesh_blob.h"

#include <algorithm>
#include <cstring>

#include "fuzz/target.h"

namespace tessera::fuzz {
namespace {

bool accepts_mesh_blob(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  const auto mesh = wire::decode_mesh({input.data(), input.size()});
  if (!mesh.ok()) return false;
  require(std::all_of(mesh->indices.begin(), mesh->indices.end(),
                      [&](std::uint32_t index) { return index < mesh->vertex_count(); }),
          "a triangle without a vertex");
  for (const auto& floats : {mesh->positions, mesh->normals, mesh->uvs}) {
    float sum = 0;
    for (const float value : floats) sum += value;  // reads all that the view promises
    static_cast<void>(sum);
  }
  return true;
}

}  // namespace

const Target kMeshBlob = {"mesh_blob", accepts_mesh_blob};

}  // namespace tessera::fuzz
