#include "render/bsdf/model/gltf/thin_film.h"

#include "render/bsdf/tables/film_table.h"
#include "render/core/constants.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr int kMostRoundTrips = 24;
constexpr float kLeastAmplitude = 1e-3f;

/// A value for each of the two polarisations.
struct Polarized {
  Float s, p;
};

/// Amplitudes that are reflected where light goes from index `from` to index `to` [Born & Wolf, 1.5].
TESSERA_INLINE Polarized amplitudes(Float from, Float from_cosine, Float to, Float to_cosine) {
  const auto ratio = [](Float a, Float b) { return (a - b) / max(a + b, 1e-20f); };
  return {ratio(from * from_cosine, to * to_cosine), ratio(to * from_cosine, from * to_cosine)};
}

/// Transmittance of a film without interference, for one polarisation, and the amplitude of a round trip:
/// with phase shift delta a film lets pass mean (1 + 2 sum over m of trip^m cos(m delta)).
struct Transmitted {
  Float mean, trip;
};
TESSERA_INLINE Transmitted transmitted(Float above, Float below) {
  const Float product = above * below;
  return {(1.0f - sqr(above)) * (1.0f - sqr(below)) / max(1.0f - sqr(product), 1e-6f), -product};
}

/// The interference of paths that differ by `path_nm`, as each lane sees it.
TESSERA_INLINE Spectrum interference(const ThinFilm& film, Float path_nm, Mask active) {
  Spectrum result;
#ifdef TESSERA_SPECTRAL
  for (int i = 0; i < kSpectrumLanes; ++i)
    result.c[i] = select_or_zero(active, cos(path_nm * (2 * kPi) / film.wavelengths.c[i]));
#else
  const Float position = min(path_nm * (1 / kFilmStepNm), kFilmEntries - 1.0f);
  const Float low = min(floor(position), kFilmEntries - 2.0f), t = position - low;
  const Int entry = to_int(low) * kFilmEntry;
  const Float4 a = gather4(film.table, entry, active), b = gather4(film.table, entry + kFilmEntry, active);
  for (int band = 0; band < kBands; ++band) result.c[band] = lerp(t, a.c[band], b.c[band]);
#endif
  return result;
}

}  // namespace

Spectrum ThinFilm::reflectance(Float cosine, Spectrum f0, Mask active) const {
  const Float sin2 = max(1.0f - sqr(cosine), 0.0f);
  const Float within = safe_sqrt(1.0f - sin2 / sqr(eta));
  const Polarized above = amplitudes(Float(1.0f), cosine, eta, within);
  const Float path = 2.0f * eta * thickness_nm * within;
  Transmitted s[kSpectrumLanes], p[kSpectrumLanes];
  Spectrum let_through;
  for (int lane = 0; lane < kSpectrumLanes; ++lane) {
    constexpr float kMostReflectance = 0.9999f;
    const Float root = sqrt(clamp(f0.c[lane], 0.0f, kMostReflectance));
    const Float base = (1.0f + root) / (1.0f - root);
    const Polarized below = amplitudes(eta, within, base, safe_sqrt(1.0f - sin2 / sqr(base)));
    s[lane] = transmitted(above.s, below.s), p[lane] = transmitted(above.p, below.p);
    let_through.c[lane] = 0.5f * (s[lane].mean + p[lane].mean);
  }
  Spectrum wave(0.0f);
  Mask going = active;
  for (int trips = 1; trips <= kMostRoundTrips; ++trips) {
    Float largest(0.0f);
    for (int lane = 0; lane < kSpectrumLanes; ++lane) {
      for (Transmitted* t : {&s[lane], &p[lane]}) {
        t->mean = select(going, t->mean * t->trip, t->mean);
        largest = max(largest, abs(t->mean));
      }
    }
    // Each point for itself: what a film reflects does not depend on what else is looked at.
    going &= largest > kLeastAmplitude;
    if (trips == kMostRoundTrips || none(going)) break;
    wave = select(going, interference(*this, path * static_cast<float>(trips), going), wave);
    for (int lane = 0; lane < kSpectrumLanes; ++lane) {
      const Float more = (s[lane].mean + p[lane].mean) * wave.c[lane];
      let_through.c[lane] = let_through.c[lane] + select_or_zero(going, more);
    }
  }
  // The rest as if it interfered like the last one: right for films that are much thinner than waves are
  // long, for which alone it counts.
  for (int lane = 0; lane < kSpectrumLanes; ++lane) {
    const Float rest = s[lane].mean / (1.0f - s[lane].trip) + p[lane].mean / (1.0f - p[lane].trip);
    let_through.c[lane] = fma(rest, wave.c[lane], let_through.c[lane]);
  }
  return clamp(Spectrum(1.0f) - let_through, 0.0f, 1.0f);
}

}  // namespace tessera::render::TESSERA_ISA
