// A fibre of hair: a rough cylinder of dielectric with tilted scales, seen from afar [Chiang et al. 2016;
// d'Eon et al. 2011; Marschner et al. 2003], with the parameters of pbrt-v4's "hair". Directions are those of
// the shading frame with x along the fibre; light that goes through it comes out on the other side of the
// same surface.
//
// spectra[0]     sigma_a: absorption per radius
// scalars[0, 1]  beta_m, beta_n: longitudinal and azimuthal roughness in [0, 1]
// scalars[2]     eta: index of the fibre over the index outside
// extended[0]    alpha: tilt of the scales, radians
// extended[1]    h: where across the fibre it is hit, -1 to 1 (from prepare())
#include "render/bsdf/bsdf.h"

#include "render/bsdf/fresnel.h"
#include "render/core/constants.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class HairBsdf final : public Bsdf {
 public:
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport transport, Mask active) const override;
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                    Mask active) const override;
  void prepare(const TexturePoint& at, Mask lanes, BsdfParams& params) const override;
};

/// Ways of light: reflected; through; through after one internal reflection; all further ones together.
constexpr int kLobes = 4, kLast = kLobes - 1;

/// A polynomial, highest power first.
template <class... C>
TESSERA_INLINE Float polynomial(Float x, float first, C... rest) {
  Float result(first);
  ((result = fma(result, x, Float(rest))), ...);
  return result;
}

TESSERA_INLINE Float sqr_chain(Float x, int doublings) {
  for (int i = 0; i < doublings; ++i) x = sqr(x);
  return x;
}

/// exp(-x) I0(x) for x >= 0; to 2e-7 [Abramowitz & Stegun 1964, 9.8.1 and 9.8.2].
Float scaled_bessel_i0(Float x) {
  constexpr float kBorder = 3.75f;
  const Float t = x * (1 / kBorder), small = min(t, 1.0f), large = 1.0f / max(t, 1.0f);
  const Float near = exp(-min(x, kBorder)) * polynomial(sqr(small), 0.0045813f, 0.0360768f, 0.2659732f,
                                                        1.2067492f, 3.0899424f, 3.5156229f, 1.0f);
  const Float far = polynomial(large, 0.00392377f, -0.01647633f, 0.02635537f, -0.02057706f, 0.00916281f,
                               -0.00157565f, 0.00225319f, 0.01328592f, 0.39894228f) /
                    sqrt(max(x, kBorder));
  return select(x < kBorder, near, far);
}

/// Sine and cosine of an inclination to the plane across the fibre.
struct Inclination {
  Float sine, cosine;
};
TESSERA_INLINE Inclination inclination_of(Vec3 w) { return {w.x, safe_sqrt(1.0f - sqr(w.x))}; }

/// M: of light inclined by `o`, density over sin(theta_i) of what leaves inclined by `i`, with variance v
/// [d'Eon et al. 2011]. exp((cos cos - sin sin - 1) / v) does not overflow for any v.
Float longitudinal(Inclination i, Inclination o, Float v) {
  const Float inverse = 1.0f / v;
  const Float a = i.cosine * o.cosine * inverse;
  const Float exponent = (i.cosine * o.cosine - i.sine * o.sine - 1.0f) * inverse;
  return scaled_bessel_i0(a) * exp(min(exponent, 0.0f)) * inverse / (1.0f - exp(-2.0f * inverse));
}

/// N of a lobe around the azimuth `centre`: a logistic distribution cut off at +-pi.
Float azimuthal(Float phi, Float centre, Float s) {
  Float d = phi - centre;
  d = d - 2.0f * kPi * floor((d + kPi) * kInv2Pi);
  const Float e = exp(-abs(d) / s), end = exp(-kPi / s);
  return e * (1.0f + end) / (s * sqr(1.0f + e) * (1.0f - end));
}

/// A deviation from the centre of the same distribution.
Float sample_azimuth(Float u, Float s) {
  const Float low = 1.0f / (1.0f + exp(kPi / s)), high = 1.0f / (1.0f + exp(-kPi / s));
  const Float cdf = clamp(lerp(u, low, high), 1e-7f, 1.0f - 1e-7f);
  return clamp(-s * log(1.0f / cdf - 1.0f), -kPi, kPi);
}

