#include "import/mitsuba/shapes/basic_meshes.h"

namespace tessera::client::mitsuba {

wire::MeshData rectangle_mesh() {
  wire::MeshData mesh;
  mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  mesh.uvs = {0, 0, 1, 0, 1, 1, 0, 1};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

wire::MeshData cube_mesh() {
  // Normal of each face, and its corners where uv is (0, 1), (1, 1), (1, 0) and (0, 0).
  struct Face {
    float normal[3];
    float corners[4][3];
  };
  constexpr Face kFaces[] = {{{0, -1, 0}, {{1, -1, -1}, {1, -1, 1}, {-1, -1, 1}, {-1, -1, -1}}},
                             {{0, 1, 0}, {{1, 1, -1}, {-1, 1, -1}, {-1, 1, 1}, {1, 1, 1}}},
                             {{1, 0, 0}, {{1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1}}},
                             {{0, 0, 1}, {{1, -1, 1}, {1, 1, 1}, {-1, 1, 1}, {-1, -1, 1}}},
                             {{-1, 0, 0}, {{-1, -1, 1}, {-1, 1, 1}, {-1, 1, -1}, {-1, -1, -1}}},
                             {{0, 0, -1}, {{1, 1, -1}, {1, -1, -1}, {-1, -1, -1}, {-1, 1, -1}}}};
  constexpr float kUvs[] = {0, 1, 1, 1, 1, 0, 0, 0};
  wire::MeshData mesh;
  for (const Face& face : kFaces) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
    for (const auto& corner : face.corners) {
      mesh.positions.insert(mesh.positions.end(), corner, corner + 3);
      mesh.normals.insert(mesh.normals.end(), face.normal, face.normal + 3);
    }
    mesh.uvs.insert(mesh.uvs.end(), kUvs, kUvs + 8);
    mesh.indices.insert(mesh.indices.end(), {first, first + 1, first + 2, first + 3, first, first + 2});
  }
  return mesh;
}

}  // namespace tessera::client::mitsuba
