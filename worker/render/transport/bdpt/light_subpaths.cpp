#include "render/transport/bdpt/light_subpaths.h"

#include <algorithm>

#include "render/integrator/stage_timer.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/light_step.h"
#include "render/transport/vertex/roulette.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// From this event on a subpath ends with a probability of one in ten at least, whatever it carries: in a
/// room that loses nothing, vertices would fill the memory up to the depth limit. 16 of a packet take 12 KB,
/// and of 1,024 subpaths none comes 300 events further once in a billion batches.
constexpr int kLongSubpath = 64;
constexpr float kLongSurvival = 0.9f;

int first_pair(int event) { return dimension::kFirstLightEvent + event * dimension::kPairsPerLightEvent; }

/// Numbers on the way of subpaths from lights, apart from those of the same samples' subpaths from the eye.
TransitNumbers numbers_of(const SampleKeys& keys) { return {keys, dimension::kLightFlight, 0x4c696768u}; }

}  // namespace

void LightSubpaths::trace(const SampleKeys& keys, int count, const LightUses& uses) {
  kept_.clear();
  if (!emits_paths(scene_) || scene_.max_depth == 0) return;
  start(keys, count, uses.shared);
  for (int event = 0; frontier_.size() > 0; ++event) {
    {
      const StageTimer timer(stats_.times, Stage::kIntersection);
      stats_.bounce_rays += static_cast<std::uint64_t>(frontier_.size());
      const PathState& paths = frontier_.paths;
      rays_.nearest(arrays_of(paths.origin, paths.direction, scene_.any_motion ? paths.time : nullptr),
                    frontier_.size(), false, frontier_.hits.arrays());
    }
    if (scene_.volumetric) {
      const StageTimer timer(stats_.times, Stage::kTransit);
      transit_.move(frontier_.paths, frontier_.hits, frontier_.size(), event, numbers_of(keys), nullptr);
    }
    // The vertex at the eye's side of a join is an event, too.
    shade(keys, event, {uses.keep && event + 2 <= scene_.max_depth, uses.film, uses.sink});
    if (uses.film) joins_.trace(*uses.film);
  }
}

void LightSubpaths::start(const SampleKeys& keys, int count, const PassShare& shared) {
  const StageTimer timer(stats_.times, Stage::kCamera);
  frontier_.clear();
  starts_.clear();
  for (int k = 0; k < kPackets && k * kWidth < count; ++k) {
    const Mask active = Mask::first(count - k * kWidth);
    const Int slot = Int::iota(k * kWidth);
    const Sampler numbers = keys.sampler(scene_.sampler.kind, slot, active);
    LightStart start = start_at_light(scene_, numbers, paths_a_pass_, slot, active, shared);
    starts_.add(k, start);
    if (tells_layers(scene_))
      start.path.layer_state = state_at_light(scene_.layers, start.light, start.alive);
    frontier_.replace(scene_, k, start.path, start.alive);
  }
  frontier_.end_step();
  starts_.enter_media(frontier_);
}

void LightSubpaths::shade(const SampleKeys& keys, int event, const LightUses& uses) {
  const StageTimer timer(stats_.times, Stage::kShading);
  for (int k = 0; k < kPackets; ++k) {
    const Mask active = frontier_.lanes(k);
    if (none(active)) continue;
    const Int entry = frontier_.entries(k);
    const Hit found = frontier_.hit(entry, active);
    const Mask hit = active & (found.shape >= 0),
               events = hit | (active & (found.shape == kScatteredByMedium));
    if (none(events)) {
      frontier_.drop(k);
      continue;
    }
    WidePath path = frontier_.path(scene_, entry, active);
    const Sampler numbers = keys.sampler(scene_.sampler.kind, path.slot, active);
    LightVertex& here = uses.keep ? kept_.add(event, k) : unkept_vertex_;
    meet_surface(scene_, path, found, numbers, first_pair(event), hit, here.vertex);
    here.beta = path.beta;
    here.wavelengths = path.wavelengths;
    here.dispersed = path.dispersed;
    here.joinable = joinable(here.vertex, events);
    here.weights = arrive(event, k, path, here.vertex, events);
    if (tells_layers(scene_)) here.layer_state = path.layer_state;
    if (uses.sink) uses.sink->add(here, event);
    if (uses.film) {
      const UInt key =
          scene_.volumetric ? hash(numbers_of(keys).key(path.slot, active) ^ join_salt(event)) : UInt(0);
      join_to_sensor(here, event, numbers, key, uses.film->rect());
    }
    go_on(here, path, numbers, event, k, event + 1 < scene_.max_depth ? events : Mask::none());
  }
  frontier_.end_step();
}

