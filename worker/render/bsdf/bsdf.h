// The interface of the BSDF models. One model a file; all models are stateless, so one object serves every
// material of its kind.
//
// Directions are unit vectors in the local shading frame (normal +z, tangents x and y along dp/du and
// across), pointing away from the surface. wo is where the path came from, wi where it goes on; both may lie
// below the surface.
#pragma once

#include "render/bsdf/kinds.h"
#include "render/bsdf/material_table.h"
#include "render/color/spectra.h"
#include "render/core/model_table.h"
#include "render/core/texture_point.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Means over diffuse light, of facets under a thin film: their reflectance where the dielectric and where
/// the metal is below it, and what the dielectric leaves to its base.
struct FilmMeans {
  Spectrum dielectric, metal;
  Float base;
};

/// The slots of the material at each lane's hit point, textures already looked up.
struct BsdfParams {
  Spectrum spectra[kMaterialSpectra];
  Float scalars[kMaterialScalars];
#ifdef TESSERA_SPECTRAL
  Float luminance;  // luminance of spectra[0] in daylight
  Wavelengths wavelengths;
  Spectrum
      etas;  // where some lane has kDisperses: kEta, which is that of the first wavelength, at all of them
#endif
  Int coat_table;
  const float* coat_tables;  // MaterialTable::coat_tables.data()
  const float* film_table;   // MaterialTable::film_table.data()
  Int flags;                 // MaterialFlags
  Int variants;              // bits of each lane's kind (kinds.h)
  // All that some lane has, of whatever kind: models look at their variants only where set.
  std::int32_t some_flags, some_variants;
  // With kUsesExtended
  Spectrum extended_spectra[kExtendedSpectra];
  Float extended[kExtendedScalars];
  // With kUsesFurther
  Color further_colors[kFurtherColors];
  Float further[kFurtherScalars];
  Vec3 upper_normal;  // normal of the layer above the base, in the shading frame
  FilmMeans film;     // prepared

  /// Lanes that have `flag`.
  TESSERA_INLINE Mask with(MaterialFlags flag) const { return (flags & flag) != 0; }
  /// Lanes that are of this variant.
  TESSERA_INLINE Mask of_variant(std::int32_t variant) const { return (variants & variant) != 0; }
};

/// Luminance, in daylight, of the colour of spectra[0].
TESSERA_INLINE Float base_luminance(const BsdfParams& params) {
#ifdef TESSERA_SPECTRAL
  return params.luminance;
#else
  return luminance(params.spectra[0]);
#endif
}

/// Quantity that a path carries: radiance if it comes from the eye, importance (the flux of light particles)
/// if it comes from a light. They differ where light is refracted [Veach 1997, section 5.2].
enum class Transport { kRadiance, kImportance };

/// `f`, given for radiance, as it is for `transport`: refraction to a side of relative index `eta` scales
/// radiance by 1 / eta^2, and leaves importance as it is.
TESSERA_INLINE Spectrum transported(Transport transport, Mask refracted, Float eta, Spectrum f) {
  return transport == Transport::kRadiance ? f : select(refracted, f * sqr(eta), f);
}

struct BsdfEval {
  Spectrum f_cos;  // f(wo, wi) |cos theta_i|, 1/sr; without delta lobes
  Float pdf;       // density with which sample() returns wi, by solid angle; without delta lobes
};

struct BsdfSample {
  Vec3 wi;
  Spectrum weight;  // f |cos theta_i| / pdf, over all lobes that could give wi
  Float pdf;        // solid angle; for a delta lobe the probability of the lobe
  Float eta;        // transmission: index of the side that wi is on over that of wo's side; else 1
  Mask valid;       // a direction was found; else the path ends
  Mask specular;    // a delta lobe was sampled: not to be weighed against light sampling
  Mask transmission;
};

/// Light that goes straight on as if the surface were not there.
struct Passing {
  Float probability;  // probability that light passes; what does not is scattered
  Spectrum weight;    // factor of the light that passes
};

/// `part` of `whole`, in the mean of the bands; the larger is `whole`.
TESSERA_INLINE Float share_of(Spectrum part, Spectrum whole) {
  Float of(0.0f), all(0.0f);
  for (int c = 0; c < kSpectrumLanes; ++c) of = of + part.c[c], all = all + whole.c[c];
  return clamp(of / max(all, 1e-30f), 0.0f, 1.0f);
}

class Bsdf {
 public:
  explicit constexpr Bsdf(std::int32_t model_traits = 0) : traits(model_traits) {}
  virtual ~Bsdf() = default;

  /// BsdfTraits: what holds whatever the parameters are.
  const std::int32_t traits;

  /// Value and density. Lanes that are not active may hold anything, and give anything.
  virtual BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport,
                        Mask active) const = 0;
  /// `u_lobe` and `u` are uniform in [0, 1).
  virtual BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                            Mask active) const = 0;
  /// With kSomeDiffuse: the part of the light of eval() that is of diffuse lobes, from 0 to 1; the rest is of
  /// glossy ones.
  virtual Float diffuse_share(const BsdfParams&, Vec3, Vec3, Mask) const { return Float(0.0f); }
  /// With kReflectsOnly: alpha of the microfacets of its narrowest lobe that is not diffuse, or of facets
  /// that spread light as much; 0 where that is a delta lobe, or not known.
  virtual Float least_alpha(const BsdfParams&) const { return Float(0.0f); }
  /// An estimate of the surface's colour, for the albedo AOV.
  virtual Spectrum albedo(const BsdfParams&) const { return Spectrum(1.0f); }
  /// With kPrepared: completes the slots of `lanes` once constants and textures are in them.
  virtual void prepare(const TexturePoint&, Mask, BsdfParams&) const {}
  /// With kPassesStraight: the light, met under |cosine| with the shading normal, that is not scattered at
  /// all in volumetric scenes. There, sample() with u_lobe = 0 scatters the rest. Of clear glass: what passes
  /// one surface, seen from outside, unbent (SceneTables::straight_shadows).
  virtual Passing passing(const BsdfParams&, Float) const { return {Float(0.0f), Spectrum(1.0f)}; }
};

/// The model of a kind; null for kMix, which is not asked.
const Bsdf* bsdf_model(BsdfKind kind);

/// ModelOf calls this.
void set_model(BsdfKind kind, const Bsdf& model);

/// Adds a model that has no kind of its own; materials of the kind returned have it. Before anything is
/// rendered: not thread-safe.
BsdfKind add_bsdf(const Bsdf& model);

}  // namespace tessera::render::TESSERA_ISA
