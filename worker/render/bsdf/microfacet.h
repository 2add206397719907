// Rough boundaries as microfacets: GGX normals [Trowbridge & Reitz 1975; Walter et al. 2007], anisotropic, with Smith's
// height-correlated masking and shadowing [Heitz 2014].
//
// All directions here lie above the surface (z >= 0): a model seen from below mirrors the world at z = 0, which
// changes nothing, as the distribution is even in x and y.
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/core/constants.h"
#include "render/core/vec.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

/// Below this roughness a boundary is a mirror: the lobe is too narrow for single precision.
inline constexpr float kSmoothAlpha = 1e-3f;

struct Ggx {
  Float alpha_x, alpha_y;

  /// D of the direction of `h`, which may have any length: area of microfacets that face it, per solid angle and per
  /// area of the surface.
  TESSERA_INLINE Float density(Vec3 h) const {
    constexpr float kTiny = 1e-37f;
    const Float area = alpha_x * alpha_y;
    const Float slope = sqr(h.x * alpha_y) + sqr(h.y * alpha_x) + sqr(h.z * area);
    return kInvPi * area * sqr(area * length_squared(h) / max(slope, kTiny));
  }

  /// |w| after the stretch that makes the distribution a hemisphere: cos(theta) (1 + 2 Lambda(w)), so that
  /// G1(w) = 2 z / (z + s(w)) and G2(wo, wi) = 2 zo zi / (s(wo) zi + s(wi) zo).
  TESSERA_INLINE Float stretched_length(Vec3 w) const {
    return sqrt(sqr(alpha_x * w.x) + sqr(alpha_y * w.y) + sqr(w.z));
  }

  /// A normal with density D(wm) G1(wo) max(0, dot(wo, wm)) / cos(theta_o), by sampling the spherical cap that
  /// reflection off the unit hemisphere covers [Dupuy & Benyoub 2023]. The cap is a disk by Lambert's equal-area
  /// projection, which needs no trigonometry beyond the disk's and loses no precision near its pole.
  TESSERA_INLINE Vec3 sample_visible(Vec3 wo, Vec2 u) const {
    const Vec3 w = normalize(Vec3{alpha_x * wo.x, alpha_y * wo.y, wo.z});
    const Vec2 disk = square_to_disk(u);
    const Float height = 1.0f + w.z;
    const Float depth = (sqr(disk.x) + sqr(disk.y)) * height;  // below the pole, 0 .. height
    const Float scale = safe_sqrt(height * (2.0f - depth));
    const Vec3 h{fma(disk.x, scale, w.x), fma(disk.y, scale, w.y), 1.0f - depth + w.z};
    return normalize(Vec3{alpha_x * h.x, alpha_y * h.y, max(h.z, 0.0f)});
  }
};

/// Whether the boundary with roughness slots `slot` and `slot` + 1 is a mirror.
TESSERA_INLINE Mask is_smooth(const BsdfParams& params, int slot) {
  return max(params.scalars[slot], params.scalars[slot + 1]) < kSmoothAlpha;
}

/// Also where indices match so well that roughness hardly spreads refracted light: a lobe no wider than that of
/// kSmoothAlpha.
TESSERA_INLINE Mask is_smooth_dielectric(const BsdfParams& params, int alpha_slot, int eta_slot) {
  constexpr float kSmoothEta = 1e-3f;
  return is_smooth(params, alpha_slot) | (abs(params.scalars[eta_slot] - 1.0f) < kSmoothEta);
}

/// The distribution of the two roughness slots from `slot` on. One axis of an anisotropic surface may be (nearly)
/// smooth.
TESSERA_INLINE Ggx ggx_of(const BsdfParams& params, int slot) {
  constexpr float kSmallestAlpha = 1e-4f;
  return {max(params.scalars[slot], kSmallestAlpha), max(params.scalars[slot + 1], kSmallestAlpha)};
}

/// `w` as the side on which wo lies sees it: mirrored at z = 0 where `below`.
TESSERA_INLINE Vec3 mirror_if(Mask below, Vec3 w) { return {w.x, w.y, select(below, -w.z, w.z)}; }

/// Single scattering by mirrors, without their Fresnel factor, for wo and wi above the surface.
struct MicrofacetReflection {
  Float f_cos;
  Float pdf;    // of reflection at a visible normal
  Float cos_m;  // between wo and the microfacet's normal
};

TESSERA_INLINE MicrofacetReflection eval_reflection(const Ggx& ggx, Vec3 wo, Vec3 wi) {
  const Vec3 h = wo + wi;
  const Float d = ggx.density(h);
  const Float so = ggx.stretched_length(wo), si = ggx.stretched_length(wi);
  // D G2 / (4 zo), and the visible density times the Jacobian 1 / (4 dot(wo, wm)).
  return {0.5f * d * wi.z / (so * wi.z + si * wo.z), 0.5f * d / (wo.z + so), 0.5f * length(h)};
}

/// `w` reflected at a normal with dot(w, wm) = cos_m.
TESSERA_INLINE Vec3 reflect(Vec3 w, Vec3 wm, Float cos_m) { return wm * (2.0f * cos_m) - w; }

/// pdf of reflection at the visible normal wm.
TESSERA_INLINE Float reflection_pdf(const Ggx& ggx, Vec3 wo, Vec3 wm) {
  return 0.5f * ggx.density(wm) / (wo.z + ggx.stretched_length(wo));
}

/// f cos / pdf of scattering at a visible normal, without the Fresnel factor: G2 / G1, at most 1. For refraction too,
/// with wi mirrored to above the surface.
TESSERA_INLINE Float visible_weight(const Ggx& ggx, Vec3 wo, Vec3 wi) {
  const Float so = ggx.stretched_length(wo), si = ggx.stretched_length(wi);
  return wi.z * (wo.z + so) / (so * wi.z + si * wo.z);
}

}  // namespace tessera::render::TESSERA_ISA