/// All that depends on the fibre and wo.
struct Fibre {
  Inclination o;
  Float phi_o;
  Float variance[kLobes], s;
  Float gamma_o, gamma_t;        // angles to the normal of the cylinder, outside and inside
  Inclination tilted[kLobes];    // o as the scales turn it
  Spectrum attenuation[kLobes];  // A
  Float probability[kLobes];     // by the mean of A

  Fibre(const BsdfParams& params, Vec3 wo) : o(inclination_of(wo)), phi_o(atan2(wo.z, wo.y)) {
    set_roughness(clamp(params.scalars[slot::kBetaM], 0.01f, 1.0f),
                  clamp(params.scalars[slot::kBetaN], 0.01f, 1.0f));
    set_tilt(params.extended[slot::kTilt]);
    set_attenuation(params);
  }

  /// Where the light of a lobe leaves, relative to phi_o. The last lobe leaves everywhere alike.
  TESSERA_INLINE Float centre(int lobe) const {
    return 2.0f * static_cast<float>(lobe) * gamma_t - 2.0f * gamma_o + static_cast<float>(lobe) * kPi;
  }

  /// f cos and pdf for light that leaves inclined by `i` at azimuth phi_o + phi.
  BsdfEval eval(Inclination i, Float phi) const {
    BsdfEval result{Spectrum(0.0f), 0.0f};
    for (int p = 0; p < kLobes; ++p) {
      const Float n = p < kLast ? azimuthal(phi, centre(p), s) : Float(kInv2Pi);
      const Float density = longitudinal(i, tilted[p], variance[p]) * n;
      result.f_cos += attenuation[p] * density;
      result.pdf += probability[p] * density;
    }
    return result;
  }

 private:
  /// Fits of the physical widths to perceived roughness [Chiang et al. 2016, eqs. 7 and 8].
  void set_roughness(Float beta_m, Float beta_n) {
    const Float m4 = sqr_chain(beta_m, 2), m20 = sqr_chain(m4, 2) * m4;
    variance[0] = sqr(0.726f * beta_m + 0.812f * sqr(beta_m) + 3.7f * m20);
    variance[1] = 0.25f * variance[0];
    variance[2] = variance[3] = 4.0f * variance[0];
    const Float n2 = sqr(beta_n), n4 = sqr(n2), n22 = sqr_chain(n4, 2) * n4 * n2;
    s = 0.626657069f * (0.265f * beta_n + 1.194f * n2 + 5.372f * n22);
  }

  /// Each lobe is turned by a multiple of the scales' tilt: 2, -1 and -4 times.
  void set_tilt(Float tilt) {
    constexpr float kTurns[kLobes] = {2, -1, -4, 0};
    for (int p = 0; p < kLobes; ++p) {
      const Float sine = sin(tilt * kTurns[p]), cosine = cos(tilt * kTurns[p]);
      tilted[p] = {o.sine * cosine - o.cosine * sine, abs(o.cosine * cosine + o.sine * sine)};
    }
  }

  void set_attenuation(const BsdfParams& params) {
    const Float h = params.extended[slot::kFibreOffset], eta = params.scalars[slot::kEta];
    gamma_o = asin(h);
    // Refraction in the plane across the fibre is that of a larger index [Marschner et al. 2003].
    const Float across = safe_sqrt(sqr(eta) - sqr(o.sine)) / max(o.cosine, 1e-6f);
    const Float sin_t = clamp(h / max(across, 1e-6f), -1.0f, 1.0f);
    gamma_t = asin(sin_t);
    const Float cos_theta_t = safe_sqrt(1.0f - sqr(o.sine / eta));
    const Float length = 2.0f * safe_sqrt(1.0f - sqr(sin_t)) / max(cos_theta_t, 1e-6f);
    const Float f = fresnel_dielectric(o.cosine * safe_sqrt(1.0f - sqr(h)), eta).reflectance;
    Float total(0.0f);
    for (int c = 0; c < kSpectrumLanes; ++c) {
      const Float t = exp(-max(params.spectra[slot::kAbsorption].c[c], 0.0f) * length);
      attenuation[0].c[c] = f;
      attenuation[1].c[c] = sqr(1.0f - f) * t;
      attenuation[2].c[c] = attenuation[1].c[c] * t * f;
      attenuation[3].c[c] = attenuation[2].c[c] * t * f / max(1.0f - t * f, 1e-6f);
    }
    for (int p = 0; p < kLobes; ++p) total += probability[p] = attenuation[p].mean();
    const Float inverse = 1.0f / max(total, 1e-30f);
    for (Float& p : probability) p = p * inverse;
  }
};

}  // namespace

