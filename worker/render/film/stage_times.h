// Where the time of rendering goes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera::render {

/// Stages of a batch of paths.
enum class Stage : std::uint8_t {
  kCamera,        // paths start
  kIntersection,  // nearest hits
  kTransit,       // media, and surfaces that light passes
  kShading,
  kShadow,     // rays to lights
  kFilm,       // samples become pixels
  kPhotonMap,  // photons are sorted
  kGather      // radiance estimates from photons
};
inline constexpr std::array kStageNames{"camera", "intersection", "transit",    "shading",
                                        "shadow", "film",         "photon map", "gather"};

/// Parts of shading a packet of paths.
enum class ShadingPart : std::uint8_t {
  kSurfaces,   // geometry at the hit, emission and environment that the path found
  kMaterials,  // textures, evaluating and sampling BSDFs
  kLights,     // picking a light and a point on it
  kPaths       // queueing rays, roulette
};
inline constexpr std::array kShadingPartNames{"surfaces", "materials", "light sampling", "paths"};

/// Nanoseconds of CPU time; within a kernel, ticks of its clock. They add up.
struct StageTimes {
  std::array<std::uint64_t, kStageNames.size()> stages{};
  /// Sampled: shares of the stage kShading, in one batch of several that is timed packet by packet.
  std::array<std::uint64_t, kShadingPartNames.size()> shading_parts{};
  /// kMaterials by the index of the material; empty where no batch was looked into. A packet's time is shared
  /// evenly among its paths.
  std::vector<std::uint64_t> materials;

  StageTimes& operator+=(const StageTimes& other);
  StageTimes& operator*=(double factor);
};

}  // namespace tessera::render
