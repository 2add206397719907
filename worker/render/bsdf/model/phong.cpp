// A Lambertian base and a glossy lobe about the mirror direction, as textbooks have them: Phong's, normalised
// [Phong 1975; Lafortune & Willems 1994], Blinn's [Blinn 1977], or a mirror.
//
// spectra[0]  reflectance of the base
// spectra[1]  reflectance of the lobe along the normal; both are scaled down where they add up to more than 1
// scalars[2]  exponent, clamped to [0, slot::kMostPhongExponent]
// flags       kBlinn: the lobe is of the half vector; kMirrorLobe: it is a mirror; else it is Phong's
#include "render/bsdf/bsdf.h"

#include "render/bsdf/microfacet.h"
#include "render/core/constants.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class PhongBsdf final : public Bsdf {
 public:
  PhongBsdf() : Bsdf(kReflectsOnly | kSomeDiffuse) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  Float diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const override;
  Float least_alpha(const BsdfParams& params) const override;
  Spectrum albedo(const BsdfParams& params) const override;
};

/// The two lobes, and the probability of choosing the base: by the larger components.
struct Lobes {
  Spectrum base, gloss;
  Float base_share;
  Float exponent;
  Mask blinn, mirror;
  Mask lit;  // not black altogether

  TESSERA_INLINE explicit Lobes(const BsdfParams& params)
      : base(clamp(params.spectra[slot::kReflectance], 0.0f, 1.0f)),
        gloss(clamp(params.spectra[slot::kGloss], 0.0f, 1.0f)),
        exponent(clamp(params.scalars[slot::kExponent], 0.0f, slot::kMostPhongExponent)),
        blinn(params.of_variant(kBlinn)),
        mirror(params.of_variant(kMirrorLobe)) {
    // Nothing gives back more than it gets: colours keep their hue, and wavelengths know nothing of each
    // other.
    const Spectrum both = base + gloss;
    const Float largest = both.max_component();
    for (int c = 0; c < kSpectrumLanes; ++c) {
      const Float scale = 1.0f / max(kSpectral ? both.c[c] : largest, 1.0f);
      base.c[c] = base.c[c] * scale, gloss.c[c] = gloss.c[c] * scale;
    }
    const Float b = base.max_component(), sum = b + gloss.max_component();
    lit = sum > 0.0f;
    base_share = b / select(lit, sum, 1.0f);
  }

  /// Factor of cos^n that makes the lobe reflect `gloss` along the normal. Blinn's: [Giesen 2009].
  TESSERA_INLINE Float norm() const {
    const Float blinns = (exponent + 2.0f) * (exponent + 4.0f) /
                         (8.0f * kPi * (exponent + pow(Float(2.0f), -0.5f * exponent)));
    return select(blinn, blinns, (exponent + 2.0f) * kInv2Pi);
  }
};

/// cos^n of the angle between unit vectors, from their difference: a cosine near 1 has few digits.
Float cosine_power(Vec3 a, Vec3 b, Float n) {
  return pow(max(fnma(Float(0.5f), length_squared(a - b), Float(1.0f)), 0.0f), n);
}

/// Value (without the cosine) and density of the glossy lobe, above the surface.
struct Gloss {
  Float f, pdf;
};
Gloss gloss_of(const Lobes& lobes, Vec3 wo, Vec3 wi) {
  const Vec3 sum = wo + wi;
  const Vec3 h = sum * (1.0f / sqrt(max(length_squared(sum), 1e-30f)));
  const Vec3 up{Float(0.0f), Float(0.0f), Float(1.0f)};
  const Float power = cosine_power(select(lobes.blinn, h, wi),
                                   select(lobes.blinn, up, Vec3{-wo.x, -wo.y, wo.z}), lobes.exponent);
  // Density of the vector that is drawn; Blinn's is reflected about it.
  const Float density = (lobes.exponent + 1.0f) * kInv2Pi * power;
  return {lobes.norm() * power, select(lobes.blinn, density / max(4.0f * dot(wo, h), 1e-30f), density)};
}

