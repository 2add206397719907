// Which pair of dimensions of a sample's sequence serves what, for all algorithms. Fixed, so that a feature
// that is switched on moves no other's samples.
#pragma once

#include <cstdint>

#include "wire/limits.h"

namespace tessera::render::dimension {

// Paths from the eye.
inline constexpr int kFilm = 0;
inline constexpr int kLens = 1;
inline constexpr int kTime = 2;  // time and wavelength; paths from lights have it, too
inline constexpr int kFirstEvent = 3;
// Pairs of each scattering event
inline constexpr int kBsdfDirection = 0;
inline constexpr int kLightPoint = 1;
inline constexpr int kChoice = 2;    // light, BSDF lobe
inline constexpr int kRoulette = 3;  // Russian roulette, mixed material
inline constexpr int kPairsPerEvent = 4;
// Beyond all events, one pair each
inline constexpr int kFlight = 1 << 20;  // distance in a medium
inline constexpr int kOpacity = 2 << 20;

// Paths from lights, apart from those from the eye of the same pixel.
inline constexpr int kLightPath = 3 << 20;
inline constexpr int kEmitter = kLightPath;
inline constexpr int kEmissionPlace = kLightPath + 1;
inline constexpr int kEmissionDirection = kLightPath + 2;
inline constexpr int kFirstLightEvent = kLightPath + 3;
// Pairs of each scattering event
inline constexpr int kJoinLens = 0;
inline constexpr int kLightBsdfDirection = 1;
inline constexpr int kLobe = 2;           // BSDF lobe, opacity
inline constexpr int kLightRoulette = 3;  // Russian roulette, mixed material
inline constexpr int kPairsPerLightEvent = 4;
// Beyond all events, one pair each
inline constexpr int kLightFlight = 4 << 20;  // distance in a medium

// Whether an event is a diffuse or a glossy one, for layers alone: towards a light, and where the path goes
// on; one pair each event, far beyond all others.
inline constexpr int kLayerLobes = 12 << 20;
// The same on paths from lights that have the dimensions of a path from the eye beside their own.
inline constexpr int kLightLayerLobes = 13 << 20;

// Light that is sampled at probes: a point on it, and which.
inline constexpr int kProbeLight = 15 << 20;
inline constexpr int kProbeLightChoice = kProbeLight + 1;

/// The deepest event.
inline constexpr int kDeepest = static_cast<int>(wire::kMaxDepth);
static_assert(kFirstEvent + (kDeepest + 1) * kPairsPerEvent <= kFlight);
static_assert(kFlight + kDeepest < kOpacity);
static_assert(kOpacity + kDeepest < kLightPath);
static_assert(kFirstLightEvent + (kDeepest + 1) * kPairsPerLightEvent <= kLightFlight);
static_assert(kLightFlight + kDeepest < kLayerLobes);
static_assert(kLayerLobes + kDeepest < kLightLayerLobes);

// Number streams (medium.h), for decisions whose number is not known beforehand: one for each use, event and
// round.
enum class Stream : std::uint32_t { kTransit = 1, kShadow = 2 };
/// Most surfaces that one ray may pass, a round each.
inline constexpr int kMostCrossings = 1000;
inline constexpr std::uint32_t kRoundBits = 16;
static_assert(kMostCrossings < 1 << kRoundBits);
static_assert(std::uint64_t{wire::kMaxDepth + 1} << kRoundBits << 1 <= std::uint64_t{1} << 32);

inline constexpr std::uint32_t stream_key(Stream use, int event, int round) {
  return (static_cast<std::uint32_t>(event) << kRoundBits | static_cast<std::uint32_t>(round)) * 2 +
         static_cast<std::uint32_t>(use);
}

}  // namespace tessera::render::dimension
