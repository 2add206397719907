#pragma once

#include <cstdint>

namespace tessera::render {

enum class SamplerKind : std::int32_t { kSobol, kIndependent };

struct SamplerConfig {
  SamplerKind kind = SamplerKind::kSobol;
  std::uint64_t seed = 0;
};

/// Which pair of dimensions serves what. Fixed, so that a feature that is switched on moves no other's samples.
namespace dimension {
inline constexpr int kFilm = 0;
inline constexpr int kLens = 1;
inline constexpr int kTime = 2;  // and wavelength
inline constexpr int kFirstBounce = 3;
// Pairs of each bounce
inline constexpr int kBsdfDirection = 0;
inline constexpr int kLightPoint = 1;
inline constexpr int kChoice = 2;   // light, BSDF lobe
inline constexpr int kRoulette = 3;  // Russian roulette, mixed material
inline constexpr int kPairsPerBounce = 4;
// Beyond all bounces, one pair each
inline constexpr int kFlight = 1 << 20;   // distance in a medium
inline constexpr int kOpacity = 2 << 20;
}  // namespace dimension

}  // namespace tessera::render