/// Density proportional to cos^n about +z.
Vec3 square_to_cosine_power(Vec2 u, Float n) {
  const Float cosine = pow(u.x, 1.0f / (n + 1.0f));
  const Float sine = safe_sqrt(fnma(cosine, cosine, Float(1.0f)));
  const Float phi = 2.0f * kPi * u.y;
  return {sine * cos(phi), sine * sin(phi), cosine};
}

}  // namespace

BsdfEval PhongBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport, Mask active) const {
  const Lobes lobes(params);
  const Mask lit = active & lobes.lit & same_hemisphere(wo, wi);
  if (none(lit)) return {Spectrum(0.0f), 0.0f};
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  wi = mirror_if(below, wi);
  Gloss gloss = gloss_of(lobes, wo, wi);
  gloss.f = select(lobes.mirror, 0.0f, gloss.f);
  gloss.pdf = select(lobes.mirror, 0.0f, gloss.pdf);
  const Float cosine = wi.z * kInvPi;
  const Spectrum f_cos = lobes.base * cosine + lobes.gloss * (gloss.f * wi.z);
  return {select(lit, f_cos, Spectrum(0.0f)),
          select_or_zero(lit, fma(lobes.base_share, cosine, (1.0f - lobes.base_share) * gloss.pdf))};
}

BsdfSample PhongBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                             Mask active) const {
  const Lobes lobes(params);
  const Mask below = wo.z < 0.0f;
  wo = mirror_if(below, wo);
  const Mask base = u_lobe < lobes.base_share;
  const Mask delta = and_not(lobes.mirror, base);
  const Vec3 mirrored{-wo.x, -wo.y, wo.z};
  const Vec3 drawn = square_to_cosine_power(u, lobes.exponent);
  const Vec3 about_mirror = Frame::from_normal(mirrored).to_world(drawn);
  const Vec3 about_half = drawn * (2.0f * dot(wo, drawn)) - wo;
  Vec3 wi = select(base, square_to_cosine_hemisphere(u), select(lobes.blinn, about_half, about_mirror));
  wi = select(delta, mirrored, wi);

  const BsdfEval both = eval(params, wo, wi, transport, and_not(active, delta));
  const Float mirror_share = 1.0f - lobes.base_share;
  const Float pdf = select(delta, mirror_share, both.pdf);
  const Spectrum f_cos = select(delta, lobes.gloss, both.f_cos);
  const Mask valid = active & lobes.lit & (wo.z > 0.0f) & (wi.z > 0.0f) & (pdf > 0.0f);
  return {.wi = mirror_if(below, wi),
          .weight = f_cos * (1.0f / select(valid, pdf, 1.0f)),
          .pdf = pdf,
          .eta = 1.0f,
          .valid = valid,
          .specular = delta,
          .transmission = Mask::none()};
}

Float PhongBsdf::diffuse_share(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const {
  const Spectrum whole = eval(params, wo, wi, Transport::kRadiance, active).f_cos;
  return share_of(Lobes(params).base * (abs_cos_theta(wi) * kInvPi), whole);
}

Float PhongBsdf::least_alpha(const BsdfParams& params) const {
  // Near its direction a lobe falls like a Gaussian: that of facets, exp(-(angle / alpha)^2), is of the half
  // vector, by twice whose angle the reflected light turns.
  const Lobes lobes(params);
  const Float alpha = sqrt(select(lobes.blinn, Float(2.0f), Float(0.5f)) / max(lobes.exponent, 1e-3f));
  return select(lobes.mirror, Float(0.0f), alpha);
}

Spectrum PhongBsdf::albedo(const BsdfParams& params) const {
  const Lobes lobes(params);
  return lobes.base + lobes.gloss;
}

const ModelOf<PhongBsdf> phong(BsdfKind::kPhong);

}  // namespace tessera::render::TESSERA_ISA