PartialWeights LightSubpaths::arrive(int event, int packet, const WidePath& path, const Vertex& v,
                                     Mask hit) const {
  const Float cosine = cosine_at(v, v.wo);
  if (event > 0) {
    PartialWeights weights = weights_.load(packet);
    const Vec3 before = scene_.volumetric ? path.reference : path.origin;
    weights.arrive(length_squared(v.surface.p - before) * UnitArea(scene_.lights).inverse, cosine);
    return weights;
  }
  return starts_.first_weights(packet, v, hit);
}

void LightSubpaths::join_to_sensor(const LightVertex& here, int event, const Sampler& numbers, UInt key,
                                   const FilmRect& rect) {
  if (!connects_to_points(scene_.sensor) || none(here.joinable) || !filter_.wants(event + 2, 1)) return;
  const Vec2 u_lens = numbers.get_2d(first_pair(event) + dimension::kJoinLens);
  SensorJoin join = sensor_join(scene_, here.vertex, here.beta, here.dispersed, here.wavelengths, u_lens,
                                rect, here.joinable);
  if (none(join.seen)) return;
  if (filter_.all()) {
    const Float density = join.eye.density * UnitArea(scene_.lights).size * cosine_at(here.vertex, join.w) *
                          (1.0f / paths_a_pass_);
    const Float weight =
        weight_of_way(here.weights.ways(density, join.back.pdf, merged_at(here.vertex)), Float(0.0f));
    join.value *= weight;
    if (scene_.layers.unweighted != 0) join.inverse_weight = inverse_of(weight);
  }
  if (tells_layers(scene_)) {
    const Int state = light_state_after(scene_, here.vertex, here.layer_state, join.w, here.vertex.wo,
                                        Mask::none(), light_lobe(numbers, event, true), join.seen);
    join.layers =
        layers_at_eye(scene_.layers, state, join.seen) & Int(layers_of_strategy(scene_.layers, event + 2, 1));
  }
  joins_.add(here.vertex, join, key, here.wavelengths, join.seen);
}

void LightSubpaths::go_on(const LightVertex& here, const WidePath& path, const Sampler& numbers, int event,
                          int packet, Mask hit) {
  if (none(hit)) {
    frontier_.drop(packet);
    return;
  }
  const Vertex& v = here.vertex;
  const int pair = first_pair(event);
  LightStep step = step_from_light(scene_, v, path, numbers.get_2d(pair + dimension::kLobe).x,
                                   numbers.get_2d(pair + dimension::kLightBsdfDirection), hit);
  WidePath& next = step.next;
  if (tells_layers(scene_)) {
    next.layer_state = light_state_after(scene_, v, path.layer_state, next.direction, v.wo, step.specular,
                                         light_lobe(numbers, event, false), step.alive);
  }
  const Float u = numbers.get_2d(pair + dimension::kLightRoulette).x;
  const Mask alive = step.alive & survive_roulette(next.beta, next.roulette_scale, u,
                                                   event < kLongSubpath ? 1.0f : kLongSurvival);
  weights_.store(here.weights.scattered(cosine_at(v, next.direction), step.pdf, step.back_pdf, merged_at(v),
                                        step.specular),
                 packet);
  frontier_.replace(scene_, packet, next, alive);
}

}  // namespace tessera::render::TESSERA_ISA
