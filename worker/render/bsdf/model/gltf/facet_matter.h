// The matter of the facets: a metal and a dielectric in proportions, in part under a thin film.
#pragma once

#include "render/bsdf/model/gltf/layer_rows.h"
#include "render/bsdf/model/gltf/thin_film.h"
#include "render/bsdf/model/principled_terms.h"

namespace tessera::render::TESSERA_ISA {

TESSERA_INLINE Float schlick(Float weight, Float f0, Float f90) {
  return f0 * (1.0f - weight) + f90 * weight;
}
TESSERA_INLINE Spectrum schlick(Float weight, Spectrum f0, Float f90) {
  return f0 * (1.0f - weight) + Spectrum(f90 * weight);
}

/// Reflectance of all facets together, and of the dielectric alone.
struct FacetReflectance {
  Spectrum all, dielectric;
};

/// A part of the light that layers take or leave: of RGB one number, by the largest component, so that the
/// layers below keep their hue [glTF 2.0, appendix B]. At wavelengths each has its own: the largest of those
/// that a path happens to have would be another for each path, and for each sensor.
#ifdef TESSERA_SPECTRAL
using LayerShare = Spectrum;
TESSERA_INLINE LayerShare layer_share(Spectrum of) { return of; }
TESSERA_INLINE Float mean_of(LayerShare share) { return share.mean(); }
#else
using LayerShare = Float;
TESSERA_INLINE LayerShare layer_share(Spectrum of) { return of.max_component(); }
TESSERA_INLINE Float mean_of(LayerShare share) { return share; }
#endif

/// Seen from one side. Films and dispersion are looked at only where some lane has them.
struct FacetMatter {
  bool filmed, disperses;
  Mask active, inside;
  Float eta;                 // index of the other side over that of wo's
  Spectrum etas;             // index of each channel, where it disperses
  Spectrum base;             // base colour
  Float metal, glass;        // shares: metal, what refracts
  Float share;               // share of the facets that is dielectric
  Spectrum dielectric0, f0;  // reflectance along the normal, of the dielectric and of all
  Float dielectric90, f90;   // ... and along the surface
  LayerShare weakest;        // of dielectric0
  Ggx facets;
  LayerRows rows;    // the layer table for the facets
  LayerEnergy mean;  // over diffuse light
  Float film_share;
  ThinFilm film;
  FilmMeans means;

  TESSERA_INLINE FacetMatter(const BsdfParams& params, Mask below, Mask lanes)
      : active(lanes),
        inside(below & params.with(kHasInside)),
        eta(select(inside, 1.0f / params.scalars[slot::kEta], params.scalars[slot::kEta])),
        base(clamp(params.spectra[slot::kReflectance], 0.0f, 1.0f)),
        facets(facets_of(params)),
        rows(params, sqrt(sqrt(facets.alpha_x * facets.alpha_y)), lanes),
        mean(rows.mean()) {
    set_further(params);
    metal = select(inside, 0.0f, params.extended[slot::kMetallic]);
    glass = (1.0f - params.extended[slot::kMetallic]) * params.extended[slot::kTransmission];
    share = select(inside, glass, 1.0f - metal);
    dielectric90 = params.extended[slot::kSpecular];
    const auto along_normal = [](Float index) { return sqr((index - 1.0f) / (index + 1.0f)); };
    const Float normal = along_normal(eta);
    for (int c = 0; c < kSpectrumLanes; ++c)
      dielectric0.c[c] =
          min((disperses ? along_normal(etas.c[c]) : normal) * params.spectra[slot::kSpecularColor].c[c],
              1.0f) *
          dielectric90;
    f0 = dielectric0 * share + base * metal;
    f90 = dielectric90 * share + metal;
    weakest = layer_share(dielectric0);
  }

  TESSERA_INLINE FacetReflectance reflectance(Float cosine) const {
    FacetReflectance result;
    if (disperses) {
      for (int c = 0; c < kSpectrumLanes; ++c) {
        const Float weight = schlick_weight(cosine, etas.c[c]);
        result.all.c[c] = schlick(weight, f0.c[c], f90);
        result.dielectric.c[c] = schlick(weight, dielectric0.c[c], dielectric90);
      }
    } else {
      const Float weight = schlick_weight(cosine, eta);
      result = {schlick(weight, f0, f90), schlick(weight, dielectric0, dielectric90)};
    }
    if (filmed)
      put_film(result, [&](Spectrum along_normal) { return film_reflectance(cosine, along_normal); });
    return result;
  }
  /// Light along `cosine` to the normal that the facets reflect; `energy` is that of the rows.
  TESSERA_INLINE FacetReflectance reflected(Float cosine, const LayerEnergy& energy) const {
    FacetReflectance result{energy.of(f0, f90), energy.of(dielectric0, dielectric90)};
    if (filmed)
      put_film(result, [&](Spectrum along_normal) { return film_energy(cosine, energy, along_normal); });
    return result;
  }

