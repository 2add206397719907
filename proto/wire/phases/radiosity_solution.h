// A solution of radiosity as pictures and meshes read it: the blob of the last phase.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "wire/phases/patch_name.h"

namespace tessera::wire {

/// A corner of patches. Colours are R, G, B, in W/m^2.
struct SolutionVertex {
  float position[3];  // render space
  float irradiance[3];
  float radiosity[3];
};

/// A patch that has no parts.
struct SolutionPatch {
  std::uint32_t corners[3];  // vertices
  float irradiance[3];       // all over it
};

/// Patches and vertices, over which irradiance and radiosity are continuous: linear over each patch, and
/// along an edge with larger ones beyond it linear over these.
struct Solution {
  // One for each node, sides first: the first of its four parts, or, where it has none, -1 - its patch.
  std::vector<std::int32_t> nodes;
  std::uint32_t sides = 0;
  // One for each triangle: 1 where its corners go clockwise, seen from where its side 0 is.
  std::vector<std::uint8_t> turned;
  std::vector<SolutionPatch> patches;
  std::vector<SolutionVertex> vertices;
  // How it was found.
  std::uint64_t links = 0;
  std::uint32_t sweeps = 0;
  double residual = 0;
  std::uint64_t cut_short = 0;  // sides for whose links there was no room

  std::string blob() const;
  /// Not there where the bytes are none.
  static std::optional<Solution> read(std::string_view blob);
};

}  // namespace tessera::wire
