#include "render/integrator/photon/photon_mapper.h"

#include <algorithm>

#include "render/core/constants.h"
#include "render/integrator/photon/radius.h"
#include "render/integrator/photon_map/photon_steps.h"
#include "render/integrator/photon_map/radius_of_pass.h"
#include "render/integrator/vertex/focused.h"
#include "render/integrator/vertex/layers.h"
#include "render/integrator/vertex/light_choice.h"
#include "render/integrator/vertex/pass_time.h"
#include "render/integrator/vertex/power_heuristic.h"
#include "render/integrator/vertex/roulette.h"
#include "render/light/area/interpolated_normal.h"
#include "render/sampling/hash.h"

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
      batch_(context) {
  if (caustics_.first_radius == 0) caustics_.first_radius = others_.first_radius;
}

bool PhotonMapper::render(SampleSource& work, Film& film, std::stop_token stop) {
  const std::uint32_t map = scene_.photon.one_map ? 0 : work.pass();
  if (mapped_ != map) {
    if (!trace_photons(map, stop)) return false;
    const StageTimer timer(stats_.times, Stage::kPhotonMap);
    for (Kind* const kind : {&caustics_, &others_}) {
      kind->radius = radius_of_pass(kind->first_radius, map);
      kind->map.build(kind->radius);
    }
    mapped_ = map;
  }
  // One map for all passes is that of a scene that stands still: the camera may move.
  const std::optional<float> time = time_of_pass(scene_, seed_, work.pass());
  while (batch_.start(work, paths_, kBatch, SamplePlaces::kRandom, time)) {
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
  const std::optional<float> time = time_of_pass(scene_, seed_, pass);
  for (std::int32_t first = 0; first < photons_; first += kBatch) {
    if (stop.stop_requested()) return false;
    light_paths_.start(first, std::min<std::int32_t>(kBatch, photons_ - first), pass, time);
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
      .steps = photon_steps(depth, tells_layers(scene_) ? e.path.layer_state : Int(0)),
      .alone = select(e.path.pdf == kMirrored, Int(1), Int(0))};
  const Mask caustic = depth > 0 ? kept & (e.path.pdf != kScattered) : Mask::none();
  caustics_.map.append(photons, caustic);
  others_.map.append(photons, and_not(kept, caustic));
}

Mask PhotonMapper::are_kept(UInt names) const { return (hash(names) & ((1u << halvings_) - 1)) == 0u; }

// ---------------------------------------------------------------- paths from the eye

void PhotonMapper::advance(int depth) {
  find_points(depth);
  {
    const StageTimer timer(stats_.times, Stage::kShading);
    int kept = 0;
    for (int i = 0; i < alive_; i += kWidth) {
      const Mask active = Mask::first(alive_ - i);
      const WidePath path = load(scene_, paths_, i);
      Event e(path, batch_.sampler(path.slot, active), depth);
      Hit found = load_hit(hits_, i);
      e.hit = active & (found.shape >= 0);
      if (scene_.any_motion) found.time = path.time;
      Vertex& v = e.vertex;
      v.wo = -path.direction;
      v.time = found.time;
      v.surface = surface_at(scene_.shapes, found, path.origin, path.direction, e.hit, scene_.any_tangents);
      add_emission(e, active);
      if (none(e.hit) || (depth == scene_.max_depth && depth > 0)) continue;
      interact(scene_, v.surface, v.wo, e.random(dimension::kRoulette).y, e.hit, v.at);
      if (const Mask partly = partly_open(v, e.hit); any(partly))
        open_surface(scene_, e.sampler.get_2d(dimension::kOpacity + depth).x, partly, v);
      if (depth == 0) {
        batch_.record_first_hit(v, found.t, path.slot, e.hit);
        if (scene_.aovs.of_hits()) batch_.record_hit(found, path.slot, e.hit);
      }
      if (depth == scene_.max_depth) continue;
      if (const Mask wanted = joinable(v, e.hit); any(wanted)) {
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

void PhotonMapper::find_points(int depth) {
  const StageTimer timer(stats_.times, Stage::kIntersection);
  if (depth > 0) stats_.bounce_rays += static_cast<std::uint64_t>(alive_);
  find_hits(scene_, rays_, paths_, alive_, depth, PathOrder::kNeighbours, hits_);
}

void PhotonMapper::add_emission(const Event& e, Mask active) {
  const WidePath& path = e.path;
  const Surface& surface = e.vertex.surface;
  Receiver from(path.origin);
  if (scene_.lights.uses_normals) from.normal = path.normal;
  // Light that sampling the lights could have found, too.
  const Mask shared = scene_.photon.direct ? Mask::none() : active & (path.pdf > 0.0f);
  const auto weight = [&](Int light, Vec3 point, Vec3 normal, Mask lanes) {
    const Mask weighed = lanes & shared;
    if (none(weighed)) return Float(1.0f);
    const Float pdf = light_pdf(scene_.lights, light, from, path.direction, point, normal, weighed) *
                      pick_pmf(scene_.lights, light, from, weighed);
    return select(weighed, power_heuristic(path.pdf, pdf), 1.0f);
  };
  if (const Mask lit = e.hit & (surface.light >= 0); any(lit)) {
    Spectrum radiance = emitted_radiance(scene_.lights, surface.light, surface, e.vertex.wo, lit) *
                        weight(surface.light, surface.p, surface.ng, lit);
    if (scene_.lights.any_interpolated) {
      radiance *= interpolated_normal_factor(scene_.lights, surface.light, surface, e.vertex.wo,
                                             length(surface.p - path.origin), path.pdf, lit);
    }
    batch_.add_radiance(radiance * path.beta, path.slot, lit);
    if (tells_layers(scene_)) {
      const Int layers = layers_at_light(scene_.layers, path.layer_state, surface.light, lit);
      batch_.add_to_layers(radiance * path.beta, layers, path.slot, lit);
    }
  }
  const Mask missed = and_not(active, e.hit);
  if (none(missed)) return;
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Spectrum radiance =
        environment_radiance(scene_.lights, light, path.origin, path.direction, missed) *
        weight(Int(light), path.origin, path.direction, missed);
    batch_.add_radiance(radiance * path.beta, path.slot, missed);
    if (tells_layers(scene_)) {
      const Int layers = layers_at_light(scene_.layers, path.layer_state, Int(light), missed);
      batch_.add_to_layers(radiance * path.beta, layers, path.slot, missed);
    }
  }
}

void PhotonMapper::sample_one_light(const Event& e, Mask wanted) {
  if (!samples_lights(scene_.lights)) return;
  const Vertex& v = e.vertex;
  const Receiver here = receiver_at(scene_, v);
  const auto [choice, light] = choose_light(scene_.lights, here, e.random(dimension::kLightPoint),
                                            e.random(dimension::kChoice).x, wanted);
  const Mask reachable = choice.picked & light.valid;
  if (none(reachable)) return;
  const BsdfEval bsdf = eval_bsdf(v.at, v.wo, light.wi, reachable);
  const Float pdf = select(reachable, light.pdf * choice.pmf, Float(1.0f));
  // Paths that are followed find the light, too, if it is not from a single direction.
  const Mask shared = and_not(is_focused(bsdf.pdf), light.delta);
  const Float weight = select(shared, power_heuristic(pdf, bsdf.pdf), Float(1.0f));
  Spectrum contribution = e.path.beta * bsdf.f_cos * light.radiance * (weight / pdf);
  if (scene_.lights.any_interpolated) {
    contribution *=
        interpolated_normal_factor(scene_.lights, choice.light, v.surface.p, light, bsdf.pdf, reachable);
  }
  const Mask shines = and_not(reachable, is_black(contribution));
  WideConnection ray = connect(scene_, v, light.wi, fma(light.wi, light.distance, v.surface.p), shines);
  ray.contribution = contribution;
  ray.slot = e.path.slot;
  if (tells_layers(scene_)) {
    const Int state = state_after(scene_, v, e.path.layer_state, v.wo, light.wi, Mask::none(),
                                  {e.sampler, e.depth, true}, shines);
    ray.layers = layers_at_light(scene_.layers, state, choice.light, shines);
  }
  shadows_.size += append(scene_, ray, shines, shadows_, shadows_.size);
}

void PhotonMapper::gather(const Kind& kind, const Event& e, Mask wanted) {
  if (kind.map.size() == 0) return;
  const InnerStageTimer timer(stats_.times, Stage::kGather, Stage::kShading);
  const int depth_end = scene_.max_depth - e.depth;
  const auto scale = static_cast<float>(1u << halvings_);
  // Light on the other side of a wall is on the same floor. All of it counts if one photon, drawn by its
  // light, is seen on its way: in the mean, what counts is the light of those that are.
  DrawnPhoton drawn{.random =
                        hash(bit_cast<std::uint32_t>(e.random(dimension::kLightPoint).x), UInt(kind.salt))};
  if (!tells_layers(scene_)) {
    const Spectrum radiance =
        radiance_estimate(kind.map, e.vertex, kind.radius, depth_end, wanted, nullptr, drawn);
    const Mask seen = sees(e, drawn, kind.radius, and_not(wanted, is_black(radiance)));
    batch_.add_radiance(radiance * e.path.beta * scale, e.path.slot, seen);
    return;
  }
  GatheredLayers layers{scene_, e.path.layer_state, {e.sampler, e.depth, true}, {}};
  const Spectrum radiance =
      radiance_estimate(kind.map, e.vertex, kind.radius, depth_end, wanted, &layers, drawn);
  const Mask seen = sees(e, drawn, kind.radius, and_not(wanted, is_black(radiance)));
  batch_.add_radiance(radiance * e.path.beta * scale, e.path.slot, seen);
  layers.sums.scale(e.path.beta * scale);
  batch_.add_to_layers(layers.sums, e.path.slot, seen);
}

Mask PhotonMapper::sees(const Event& e, const DrawnPhoton& photon, float radius, Mask wanted) {
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

void PhotonMapper::follow(const Event& e, int& kept) {
  const Vertex& v = e.vertex;
  // Nothing that is scattered evenly is followed.
  const Mask even = e.hit & ((v.at.flags & kLambertian) != 0) & ((v.at.flags & kMixed) == 0);
  const Mask wanted = and_not(e.hit, even);
  if (none(wanted)) return;
  const BsdfSample bsdf =
      sample_bsdf(v.at, v.wo, e.random(dimension::kChoice).y, e.random(dimension::kBsdfDirection), wanted);
  Mask alive = wanted & bsdf.valid;
  if (const Mask spread = and_not(alive, bsdf.specular); any(spread))
    alive = and_not(alive, and_not(spread, is_focused(eval_bsdf(v.at, v.wo, bsdf.wi, spread).pdf)));
  WidePath next;
  next.origin = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  next.beta = e.path.beta * bsdf.weight;
  next.pdf = select(bsdf.specular, Float(0.0f), bsdf.pdf);
  next.roulette_scale =
      select(bsdf.transmission, e.path.roulette_scale * sqr(bsdf.eta), e.path.roulette_scale);
  next.slot = e.path.slot;
  if (scene_.lights.uses_normals) next.normal = receiver_at(scene_, v).normal;
  next.time = v.time;
  alive = and_not(alive, is_black(next.beta));
  if (tells_layers(scene_)) {
    next.layer_state = state_after(scene_, v, e.path.layer_state, v.wo, bsdf.wi, bsdf.specular,
                                   {e.sampler, e.depth, false}, alive);
  }
  if (e.depth > kRouletteStart)
    alive &= survive_roulette(next.beta, next.roulette_scale, e.random(dimension::kRoulette).x);

  // Entries are read 16 at a time before they are overwritten, and never move up.
  kept += append(scene_, next, alive, paths_, kept);
}

void PhotonMapper::trace_shadow_rays() {
  const StageTimer timer(stats_.times, Stage::kShadow);
  const float* const times = scene_.any_motion ? shadows_.time : nullptr;
  rays_.occluded(arrays_of(shadows_.origin, shadows_.direction, times), shadows_.size, shadows_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(shadows_.size);
  batch_.add_contributions(shadows_);
  shadows_.size = 0;
}

}  // namespace tessera::render::TESSERA_ISA
