#include "render/transport/photon/photon_mapper.h"

#include <algorithm>

#include "render/core/constants.h"
#include "render/integrator/algorithm_list.h"
#include "render/sampling/hash.h"
#include "render/transport/photon/radius.h"
#include "render/transport/photon_map/photon_steps.h"
#include "render/transport/photon_map/radius_of_pass.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/focused.h"
#include "render/transport/vertex/layers.h"
#include "render/transport/vertex/light_choice.h"
#include "render/transport/vertex/met_light.h"
#include "render/transport/vertex/pass_share.h"
#include "render/transport/vertex/roulette.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Paths of a pass where nobody says how many: as many as the film has pixels, and no more than this.
constexpr std::int64_t kMostByDefault = 1 << 20;

std::int32_t paths_of_pass(const SceneTables& scene) {
  if (scene.photon.photons > 0) return static_cast<std::int32_t>(scene.photon.photons);
  return static_cast<std::int32_t>(
      std::min(std::int64_t{scene.sensor.width} * scene.sensor.height, kMostByDefault));
}

/// In radii: how far back on its way a photon is looked for at most, which was measured
/// (docs/decisions/0030-photons.md), and at least; and how high above the plane of the surface.
constexpr float kBack = 4, kBefore = 1e-3f, kAbove = 0.1f;

}  // namespace

PhotonMapper::PhotonMapper(const IntegratorContext& context)
    : scene_(context.scene),
      rays_(context.rays),
      stats_(context.stats),
      seed_(context.seed),
      photons_(paths_of_pass(scene_)),
      light_paths_(context, static_cast<float>(photons_)),
      caustics_{scene_.photon.caustic_radius, 1},
      others_{scene_.photon.radius > 0 ? scene_.photon.radius : radius_by_footprint(scene_, rays_), 2},
      batch_(context),
      layers_(make_layer_observer(context, batch_)) {
  if (caustics_.first_pass_radius == 0) caustics_.first_pass_radius = others_.first_pass_radius;
}

bool PhotonMapper::render(SampleSource& work, Film& film, std::stop_token stop) {
  const std::uint32_t map = scene_.photon.one_map ? 0 : work.pass();
  if (mapped_ != map) {
    if (!trace_photons(map, stop)) return false;
    const StageTimer timer(stats_.times, Stage::kPhotonMap);
    for (Kind* const kind : {&caustics_, &others_}) {
      kind->radius = radius_of_pass(kind->first_pass_radius, map);
      kind->map.build(kind->radius);
    }
    mapped_ = map;
  }
  // One map for all passes is that of a scene that stands still: the camera may move.
  const PassShare shared = share_of_pass(scene_, seed_, work.pass());
  while (batch_.start(work, paths_, kBatch, shared)) {
    if (stop.stop_requested()) return false;
    alive_ = batch_.size();
    for (int depth = 0; alive_ > 0; ++depth) advance(depth);
    batch_.finish(film, scene_.max_depth > 0);
  }
  return true;
}

// ---------------------------------------------------------------- photons

bool PhotonMapper::trace_photons(std::uint32_t pass, std::stop_token stop) {
  caustics_.map.clear();
  others_.map.clear();
  photons_named_ = 0;
  halvings_ = 0;
  if (!emits_paths(scene_)) return true;
  const PassShare shared = share_of_pass(scene_, seed_, pass);
  for (std::int32_t first = 0; first < photons_; first += kBatch) {
    if (stop.stop_requested()) return false;
    light_paths_.start(first, std::min<std::int32_t>(kBatch, photons_ - first), pass, shared);
    for (int depth = 0; light_paths_.alive(); ++depth) {
      light_paths_.advance(depth, [&](const LightEvent& e, Mask hit) { keep_photons(e, hit, depth); });
    }
    while (caustics_.map.size() + others_.map.size() > kMostKept) {
      ++halvings_;
      const auto every_second = [&](Int entries) {
        return (hash(bit_cast<std::uint32_t>(entries), UInt(static_cast<std::uint32_t>(halvings_))) & 1u) ==
               0u;
      };
      caustics_.map.filter(every_second);
      others_.map.filter(every_second);
    }
  }
  return true;
}

void PhotonMapper::keep_photons(const LightEvent& e, Mask hit, int depth) {
  if (depth == 0 && !scene_.photon.direct) return;
  const UInt names = UInt::iota(photons_named_);
  photons_named_ += kWidth;
  Mask kept = joinable(e.vertex, hit) & is_finite(e.path.beta);
  if (halvings_ > 0) kept &= are_kept(names);
  const PhotonFields<Wide16> photons{
      .position = e.vertex.surface.p,
      .direction = e.vertex.wo,
      .way = length(e.path.origin - e.vertex.surface.p),
      .flux = e.path.beta,
      .steps = photon_steps(depth, tells_layers(scene_) ? e.path.layer_state : Int(0),
                            disperses(scene_) ? e.path.dispersed : Int(0)),
      .alone = select(e.path.pdf == kMirrored, Int(1), Int(0))};
  const Mask caustic = depth > 0 ? kept & (e.path.pdf != kScattered) : Mask::none();
  caustics_.map.append(photons, caustic);
  others_.map.append(photons, and_not(kept, caustic));
}

