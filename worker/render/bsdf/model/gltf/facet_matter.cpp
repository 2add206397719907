#include "render/bsdf/model/gltf/facet_matter.h"

namespace tessera::render::TESSERA_ISA {

Spectrum FacetMatter::film_reflectance(Float cosine, Spectrum along_normal) const {
  // Films are described from outside, and reflect the same from both sides of a refracted ray.
  const auto outside = [&](Float index) {
    return select(inside, safe_sqrt(1.0f - (1.0f - sqr(cosine)) / sqr(index)), cosine);
  };
  if (!disperses) return film.reflectance(outside(eta), along_normal, active);
  Spectrum result;
  for (int c = 0; c < kSpectrumLanes; ++c)
    result.c[c] = film.reflectance(outside(etas.c[c]), along_normal, active).c[c];
  return result;
}

Spectrum FacetMatter::film_energy(Float cosine, const LayerEnergy& energy, Spectrum along_normal) const {
  const FacetCosines cosines = rows.facets_at(cosine, film.table);
  const auto beside_rise = [&](Float at) {
    const Float rise = schlick_power(at);
    return (film_reflectance(at, along_normal) - Spectrum(rise)) / max(1.0f - rise, 1e-3f);
  };
  const Spectrum beside = lerp(cosines.share, beside_rise(cosines.larger), beside_rise(cosines.smaller));
  return max(beside * energy.normal + Spectrum(energy.grazing), 0.0f);
}

FilmMeans FacetMatter::film_means() {
  // Gauss's five points in the square of the cosine, which diffuse light is even in.
  constexpr int kPoints = 5;
  constexpr float kSquares[kPoints] = {0.04691008f, 0.23076534f, 0.5f, 0.76923466f, 0.95308992f};
  constexpr float kWeights[kPoints] = {0.11846344f, 0.23931434f, 0.28444444f, 0.23931434f, 0.11846344f};
  const auto mean_over = [&](auto&& f) {
    const auto at = [&](int i) {
      const Float cosine = sqrt(Float(kSquares[i]));
      return f(cosine, rows.at(cosine)) * kWeights[i];
    };
    auto sum = at(0);
    for (int i = 1; i < kPoints; ++i) sum = sum + at(i);
    return sum;
  };
  const auto film_mean = [&](Spectrum along_normal) {
    return mean_over([&](Float cosine, const LayerEnergy& at) {
      return film_energy(cosine, at, along_normal) / max(at.mirror(), 1e-3f);
    });
  };
  means.dielectric = film_mean(dielectric0);
  means.metal = film_mean(base);
  means.base =
      mean_over([&](Float cosine, const LayerEnergy& at) { return mean_of(base_factor(cosine, at)); });
  return means;
}

}  // namespace tessera::render::TESSERA_ISA
