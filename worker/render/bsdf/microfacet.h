// Rough boundaries as microfacets, anisotropic, with Smith's masking and shadowing.
//
// Normals are distributed as GGX [Trowbridge & Reitz 1975; Walter et al. 2007] or, with kBeckmann, as
// Beckmann's [Beckmann & Spizzichino 1963]. Masking and shadowing are correlated by height [Heitz 2014] as in
// pbrt-v4 or, with kSeparableMasking, independent of each other as in Mitsuba 3: G2(wo, wi) = G1(wo) G1(wi).
//
// All directions here lie above the surface (z >= 0): a model seen from below mirrors the world at z = 0,
// which changes nothing, as the distributions are even in x and y.
#pragma once

#include "render/bsdf/beckmann.h"
#include "render/bsdf/bsdf.h"
#include "render/core/constants.h"
#include "render/core/vec.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

/// Below this roughness a boundary is a mirror: the lobe is too narrow for single precision.
inline constexpr float kSmoothAlpha = 1e-3f;

/// GGX with correlated masking: what most materials are, and fastest.
struct Ggx {
  Float alpha_x, alpha_y;

  /// D of the direction of `h`, which may have any length: area of microfacets that face it, per solid angle
  /// and per area of the surface.
  TESSERA_INLINE Float density(Vec3 h) const {
    constexpr float kTiny = 1e-37f;
    const Float area = alpha_x * alpha_y;
    const Float slope = length_squared(Vec3{h.x * alpha_y, h.y * alpha_x, h.z * area});
    return kInvPi * area * sqr(area * length_squared(h) / max(slope, kTiny));
  }

  /// s(w) = cos(theta) (1 + 2 Lambda(w)), with which G1(w) = 2 z / (z + s(w)). For GGX it is |w| after the
  /// stretch that makes the distribution a hemisphere.
  TESSERA_INLINE Float masking_length(Vec3 w) const {
    return length(Vec3{alpha_x * w.x, alpha_y * w.y, w.z});
  }

  /// m with which G2(wo, wi) = 2 zo zi / m, from the masking lengths of both.
  TESSERA_INLINE Float masking_pair(Float so, Float zo, Float si, Float zi) const {
    return fma(so, zi, si * zo);
  }

  /// A normal with density D(wm) G1(wo) max(0, dot(wo, wm)) / cos(theta_o). By sampling the spherical cap
  /// that reflection off the unit hemisphere covers [Dupuy & Benyoub 2023]. The cap is a disk by Lambert's
  /// equal-area projection, which needs no trigonometry beyond the disk's and loses no precision near its
  /// pole.
  TESSERA_INLINE Vec3 sample_visible(Vec3 wo, Vec2 u) const {
    const Vec3 w = normalize(Vec3{alpha_x * wo.x, alpha_y * wo.y, wo.z});
    const Vec2 disk = square_to_disk(u);
    const Float height = 1.0f + w.z;
    const Float depth = fma(disk.x, disk.x, sqr(disk.y)) * height;  // below the pole, 0 .. height
    const Float scale = safe_sqrt(height * (2.0f - depth));
    const Vec3 h{fma(disk.x, scale, w.x), fma(disk.y, scale, w.y), 1.0f - depth + w.z};
    return normalize(Vec3{alpha_x * h.x, alpha_y * h.y, max(h.z, 0.0f)});
  }
};

/// The same where some lanes are Beckmann's or have separable masking.
struct Microfacets : Ggx {
  bool some_beckmann;
  Mask beckmann, separable;

  TESSERA_INLINE Float density(Vec3 h) const {
    const Float ggx = Ggx::density(h);
    return some_beckmann ? select(beckmann, beckmann_density(h, alpha_x, alpha_y), ggx) : ggx;
  }
  TESSERA_INLINE Float masking_length(Vec3 w) const {
    const Float ggx = Ggx::masking_length(w);
    if (!some_beckmann) return ggx;
    return select(beckmann, beckmann_masking_length(w.z, sqrt(sqr(alpha_x * w.x) + sqr(alpha_y * w.y))), ggx);
  }
  TESSERA_INLINE Float masking_pair(Float so, Float zo, Float si, Float zi) const {
    return select(separable, 0.5f * (zo + so) * (zi + si), Ggx::masking_pair(so, zo, si, zi));
  }
  TESSERA_INLINE Vec3 sample_visible(Vec3 wo, Vec2 u) const {
    const Vec3 ggx = Ggx::sample_visible(wo, u);
    if (!some_beckmann) return ggx;
    const Vec2 slope = beckmann_visible_slope(normalize(Vec3{alpha_x * wo.x, alpha_y * wo.y, wo.z}), u);
    return select(beckmann, normalize(Vec3{-alpha_x * slope.x, -alpha_y * slope.y, Float(1.0f)}), ggx);
  }
};

