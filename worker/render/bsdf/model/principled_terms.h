// Terms that the two principled models share: those of Disney's model [Burley 2012,
// 2015] as Mitsuba 3 renders it.
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/bsdf/fresnel.h"
#include "render/bsdf/microfacet.h"

namespace tessera::render::TESSERA_ISA {

/// (1 - c)^5, of Schlick's approximation.
TESSERA_INLINE Float schlick_power(Float cosine) {
  const Float m = clamp(1.0f - cosine, 0.0f, 1.0f);
  return sqr(sqr(m)) * m;
}

/// How far Schlick's reflectance is on its way from that along the normal to 1: by the cosine on the side of
/// the smaller index. `eta` is the index of the other side over that of `cosine`'s side.
TESSERA_INLINE Float schlick_weight(Float cosine, Float eta) {
  const Float refracted = safe_sqrt(1.0f - (1.0f - sqr(cosine)) / sqr(eta));
  return schlick_power(select(eta > 1.0f, cosine, refracted));
}

/// The base colour at luminance 1; white where it is black.
TESSERA_INLINE Spectrum hue(const BsdfParams& params, Spectrum colour) {
  const Float y = base_luminance(params);
  const Mask lit = y > 0.0f;
  return select(lit, colour * (1.0f / select(lit, y, 1.0f)), Spectrum(1.0f));
}

/// Reflectance along the normal of the tinted dielectric.
TESSERA_INLINE Spectrum tinted_normal_reflectance(const BsdfParams& params, Spectrum colour, Float eta) {
  return hue(params, colour) * sqr((eta - 1.0f) / (eta + 1.0f));
}

/// In `lanes`, where Disney's "specular" was looked up in place of the index: the index with which a
/// dielectric has 0.08 times that as its reflectance along the normal.
TESSERA_INLINE void principled_index_of_specular(Mask lanes, BsdfParams& params) {
  constexpr float kLeast = 1e-3f;  // Nothing is refracted without a change of index.
  const Float specular = clamp(params.scalars[slot::kEta], kLeast, 1.0f);
  params.scalars[slot::kEta] =
      select(lanes, 2.0f / (1.0f - sqrt(0.08f * specular)) - 1.0f, params.scalars[slot::kEta]);
}

/// GGX with Disney's roughness, always with separable masking.
TESSERA_INLINE Microfacets principled_facets(const BsdfParams& params, Float roughness) {
  constexpr float kSmallestAlpha = 1e-3f;
  const Float aspect = safe_sqrt(1.0f - 0.9f * params.scalars[slot::kAnisotropic]);
  const Float alpha2 = sqr(roughness);
  return microfacets_of(params, max(alpha2 / max(aspect, 1e-3f), kSmallestAlpha),
                        max(alpha2 * aspect, kSmallestAlpha));
}

/// Diffuse reflection, retro-reflection and fake subsurface scattering, without colour and 1 / pi. `cos_d` is
/// between wi and the half vector.
TESSERA_INLINE Float principled_diffuse(const BsdfParams& params, Float zo, Float zi, Float cos_d) {
  const Float fo = schlick_power(zo), fi = schlick_power(zi);
  const Float retro = 2.0f * params.scalars[slot::kRoughness] * sqr(cos_d);
  const Float surface =
      (1.0f - 0.5f * fo) * (1.0f - 0.5f * fi) + retro * (fo + fi + fo * fi * (retro - 1.0f));
  const Float flatness = params.extended[slot::kFlatness];
  const Float flat90 = 0.5f * retro;
  const Float flat = lerp(fo, Float(1.0f), flat90) * lerp(fi, Float(1.0f), flat90);
  const Float subsurface = 1.25f * (flat * (1.0f / (zo + zi) - 0.5f) + 0.5f);
  return lerp(flatness, surface, subsurface);
}

/// The sheen's f, without the lobe's share.
TESSERA_INLINE Spectrum principled_sheen(const BsdfParams& params, Spectrum colour, Float cos_d) {
  const Spectrum tint = lerp(params.extended[slot::kSheenTint], Spectrum(1.0f), hue(params, colour));
  return tint * (params.extended[slot::kSheen] * schlick_power(abs(cos_d)));
}

}  // namespace tessera::render::TESSERA_ISA
