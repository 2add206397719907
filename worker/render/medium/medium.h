// Light in participating media: where it scatters, and how much comes through.
//
// Free flights are unbiased: in closed form where the medium is the same everywhere, by delta tracking along
// a grid of majorants elsewhere [Woodcock et al. 1965; Novak et al. 2018]. Media whose extinction has a
// colour are sampled with the mixture of its components' densities, weighed by the throughput of the path:
// one-sample multiple importance sampling [Wilkie et al. 2014; Kutz et al. 2017], so that no weight grows
// beyond the mixture's.
#pragma once

#include "render/color/spectra.h"
#include "render/core/vec.h"
#include "render/medium/medium_table.h"
#include "render/sampling/hash.h"

namespace tessera::render::TESSERA_ISA {

/// Uniform numbers without end, a stream a lane. For decisions whose number is not known beforehand.
class NumberStream {
 public:
  TESSERA_INLINE explicit NumberStream(UInt key) : key_(key) {}
  TESSERA_INLINE Float next() { return to_unit_float(hash(key_, UInt(++count_))); }

 private:
  UInt key_;
  std::uint32_t count_ = 0;
};

/// Sixteen rays from `origin` on, as far as `distance`, each within its medium.
struct MediumRays {
  Int medium;  // index into MediumTable::media
  Vec3 origin, direction;
  Float distance;  // may be infinite
  [[no_unique_address]] Spectra spectra;
};

/// Fate of a ray.
struct Flight {
  Mask scattered;  // event at `t`; false: it came through
  Float t;
  Spectrum weight;    // factor of the throughput
  Spectrum emission;  // radiance taken up on the way, by the throughput before it
};

/// `throughput` steers the choice among the components; `u` is uniform in the unit square.
Flight sample_flight(const MediumTable& table, const MediumRays& rays, Spectrum throughput, Vec2 u,
                     NumberStream& numbers, Mask active);

/// An unbiased estimate of the part of light that comes through: exact where the medium is the same
/// everywhere, by ratio tracking elsewhere.
Spectrum sample_transmittance(const MediumTable& table, const MediumRays& rays, NumberStream& numbers,
                              Mask active);

/// Henyey-Greenstein phase function [Henyey & Greenstein 1941]: value and density for `wi`, given `wo`; both
/// point away.
Float phase_value(const MediumTable& table, Int medium, Vec3 wo, Vec3 wi, Mask active);
struct PhaseSample {
  Vec3 wi;
  Float pdf;
};
PhaseSample sample_phase(const MediumTable& table, Int medium, Vec3 wo, Vec2 u, Mask active);

}  // namespace tessera::render::TESSERA_ISA
