#include "render/integrator/photon/radiance_estimate.h"

#include <bit>

#include "render/core/constants.h"
#include "render/integrator/fireflies.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Photons further than this from the plane of the surface, in radii, lie on another. As the radius shrinks,
/// curved surfaces lie within.
constexpr float kThickness = 0.5f;

/// Light that meets a surface is counted by area, the integral over directions has the shading normal's
/// cosine [Veach 1997, section 5.3].
Float inverse_cosine(Vec3 direction, Vec3 ng) { return 1.0f / max(abs(dot(direction, ng)), 1e-6f); }

/// Sixteen values of one number each: a surface point's coordinates.
struct PointLanes {
  alignas(64) float x[kWidth], y[kWidth], z[kWidth];

  explicit PointLanes(Vec3 v) { v.x.store(x), v.y.store(y), v.z.store(z); }
  Vec3 lane(int i) const { return {Float(x[i]), Float(y[i]), Float(z[i])}; }
};

/// Sums of the flux near points whose BSDF is a constant, by one point after the other.
Spectrum flux_near(const RadianceMap& map, const Vertex& v, Float thickness, int depth_end, Mask active) {
  const PointLanes p(v.surface.p), ng(v.surface.ng), ns(face_forward(v.at.frame.z, v.wo));
  alignas(64) float sums[kSpectrumLanes][kWidth] = {};
  for (std::uint32_t left = active.bits(); left != 0; left &= left - 1) {
    const int lane = std::countr_zero(left);
    const Vec3 place = p.lane(lane), geometric = ng.lane(lane), shading = ns.lane(lane);
    const Float thick(thickness);
    Spectrum sum(0.0f);
    map.for_each_near(p.x[lane], p.y[lane], p.z[lane], [&](std::int32_t first, Mask near, Float) {
      const PhotonFields<Wide16> photons = map.load(first);
      const Float cosine = dot(photons.direction, shading);
      const Mask counts = near & (cosine > 0.0f) & (photons.depth < depth_end) &
                          (abs(dot(photons.position - place, geometric)) <= thick);
      sum += select_or_zero(counts, photons.flux * (cosine * inverse_cosine(photons.direction, geometric)));
    });
    for (int c = 0; c < kSpectrumLanes; ++c) sums[c][lane] = sum_of(sum.c[c]);
  }
  Spectrum flux;
  for (int c = 0; c < kSpectrumLanes; ++c) flux.c[c] = Float::load(sums[c]);
  return flux;
}

}  // namespace

Spectrum radiance_estimate(const RadianceMap& map, const Vertex& v, float radius, int depth_end,
                           Mask active) {
  const float thickness = kThickness * radius, area = kPi * radius * radius;
  const Mask even =
      active & ((v.at.flags & kLambertian) != 0) & ((v.at.flags & (kMixed | kBendsSoftly)) == 0);
  Spectrum radiance(0.0f);
  if (any(even)) {
    // Towards the normal the cosine is 1.
    const Spectrum f = eval_bsdf(v.at, v.wo, face_forward(v.at.frame.z, v.wo), even).f_cos;
    radiance = select_or_zero(even, f * flux_near(map, v, thickness, depth_end, even));
  }
  if (const Mask others = and_not(active, even); any(others)) {
    map.for_each_near(v.surface.p, others, [&](const PhotonFields<Wide16>& photons, Mask near) {
      const Mask close = near & (photons.depth < depth_end) &
                         (abs(dot(photons.position - v.surface.p, v.surface.ng)) <= thickness);
      if (none(close)) return;
      const BsdfEval bsdf = eval_bsdf(v.at, v.wo, photons.direction, close);
      radiance += select_or_zero(and_not(close, is_focused(bsdf)),
                                 photons.flux * bsdf.f_cos * inverse_cosine(photons.direction, v.surface.ng));
    });
  }
  return radiance * (1.0f / area);
}

}  // namespace tessera::render::TESSERA_ISA
