// Memory that radiosity takes.
#pragma once

#include <cstdint>

namespace tessera::render::radiosity {

/// Bytes of a link where most of them are at once: twice when parts are merged, or once besides the patches
/// that they have made, of which there is less than one a link, and the sums of these.
inline constexpr std::uint64_t kBytesPerLink = 2 * 24 + 100;
/// Bytes of a link of the estimate, between whole sides and clusters: as it is read, from bytes that are
/// there too.
inline constexpr std::uint64_t kBytesPerEstimateLink = 2 * 24 + 12;
/// Bytes of a patch once there are links: its node, and light on its way to it.
inline constexpr std::uint64_t kBytesPerNode = 64 + 2 * 12;
/// Bytes of a triangle with its two sides: corners, clusters, matter and light, vertices, and the light of
/// lights that are on no surface, in blobs and as it is read.
inline constexpr std::uint64_t kBytesPerTriangle = 128 + 2 * (4 * 72 + 100 + 60 + 2 * 24 + 4);
/// Links that a side has anyhow, however little memory there is.
inline constexpr std::uint64_t kLeastLinks = 16;

/// Bytes without which radiosity of so many sides of triangles does not begin.
constexpr std::uint64_t least_memory(std::uint64_t sides) {
  return sides * (kBytesPerTriangle / 2 + kLeastLinks * kBytesPerLink);
}

}  // namespace tessera::render::radiosity
