// The solution of radiosity as a mesh that others can read.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// Patches as triangles, counterclockwise where their light is seen from. Where both sides of a triangle
/// shine, it is there twice, wound either way.
struct RadiosityMesh {
  std::vector<std::array<float, 3>> positions;  // world space
  std::vector<std::array<float, 3>> radiosity;  // R, G and B at each position, W/m^2
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Reads the blob of the last phase of `scene`. InvalidArgument where it is none.
absl::StatusOr<RadiosityMesh> read_radiosity_mesh(const v1::Scene& scene, std::string_view blob);

}  // namespace tessera::render