  /// The part of that light that the dielectric leaves to the base.
  TESSERA_INLINE LayerShare base_factor(Float cosine, const LayerEnergy& energy) const {
    if (!filmed)
      return left_to_base(energy, energy.of(weakest, dielectric90),
                          schlick_mean(weakest, LayerShare(dielectric90)));
    const Spectrum single =
        lerp(film_share, energy.of(dielectric0, dielectric90), film_energy(cosine, energy, dielectric0));
    return left_to_base(energy, layer_share(single), layer_share(dielectric_mean()));
  }
  /// The same over diffuse light.
  TESSERA_INLINE LayerShare mean_base_factor() const {
    const LayerShare plain =
        left_to_base(mean, mean.of(weakest, dielectric90), schlick_mean(weakest, LayerShare(dielectric90)));
    return filmed ? select(film_share > 0.0f, mean_below_film(), plain) : plain;
  }

  /// Light scattered between the facets, as a part of what single scattering loses.
  TESSERA_INLINE Spectrum between() const {
    const Float mirror = mean.mirror();
    const Spectrum dielectric =
        filmed ? dielectric_mean() : schlick_mean(dielectric0, Spectrum(dielectric90));
    Spectrum metals = schlick_mean(base, Spectrum(1.0f));
    if (filmed) metals = lerp(film_share, metals, means.metal);
    Spectrum result;
    for (int c = 0; c < kSpectrumLanes; ++c)
      result.c[c] =
          share * between_facets(dielectric.c[c], mirror) + metal * between_facets(metals.c[c], mirror);
    return result;
  }

  /// Means over diffuse light, for prepare().
  FilmMeans film_means();

 private:
  static TESSERA_INLINE Ggx facets_of(const BsdfParams& params) {
    const Float alpha = max(sqr(params.scalars[slot::kRoughness]), kLeastLayerAlpha);
    return {lerp(sqr(params.scalars[slot::kAnisotropic]), alpha, Float(1.0f)), alpha};
  }
  TESSERA_INLINE void set_further(const BsdfParams& params) {
    filmed = disperses = false;
    if ((params.some_flags & kUsesFurther) == 0) return;
    const Mask further = active & params.with(kUsesFurther);
    film_share = select_or_zero(further, min(params.further[slot::kFilm], 1.0f));
    filmed = any(film_share > 0.0f);
    film.table = params.film_table;
#ifdef TESSERA_SPECTRAL
    film.wavelengths = params.wavelengths;
#endif
    film.eta = max(params.further[slot::kFilmEta], 1.0f);
    film.thickness_nm = params.further[slot::kFilmThickness];
    means = params.film;
    const Float spread = select_or_zero(further, params.further[slot::kSpread]);
    disperses = !kSpectral && any(spread != 0.0f);  // elsewhere kEta is that of the first wavelength
    if (!disperses) return;
    for (int c = 0; c < kSpectrumLanes; ++c) {
      const Float index = fma(spread, Float(static_cast<float>(c - 1)), params.scalars[slot::kEta]);
      etas.c[c] = select(inside, 1.0f / index, index);
    }
  }

  Spectrum film_reflectance(Float cosine, Spectrum along_normal) const;
  /// Light along `cosine` that facets with a film reflect. Like Schlick's reflectance, that of films rises to
  /// 1 along the surface: what it has beside that rise is taken under two cosines for all facets.
  Spectrum film_energy(Float cosine, const LayerEnergy& energy, Spectrum along_normal) const;

  /// Mixes what facets with a film reflect, film(reflectance of the base along the normal), into what others
  /// do.
  template <class F>
  TESSERA_INLINE void put_film(FacetReflectance& plain, F&& film_of) const {
    Spectrum metals = plain.all - plain.dielectric * share;
    plain.dielectric = lerp(film_share, plain.dielectric, film_of(dielectric0));
    if (any(active & (metal > 0.0f))) metals = lerp(film_share, metals, film_of(base) * metal);
    plain.all = plain.dielectric * share + metals;
  }

  TESSERA_INLINE Spectrum dielectric_mean() const {
    return lerp(film_share, schlick_mean(dielectric0, Spectrum(dielectric90)), means.dielectric);
  }
  TESSERA_INLINE Float left_to_base(const LayerEnergy& energy, Float single, Float mean_reflectance) const {
    return max(1.0f - single - (1.0f - energy.mirror()) * between_facets(mean_reflectance, mean.mirror()),
               0.0f);
  }
#ifdef TESSERA_SPECTRAL
  TESSERA_INLINE Spectrum left_to_base(const LayerEnergy& energy, Spectrum single,
                                       Spectrum mean_reflectance) const {
    Spectrum result;
    for (int c = 0; c < kSpectrumLanes; ++c)
      result.c[c] = left_to_base(energy, single.c[c], mean_reflectance.c[c]);
    return result;
  }
  /// By the means of each wavelength, as means.base is of all.
  TESSERA_INLINE Spectrum mean_below_film() const {
    const Spectrum single =
        lerp(film_share, mean.of(dielectric0, dielectric90), means.dielectric * mean.mirror());
    return left_to_base(mean, single, dielectric_mean());
  }
#else
  TESSERA_INLINE Float mean_below_film() const { return means.base; }
#endif
};

}  // namespace tessera::render::TESSERA_ISA