Mask PhotonMapper::are_kept(UInt names) const { return (hash(names) & ((1u << halvings_) - 1)) == 0u; }

// ---------------------------------------------------------------- paths from the eye

void PhotonMapper::advance(int depth) {
  batch_.find_hits(paths_, alive_, depth, hits_);
  {
    const StageTimer timer(stats_.times, Stage::kShading);
    int kept = 0;
    for (int i = 0; i < alive_; i += kWidth) {
      const Mask active = Mask::first(alive_ - i);
      Encounter e(scene_, batch_, paths_, hits_, depth, i, active);
      e.find_surface(scene_, e.on_surface);
      add_emission(e);
      if (none(e.met) || (depth == scene_.max_depth && depth > 0)) continue;
      e.find_scattering(scene_);
      disperse_at(scene_, e.vertex, e.met, e.path);
      const Vertex& v = e.vertex;
      if (depth == 0) batch_.record_first_hit(v, e.hit, e.path.slot, e.met);
      if (depth == scene_.max_depth) continue;
      if (const Mask wanted = joinable(v, e.on_surface); any(wanted)) {
        if (!scene_.photon.direct) sample_one_light(e, wanted);
        gather(caustics_, e, wanted);
        gather(others_, e, wanted);
      }
      follow(e, kept);
    }
    alive_ = kept;
  }
  trace_shadow_rays();
}

void PhotonMapper::add_emission(const Encounter& e) {
  // Light that sampling the lights could have found, too.
  const Mask shared = scene_.photon.direct ? Mask::none() : e.path.pdf > 0.0f;
  const auto add = [&](MetLight& light) {
    if (layers_) layers_->emitted(e, light);
    batch_.add_radiance(light.arriving * e.path.beta, e.path.slot, light.lanes);
  };
  if (const Mask lit = e.on_surface & (e.vertex.surface.light >= 0); any(lit)) {
    MetLight light = lamps_met(scene_, e, lit, lit & shared);
    interpolate_normals(scene_, e, light);
    add(light);
  }
  if (none(e.missed)) return;
  for (const std::int32_t number : scene_.lights.infinite_lights) {
    MetLight light = sky_met(scene_, e, number, e.missed & shared);
    add(light);
  }
}

void PhotonMapper::sample_one_light(const Encounter& e, Mask wanted) {
  if (!samples_lights(scene_.lights)) return;
  const Vertex& v = e.vertex;
  const auto [choice, sample] =
      choose_light(scene_.lights, receiver_at(scene_, v), e.random(dimension::kLightPoint),
                   e.random(dimension::kChoice).x, wanted);
  const Mask reachable = choice.picked & sample.valid;
  if (none(reachable)) return;
  const BsdfEval bsdf = eval_bsdf(v.at, v.wo, sample.wi, reachable);
  const Float pdf = sample.pdf * choice.pmf;
  // Paths that are followed find the light, too, if it is not from a single direction.
  const Mask shared = and_not(is_focused(bsdf.pdf), sample.delta);
  const Float weight = select(shared, power_heuristic(pdf, bsdf.pdf), Float(1.0f));
  SampledLight light =
      light_sampled(scene_, batch_, e, choice.light, sample, pdf, weight, bsdf.f_cos, reachable);
  interpolate_normals(scene_, e, bsdf.pdf, light);
  if (layers_) layers_->lit(e, light);
  const Mask shines = and_not(reachable, is_black(light.ray.contribution));
  shadows_.size += append(scene_, light.ray, shines, shadows_, shadows_.size);
}