/// Whether the boundary with roughness slots `slot` and `slot` + 1 is a mirror.
TESSERA_INLINE Mask is_smooth(const BsdfParams& params, int slot) {
  return max(params.scalars[slot], params.scalars[slot + 1]) < kSmoothAlpha;
}

/// Also where indices match so well that roughness hardly spreads refracted light: a lobe no wider than that
/// of kSmoothAlpha.
TESSERA_INLINE Mask is_smooth_dielectric(const BsdfParams& params, int alpha_slot, int eta_slot) {
  constexpr float kSmoothEta = 1e-3f;
  return is_smooth(params, alpha_slot) | (abs(params.scalars[eta_slot] - 1.0f) < kSmoothEta);
}

/// One axis of an anisotropic surface may be (nearly) smooth.
TESSERA_INLINE Ggx ggx_of(Float alpha_x, Float alpha_y) {
  constexpr float kSmallestAlpha = 1e-4f;
  return {max(alpha_x, kSmallestAlpha), max(alpha_y, kSmallestAlpha)};
}

/// Microfacets of these roughnesses, of the kind that the flags say.
TESSERA_INLINE Microfacets microfacets_of(const BsdfParams& params, Float alpha_x, Float alpha_y) {
  return {ggx_of(alpha_x, alpha_y), (params.some_variants & kBeckmann) != 0, params.of_variant(kBeckmann),
          params.of_variant(kSeparableMasking)};
}

/// f(facets) with the microfacets of the two roughness slots from `slot` on: Ggx unless some lane is special.
template <class F>
TESSERA_INLINE auto with_microfacets(const BsdfParams& params, int slot, F&& f) {
  const Float x = params.scalars[slot], y = params.scalars[slot + 1];
  if (params.some_variants & (kBeckmann | kSeparableMasking)) return f(microfacets_of(params, x, y));
  return f(ggx_of(x, y));
}

/// `w` as the side on which wo lies sees it: mirrored at z = 0 where `below`.
TESSERA_INLINE Vec3 mirror_if(Mask below, Vec3 w) { return {w.x, w.y, select(below, -w.z, w.z)}; }

/// Single scattering by mirrors, without their Fresnel factor, for wo and wi above the surface.
struct MicrofacetReflection {
  Float f_cos;
  Float pdf;    // density of reflection at a visible normal
  Float cos_m;  // cosine between wo and the microfacet's normal
};

template <class Facets>
TESSERA_INLINE MicrofacetReflection eval_reflection(const Facets& facets, Vec3 wo, Vec3 wi) {
  const Vec3 h = wo + wi;
  const Float d = facets.density(h);
  const Float so = facets.masking_length(wo), si = facets.masking_length(wi);
  // D G2 / (4 zo), and the visible density times the Jacobian 1 / (4 dot(wo, wm)).
  return {0.5f * d * wi.z / facets.masking_pair(so, wo.z, si, wi.z), 0.5f * d / (wo.z + so),
          0.5f * length(h)};
}

/// `w` reflected at a normal with dot(w, wm) = cos_m.
TESSERA_INLINE Vec3 reflect(Vec3 w, Vec3 wm, Float cos_m) { return fma(wm, 2.0f * cos_m, -w); }

/// pdf of reflection at the visible normal wm.
template <class Facets>
TESSERA_INLINE Float reflection_pdf(const Facets& facets, Vec3 wo, Vec3 wm) {
  return 0.5f * facets.density(wm) / (wo.z + facets.masking_length(wo));
}

/// f cos / pdf of scattering at a visible normal, without the Fresnel factor: G2 / G1, at most 1. For
/// refraction too, with wi mirrored to above the surface.
template <class Facets>
TESSERA_INLINE Float visible_weight(const Facets& facets, Vec3 wo, Vec3 wi) {
  const Float so = facets.masking_length(wo), si = facets.masking_length(wi);
  return wi.z * (wo.z + so) / facets.masking_pair(so, wo.z, si, wi.z);
}

}  // namespace tessera::render::TESSERA_ISA
