#include "render/integrator/bdpt/light_subpaths.h"

#include <algorithm>

#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/integrator/vertex/light_end.h"
#include "render/integrator/vertex/medium_at.h"
#include "render/integrator/vertex/roulette.h"

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

/// Lanes whose density of samples is only an estimate.
Mask estimates_density(const Interaction& at, Mask active) {
  const Mask second = active & ((at.flags & kMixed) != 0);
  Mask result = active & ((at.flags & kEstimatedDensity) != 0);
  if (any(second)) result |= second & ((at.second.flags & kEstimatedDensity) != 0);
  return result;
}

}  // namespace

void LightSubpaths::trace(const SampleKeys& keys, int count, const LightUses& uses) {
  used_ = 0;
  kept_.clear();
  if (!emits_paths(scene_) || scene_.max_depth == 0) return;
  start(keys, count);
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

void LightSubpaths::start(const SampleKeys& keys, int count) {
  const StageTimer timer(stats_.times, Stage::kCamera);
  frontier_.clear();
  ways_.size = 0;
  for (int k = 0; k < kPackets && k * kWidth < count; ++k) {
    const Mask active = Mask::first(count - k * kWidth);
    const Int slot = Int::iota(k * kWidth);
    const Sampler numbers = keys.sampler(scene_.sampler.kind, slot, active);
    LightStart start = start_at_light(scene_, numbers, paths_a_pass_, slot, active);
    start.light.store(light_ + k * kWidth);
    store_lanes(start.ray.origin, point_, k * kWidth);
    store_lanes(start.ray.normal, normal_, k * kWidth);
    if (scene_.volumetric) {
      start.path.reference = start.ray.origin;
      start.path.medium = Int(-1);
      ways_.size += append(scene_, way_from_camera(scene_, start.path.origin, start.path.time, slot),
                           start.alive, ways_, ways_.size);
    }
    frontier_.replace(scene_, k, start.path, start.alive);
  }
  frontier_.end_step();
  if (!scene_.media.media.empty()) enter_media();
}

void LightSubpaths::enter_media() {
  find_media(context_, ways_, frontier_.hits, media_);
  PathState& paths = frontier_.paths;
  for (int k = 0; k < kPackets; ++k) {
    const Mask active = frontier_.lanes(k);
    if (none(active)) continue;
    const Int entry = frontier_.entries(k), light = Int::load(light_ + k * kWidth);
    const Vec3 direction = gather_lanes<Vec3>(paths.direction, entry, active);
    Vec3 point;
    load_lanes(point_, k * kWidth, point);
    const Int medium = Int::load(media_ + k * kWidth);
    scatter(medium_at_light(scene_, light, point, direction, medium, active), paths.medium, entry, active);
  }
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
    const WidePath path = frontier_.path(scene_, entry, active);
    const Sampler numbers = keys.sampler(scene_.sampler.kind, path.slot, active);
    LightVertex& here = uses.keep ? new_vertex(event, k) : passing_;
    meet_surface(scene_, path, found, numbers, first_pair(event), hit, here.vertex);
    here.beta = path.beta;
    here.joinable = joinable(here.vertex, events);
    here.weights = arrive(event, k, path, here.vertex, events);
    if (uses.sink) uses.sink->add(here, event);
    if (uses.film) {
      const UInt key =
          scene_.volumetric ? hash(numbers_of(keys).key(path.slot, active) ^ join_salt(event)) : UInt(0);
      join_to_camera(here, event, numbers.get_2d(first_pair(event) + dimension::kJoinLens), key,
                     uses.film->rect());
    }
    go_on(here, path, numbers, event, k, event + 1 < scene_.max_depth ? events : Mask::none());
  }
  frontier_.end_step();
}

LightVertex& LightSubpaths::new_vertex(int event, int packet) {
  if (used_ == pool_.size()) pool_.push_back(std::unique_ptr<LightVertex>(new LightVertex));
  const auto place = static_cast<std::size_t>(event * kPackets + packet);
  if (kept_.size() <= place) kept_.resize(static_cast<std::size_t>(event + 1) * kPackets, -1);
  kept_[place] = static_cast<std::int32_t>(used_);
  return *pool_[used_++];
}

