// Scenes in which algorithms are compared: a floor with a ball and a tetrahedron on it, lamps above, cameras.
#pragma once

#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"
#include "wire/mesh_blob.h"

namespace tessera::test {

/// Makes a tetrahedron about the origin whose normals are those of a sphere: shading and geometric normals
/// differ much.
inline std::string tetrahedron() {
  wire::MeshData mesh;
  const float r = 0.57735f;
  mesh.positions = {r, r, r, r, -r, -r, -r, r, -r, -r, -r, r};
  mesh.normals = mesh.positions;
  mesh.indices = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
  return wire::encode_mesh(mesh);
}

/// A square of side 2 in the plane z = 0, its normal down.
inline std::string square_facing_down() {
  wire::MeshData mesh;
  mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  mesh.uvs = {0, 0, 1, 0, 1, 1, 0, 1};
  mesh.indices = {0, 2, 1, 0, 3, 2};
  return wire::encode_mesh(mesh);
}

inline TestBlobs light_blobs() {
  // A latitude-longitude map of 4 x 2 texels with a colour each.
  const float texels[4 * 2 * 3] = {0.1f, 0.4f, 1, 2, 1, 0.5f, 0, 0.2f, 0.1f, 1,    1, 1,
                                   0.3f, 0,    0, 0, 0, 0.8f, 3, 2,    1,    0.5f, 0, 0.5f};
  std::string pfm = "PF\n4 2\n-1.0\n";
  pfm.append(reinterpret_cast<const char*>(texels), sizeof(texels));
  return {{"tetrahedron", tetrahedron()}, {"square", square_facing_down()}, {"map", pfm}};
}

inline constexpr const char* kTextures = R"(
  textures { name: 'checks' checkerboard { even { constant { rgb { r: 1 g: 0.6 b: 0.2 } } }
    odd { constant { constant: 0.1 } }
                                           mapping { scale_u: 5 scale_v: 3 } } }
  textures { name: 'bumps' noise { kind: FBM octaves: 3
                                   texture_from_world { elements: [4,0,0,0, 0,4,0,0, 0,0,4,0, 0,0,0,1] } } }
  textures { name: 'lower bumps'
    scale { value { texture: 'bumps' } factor { constant { constant: 0.15 } } } })";

/// A floor, and on it a ball of material 'm' and a tetrahedron of material 'm'.
inline std::string things(const std::string& material) {
  return absl::StrCat(kTextures, " materials { name: 'm' ", material, R"( }
    materials { name: 'floor' diffuse { reflectance { constant { rgb { r: 0.6 g: 0.5 b: 0.4 } } } } }
    shapes { disk { radius: 3 } material: 'floor' }
    shapes { sphere { radius: 0.6 } material: 'm'
      world_from_object { elements: [1,0,0,-0.8, 0,1,0,0, 0,0,1,0.7, 0,0,0,1] } }
    shapes { mesh { blob { digest: 'tetrahedron' } } material: 'm'
             world_from_object { elements: [0.7,0,0,0.7, 0,0.7,0,0.2, 0,0,0.7,0.6, 0,0,0,1] } })");
}

inline constexpr const char* kDiffuse =
    "diffuse { reflectance { constant { rgb { r: 0.7 g: 0.6 b: 0.8 } } } }";

/// At (0, -4, 3), looking at (0, 0, 0.4).
inline std::string camera(const std::string& kind, const std::string& more = "") {
  return absl::StrCat(
      " camera { ", kind,
      R"( world_from_camera { elements: [1,0,0,0, 0,0.5448,0.8386,-4, 0,0.8386,-0.5448,3, 0,0,0,1] } )", more,
      " } ");
}
inline constexpr const char* kPerspective = "perspective { fov_degrees: 45 }";

inline constexpr const char* kLamp =
    R"( shapes { mesh { blob { digest: 'square' } } area_light { radiance { constant: 3 } }
  world_from_object { elements: [0.6,0,0,0.3, 0,0.6,0,-0.4, 0,0,1,2.5, 0,0,0,1] } } )";

inline std::string lamp(const std::string& kind, const std::string& light, const std::string& matrix) {
  return absl::StrCat(" shapes { ", kind, " area_light { radiance { rgb { r: 2 g: 3 b: 4 } } ", light,
                      " } world_from_object { elements: [", matrix, "] } } ");
}
/// A pose for lamp().
inline constexpr const char* kAbove = "0.5,0,0,0.4, 0,0.5,0,-0.3, 0,0,0.5,2.2, 0,0,0,1";

}  // namespace tessera::test
