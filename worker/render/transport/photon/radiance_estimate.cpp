#include "render/transport/photon/radiance_estimate.h"

#include <bit>

#include "render/core/constants.h"
#include "render/integrator/fireflies.h"
#include "render/sampling/hash.h"
#include "render/transport/photon_map/photon_steps.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/focused.h"

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

/// Draws one photon a lane of all that it is offered, each in proportion to its weight [Chao 1982].
class Draw {
 public:
  explicit Draw(UInt random) : random_(random) {}

  void offer(const PhotonFields<Wide16>& photons, Float weight, Mask offered) {
    const Float own = select(offered, weight, Float(0.0f));
    total_ += own;
    random_ = hash(random_);
    const Mask taken = offered & (to_unit_float(random_) * total_ < own);
    position_ = select(taken, photons.position, position_);
    direction_ = select(taken, photons.direction, direction_);
    way_ = select(taken, photons.way, way_);
  }
  /// Each lane's own.
  void store(DrawnPhoton& drawn, Mask lanes) const {
    drawn.position = select(lanes, position_, drawn.position);
    drawn.direction = select(lanes, direction_, drawn.direction);
    drawn.way = select(lanes, way_, drawn.way);
  }
  /// One of all lanes', for `lane` of the result.
  void store_one(DrawnPhoton& drawn, int lane) const {
    alignas(64) float totals[kWidth], chance[kWidth], ways[kWidth];
    way_.store(ways);
    total_.store(totals);
    to_unit_float(hash(random_ ^ 0x9e3779b9u)).store(chance);
    const float end = chance[0] * sum_of(total_);
    int last = 0;
    float sum = 0;
    for (int i = 0; i < kWidth; ++i) {
      if (!(totals[i] > 0)) continue;
      last = i;
      if ((sum += totals[i]) > end) break;
    }
    const Mask one = Mask::from_bits(1u << lane);
    const PointLanes position(position_), direction(direction_);
    drawn.position = select(one, position.lane(last), drawn.position);
    drawn.direction = select(one, direction.lane(last), drawn.direction);
    drawn.way = select(one, Float(ways[last]), drawn.way);
  }

 private:
  UInt random_;
  Float total_ = Float(0.0f);
  Vec3 position_ = {}, direction_ = {};
  Float way_ = Float(0.0f);
};

/// Sums of the flux near points whose BSDF is a constant, by one point after the other; also by layers,
/// unless these are null.
Spectrum flux_near(const RadianceMap& map, const Vertex& v, Float thickness, int depth_end,
                   const Int* dispersed, Mask active, GatheredLayers* layers, DrawnPhoton& drawn) {
  const PointLanes p(v.surface.p), ng(v.surface.ng), ns(face_forward(v.at.frame.z, v.wo));
  alignas(64) float sums[kSpectrumLanes][kWidth] = {};
  alignas(64) std::int32_t states[kWidth];
  alignas(64) std::int32_t random[kWidth];
  alignas(64) std::int32_t dispersed_lanes[kWidth] = {};
  if (dispersed != nullptr) dispersed->store(dispersed_lanes);
  bit_cast<std::int32_t>(drawn.random).store(random);
  if (layers != nullptr) layers->state_after_diffuse_reflection(v, active).store(states);
  for (std::uint32_t left = active.bits(); left != 0; left &= left - 1) {
    const int lane = std::countr_zero(left);
    const Vec3 place = p.lane(lane), geometric = ng.lane(lane), shading = ns.lane(lane);
    const Float thick(thickness);
    Spectrum sum(0.0f);
    LayerSums layer_sums;
    Draw draw(hash(UInt::iota(static_cast<std::uint32_t>(random[lane]))));
    map.for_each_near(p.x[lane], p.y[lane], p.z[lane], [&](std::int32_t first, Mask near, Float) {
      const PhotonFields<Wide16> photons = map.load(first);
      const Float cosine = dot(photons.direction, shading);
      const Mask counts = near & (cosine > 0.0f) & has_fewer_events(photons.steps, depth_end) &
                          (abs(dot(photons.position - place, geometric)) <= thick);
      Spectrum flux = photons.flux * (cosine * inverse_cosine(photons.direction, geometric));
      if (dispersed != nullptr)
        flux *= joined_factor(Int(dispersed_lanes[lane]), dispersed_of(photons.steps));
      sum += select_or_zero(counts, flux);
      draw.offer(photons, flux.mean(), counts);
      if (layers == nullptr) return;
      const Int found =
          layers_of_join(layers->scene.layers, Int(states[lane]), layer_state_of(photons.steps), counts);
      layer_sums.add(flux, found, counts);
    });
    for (int c = 0; c < kSpectrumLanes; ++c) sums[c][lane] = sum_of(sum.c[c]);
    draw.store_one(drawn, lane);
    if (layers == nullptr) continue;
    layer_sums.for_each([&](int layer, const Spectrum& light) {
      Spectrum total;
      for (int c = 0; c < kSpectrumLanes; ++c) total.c[c] = Float(sum_of(light.c[c]));
      layers->sums.add_to(layer, total, Mask::from_bits(1u << lane));
    });
  }
  Spectrum flux;
  for (int c = 0; c < kSpectrumLanes; ++c) flux.c[c] = Float::load(sums[c]);
  return flux;
}

}  // namespace

Spectrum radiance_estimate(const RadianceMap& map, const Vertex& v, float radius, int depth_end,
                           const Int* dispersed, Mask active, GatheredLayers* layers, DrawnPhoton& drawn) {
  const float thickness = kThickness * radius, area = kPi * radius * radius;
  const Mask even =
      active & ((v.at.traits & kLambertian) != 0) & ((v.at.flags & (kMixed | kBendsSoftly)) == 0);
  Spectrum radiance(0.0f);
  if (any(even)) {
    // Towards the normal the cosine is 1.
    const Spectrum f = eval_bsdf(v.at, v.wo, face_forward(v.at.frame.z, v.wo), even).f_cos;
    radiance =
        select_or_zero(even, f * flux_near(map, v, thickness, depth_end, dispersed, even, layers, drawn));
    if (layers != nullptr) layers->sums.scale(f);
  }
  if (const Mask others = and_not(active, even); any(others)) {
    Draw draw(drawn.random);
    map.for_each_near(v.surface.p, others, [&](const PhotonFields<Wide16>& photons, Mask near) {
      const Mask close = near & has_fewer_events(photons.steps, depth_end) &
                         (abs(dot(photons.position - v.surface.p, v.surface.ng)) <= thickness);
      if (none(close)) return;
      const BsdfEval bsdf = eval_bsdf(v.at, v.wo, photons.direction, close);
      const Mask left_to_others = is_focused(bsdf.pdf) & (photons.alone == 0);
      const Mask counts = and_not(close, left_to_others);
      Spectrum light = photons.flux * bsdf.f_cos * inverse_cosine(photons.direction, v.surface.ng);
      if (dispersed != nullptr) light *= joined_factor(*dispersed, dispersed_of(photons.steps));
      radiance += select_or_zero(counts, light);
      draw.offer(photons, light.mean(), counts);
      if (layers != nullptr) layers->add(v, light, photons.direction, layer_state_of(photons.steps), counts);
    });
    draw.store(drawn, others);
  }
  if (layers != nullptr) layers->sums.scale(Spectrum(1.0f / area));
  return radiance * (1.0f / area);
}

}  // namespace tessera::render::TESSERA_ISA