PartialWeights LightSubpaths::arrive(int event, int packet, const WidePath& path, const Vertex& v,
                                     Mask hit) const {
  const Float cosine = cosine_at(v, v.wo);
  if (event > 0) {
    PartialWeights weights = weights_.load(packet);
    const Vec3 before = scene_.volumetric ? path.reference : path.origin;
    weights.arrive(length_squared(v.surface.p - before), cosine);
    return weights;
  }
  const Int light = Int::load(light_ + packet * kWidth);
  Vec3 point, normal;
  load_lanes(point_, packet * kWidth, point);
  load_lanes(normal_, packet * kWidth, normal);
  const Mask flat = length_squared(normal) > 0.0f;
  const Float pdf = sampling_density(scene_.lights, light, receiver_at(scene_, v), v.wo, point, normal, hit);
  const Float light_cosine = select(flat, dot(normal, -v.wo), 1.0f);
  return light_end(scene_.lights, light, pdf, point, light_cosine, -v.wo, length_squared(v.surface.p - point),
                   hit)
      .first_vertex(cosine);
}

void LightSubpaths::join_to_camera(const LightVertex& here, int event, Vec2 u_lens, UInt key,
                                   const FilmRect& rect) {
  if (!sees_points(scene_.camera) || none(here.joinable) || !filter_.wants(event + 2, 1)) return;
  CameraJoin join = camera_join(scene_, here.vertex, here.beta, u_lens, rect, here.joinable);
  if (none(join.seen)) return;
  if (filter_.all()) {
    const Float density = join.eye.importance * cosine_at(here.vertex, join.w) * (1.0f / paths_a_pass_);
    join.value *=
        weight_of_way(here.weights.ways(density, join.back.pdf, merged_at(here.vertex)), Float(0.0f));
  }
  joins_.add(here.vertex, join, key, join.seen);
}

void LightSubpaths::go_on(const LightVertex& here, const WidePath& path, const Sampler& numbers, int event,
                          int packet, Mask hit) {
  if (none(hit)) {
    frontier_.drop(packet);
    return;
  }
  const Vertex& v = here.vertex;
  const int pair = first_pair(event);
  const BsdfSample bsdf =
      sample_scattering(scene_, v, numbers.get_2d(pair + dimension::kLobe).x,
                        numbers.get_2d(pair + dimension::kLightBsdfDirection), hit, Transport::kImportance);
  const Mask spread = and_not(hit & bsdf.valid, bsdf.specular);
  // The light that leaves is what paths from the eye would find: their value, over the density of this side.
  const BsdfEval back = eval_scattering(scene_, v, bsdf.wi, v.wo, spread);
  const Spectrum exact = back.f_cos * (adjoint_ratio(v, bsdf.wi) / max(bsdf.pdf, 1e-37f));
  const Spectrum sampled =
      bsdf.weight * select(v.in_medium, 1.0f, normal_ratio(v.surface, v.at.frame, v.wo, bsdf.wi));
  WidePath next = path;
  next.origin = next.reference = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  if (scene_.volumetric)
    next.medium = medium_behind(scene_.shapes, v.surface, bsdf.wi, v.medium, and_not(hit, v.in_medium));
  next.beta = path.beta * select(and_not(spread, estimates_density(v.at, spread)), exact, sampled);
  Mask alive = and_not(hit & bsdf.valid & is_finite(next.beta), is_black(next.beta));
  const Float u = numbers.get_2d(pair + dimension::kLightRoulette).x;
  alive &= survive_roulette(next.beta, next.roulette_scale, u, event < kLongSubpath ? 1.0f : kLongSurvival);
  weights_.store(
      here.weights.scattered(cosine_at(v, bsdf.wi), bsdf.pdf, back.pdf, merged_at(v), bsdf.specular), packet);
  frontier_.replace(scene_, packet, next, alive);
}

}  // namespace tessera::render::TESSERA_ISA