BsdfEval HairBsdf::eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport, Mask active) const {
  const Fibre fibre(params, wo);
  const BsdfEval result = fibre.eval(inclination_of(wi), atan2(wi.z, wi.y) - fibre.phi_o);
  return {select_or_zero(active, result.f_cos), select_or_zero(active, result.pdf)};
}

BsdfSample HairBsdf::sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Transport,
                            Mask active) const {
  const Fibre fibre(params, wo);
  // The lobe, and what is left of u_lobe.
  Float below(0.0f), share = fibre.probability[kLast], variance = fibre.variance[kLast], centre(0.0f);
  Inclination tilted = fibre.tilted[kLast];
  Mask chosen = Mask::none();
  Float sum(0.0f);
  for (int p = 0; p < kLast; ++p) {
    const Mask here = and_not(u_lobe < sum + fibre.probability[p], chosen);
    below = select(here, sum, below);
    share = select(here, fibre.probability[p], share);
    variance = select(here, fibre.variance[p], variance);
    centre = select(here, fibre.centre(p), centre);
    tilted = {select(here, fibre.tilted[p].sine, tilted.sine),
              select(here, fibre.tilted[p].cosine, tilted.cosine)};
    chosen |= here;
    sum += fibre.probability[p];
  }
  below = select(chosen, below, sum);
  const Float u_phi = clamp((u_lobe - below) / max(share, 1e-30f), 0.0f, kOneMinusEpsilon);

  // M [d'Eon 2013], then N.
  const Float c =
      clamp(1.0f + variance * log(max(u.x + (1.0f - u.x) * exp(-2.0f / variance), 1e-30f)), -1.0f, 1.0f);
  const Float sine =
      clamp(safe_sqrt(1.0f - sqr(c)) * cos(2.0f * kPi * u.y) * tilted.cosine - c * tilted.sine, -1.0f, 1.0f);
  const Inclination i{sine, safe_sqrt(1.0f - sqr(sine))};
  const Float phi = select(chosen, centre + sample_azimuth(u_phi, fibre.s), 2.0f * kPi * u_phi);
  const Float azimuth = fibre.phi_o + phi;

  const BsdfEval eval = fibre.eval(i, phi);
  const Mask valid = active & (eval.pdf > 0.0f);
  return {.wi = {i.sine, i.cosine * cos(azimuth), i.cosine * sin(azimuth)},
          .weight = eval.f_cos * (1.0f / select(valid, eval.pdf, 1.0f)),
          .pdf = eval.pdf,
          .eta = 1.0f,
          .valid = valid,
          .specular = Mask::none(),
          .transmission = Mask::none()};
}

/// Fills in the offset across the fibre and, with kHairReflectance, the absorption that gives much hair the
/// colour that stands in its place [Chiang et al. 2016].
void HairBsdf::prepare(const TexturePoint& at, Mask lanes, BsdfParams& params) const {
  const Float v = at.uv.y;
  params.extended[slot::kFibreOffset] =
      select(lanes, clamp(2.0f * v - 1.0f, -1.0f, 1.0f), params.extended[slot::kFibreOffset]);
  const Mask coloured = lanes & params.of_variant(kHairReflectance);
  if (none(coloured)) return;
  const Float b = params.scalars[slot::kBetaN];
  const Float scale = polynomial(b, 0.245f, 5.574f, -10.73f, 2.532f, -0.215f, 5.969f);
  for (int c = 0; c < kSpectrumLanes; ++c) {
    const Float absorption = sqr(log(clamp(params.spectra[slot::kAbsorption].c[c], 1e-4f, 1.0f)) / scale);
    params.spectra[slot::kAbsorption].c[c] =
        select(coloured, absorption, params.spectra[slot::kAbsorption].c[c]);
  }
}

const ModelOf<HairBsdf> hair(BsdfKind::kHair);

}  // namespace tessera::render::TESSERA_ISA