void PhotonMapper::gather(const Kind& kind, const Encounter& e, Mask wanted) {
  if (kind.map.size() == 0) return;
  const InnerStageTimer timer(stats_.times, Stage::kGather, Stage::kShading);
  const int depth_end = scene_.max_depth - e.depth;
  const auto scale = static_cast<float>(1u << halvings_);
  // Light on the other side of a wall is on the same floor. All of it counts if one photon, drawn by its
  // light, is seen on its way: in the mean, what counts is the light of those that are.
  DrawnPhoton drawn{.random =
                        hash(bit_cast<std::uint32_t>(e.random(dimension::kLightPoint).x), UInt(kind.salt))};
  const Int* const dispersed = disperses(scene_) ? &e.path.dispersed : nullptr;
  if (!tells_layers(scene_)) {
    const Spectrum radiance =
        radiance_estimate(kind.map, e.vertex, kind.radius, depth_end, dispersed, wanted, nullptr, drawn);
    const Mask seen = sees(e, drawn, kind.radius, and_not(wanted, is_black(radiance)));
    batch_.add_radiance(radiance * e.path.beta * scale, e.path.slot, seen);
    return;
  }
  GatheredLayers layers{scene_, e.path.layer_state, {e.numbers, e.depth, true}, {}};
  const Spectrum radiance =
      radiance_estimate(kind.map, e.vertex, kind.radius, depth_end, dispersed, wanted, &layers, drawn);
  const Mask seen = sees(e, drawn, kind.radius, and_not(wanted, is_black(radiance)));
  batch_.add_radiance(radiance * e.path.beta * scale, e.path.slot, seen);
  layers.sums.scale(e.path.beta * scale);
  batch_.add_to_layers(layers.sums, e.path.slot, seen);
}

Mask PhotonMapper::sees(const Encounter& e, const DrawnPhoton& photon, float radius, Mask wanted) {
  if (none(wanted)) return wanted;
  // Above the plane of the surface, since bulges are no walls, and before what caught the photon.
  const Float back =
      min(to_unit_float(hash(photon.random, UInt(3u))) * (kBack * radius), 0.999f * photon.way);
  const Vec3 up = face_forward(e.vertex.surface.ng, photon.direction);
  const Vec3 from = e.vertex.surface.p;
  const Float height = max(-dot(photon.position - from, up), 0.0f) + kAbove * radius;
  const Vec3 target =
      fma(up, height, fma(photon.direction, max(back, Float(kBefore * radius)), photon.position));
  WideConnection ray = connect(scene_, e.vertex, target - from, target, wanted);
  ray.slot = e.path.slot;
  const int rays = append(scene_, ray, wanted, ways_, 0);
  const float* const times = scene_.any_motion ? ways_.time : nullptr;
  rays_.occluded(arrays_of(ways_.origin, ways_.direction, times), rays, ways_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(rays);
  std::uint32_t seen = wanted.bits();
  int i = 0;
  for (std::uint32_t left = wanted.bits(); left != 0; left &= left - 1, ++i) {
    if (ways_.distance[i] < 0) seen &= ~(left & (~left + 1));
  }
  return Mask::from_bits(seen);
}

void PhotonMapper::follow(const Encounter& e, int& kept) {
  const Vertex& v = e.vertex;
  // Nothing that is scattered evenly is followed.
  const Mask even = e.on_surface & ((v.at.traits & kLambertian) != 0) & ((v.at.flags & kMixed) == 0);
  const Mask wanted = and_not(e.on_surface, even);
  if (none(wanted)) return;
  const BsdfSample bsdf =
      sample_bsdf(v.at, v.wo, e.random(dimension::kChoice).y, e.random(dimension::kBsdfDirection), wanted);
  Scattering s(wanted);
  s.bsdf = bsdf;
  s.alive = wanted & bsdf.valid;
  if (const Mask spread = and_not(s.alive, bsdf.specular); any(spread))
    s.alive = and_not(s.alive, and_not(spread, is_focused(eval_bsdf(v.at, v.wo, bsdf.wi, spread).pdf)));
  WidePath& next = s.next;
  next.origin = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  next.beta = e.path.beta * bsdf.weight;
  next.wavelengths = e.path.wavelengths;
  next.dispersed = e.path.dispersed;
  disperse_along(scene_, v, bsdf, next);
  next.pdf = select(bsdf.specular, Float(0.0f), bsdf.pdf);
  next.roulette_scale =
      select(bsdf.transmission, e.path.roulette_scale * sqr(bsdf.eta), e.path.roulette_scale);
  next.slot = e.path.slot;
  if (scene_.lights.uses_normals) next.normal = receiver_at(scene_, v).normal;
  next.time = v.time;
  s.alive = and_not(s.alive, is_black(next.beta));
  if (layers_) layers_->scattered(e, s);
  if (e.depth > kRouletteStart)
    s.alive &= survive_roulette(next.beta, next.roulette_scale, e.roulette_number(scene_));

  // Entries are read 16 at a time before they are overwritten, and never move up.
  kept += append(scene_, next, s.alive, paths_, kept);
}

void PhotonMapper::trace_shadow_rays() {
  const StageTimer timer(stats_.times, Stage::kShadow);
  batch_.trace(shadows_);
}

const ListedAlgorithm photon{{"photon", &make<PhotonMapper>}};

}  // namespace tessera::render::TESSERA_ISA
