#include "render/textbook/whitted/whitted.h"

#include "render/core/constants.h"
#include "render/integrator/algorithm_list.h"
#include "render/integrator/stage_timer.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/met_light.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Rays that bring less of the light to the eye than this are not followed [Hall & Greenberg 1983], nor those
/// of a smaller share: the product of their lobes' probabilities, which materials that make light cannot
/// raise. So a level has at most 1000 rays a sample, however deep the recursion goes.
constexpr float kLeastImportance = 1e-3f;

}  // namespace

bool Whitted::render(SampleSource& work, Film& film, std::stop_token stop) {
  while (batch_.start(work, camera_rays_)) {
    if (!trace(camera_rays_, batch_.size(), 0, stop)) return false;
    batch_.finish(film, max_depth_ > 0);
  }
  return true;
}

bool Whitted::trace(const PathState& rays, int n, int depth, const std::stop_token& stop) {
  if (n == 0) return true;
  find_points(rays, n, depth);
  if (depth == max_depth_) return !stop.stop_requested();
  for (std::size_t light = 0; light < scene_.lights.lights.size(); ++light) {
    if (stop.stop_requested()) return false;
    if (scene_.lights.lights[light].same_as < 0) add_light(static_cast<std::int32_t>(light), depth);
  }

  if (!follows_) return true;
  if (levels_.size() <= static_cast<std::size_t>(depth)) levels_.push_back(std::make_unique<Level>());
  Level& next = *levels_[static_cast<std::size_t>(depth)];
  int reflected = 0, refracted = 0;
  follow(next, reflected, refracted);
  return trace(next.reflected, reflected, depth + 1, stop) &&
         trace(next.refracted, refracted, depth + 1, stop);
}

void Whitted::find_points(const PathState& rays, int n, int depth) {
  batch_.find_hits(rays, n, depth, hits_);
  const StageTimer timer(stats_.times, Stage::kShading);
  encounters_.clear();
  for (int i = 0; i < n; i += kWidth) {
    Encounter& e = encounters_.emplace_back(scene_, batch_, rays, hits_, depth, i, Mask::first(n - i));
    if (depth == 0) e.path.pdf = Float(1.0f);       // here, a ray's share
    if (any(e.met)) e.find_surface(scene_, e.met);  // there may be no surface at all
    add_emission(e);
    if (none(e.met)) continue;
    e.find_scattering(scene_);
    disperse_at(scene_, e.vertex, e.met, e.path);
    if (depth == 0) batch_.record_first_hit(e.vertex, e.hit, e.path.slot, e.met);
  }
}

void Whitted::add_emission(const Encounter& e) {
  const auto take = [&](MetLight light) {
    for (PathObserver* observer : observers_) observer->emitted(e, light);
    batch_.add_radiance(light.arriving * e.path.beta, e.path.slot, light.lanes);
  };
  if (any(e.met)) {
    const Mask lit = e.met & (e.vertex.surface.light >= 0);
    if (any(lit)) take(lamps_met(scene_, e, lit, Mask::none()));
  }
  if (none(e.missed)) return;
  for (const std::int32_t light : scene_.lights.infinite_lights)
    take(sky_met(scene_, e, light, Mask::none()));
}

void Whitted::add_light(std::int32_t number, int depth) {
  {
    const StageTimer timer(stats_.times, Stage::kShadow);
    for (const Encounter& e : encounters_) {
      const Vertex& v = e.vertex;
      const Mask wanted = joinable(v, e.met);
      if (none(wanted)) continue;
      const LightSample sample = sample_light(scene_.lights, Int(number), receiver_at(scene_, v),
                                              e.random(dimension::kLightPoint), wanted);
      const Mask reachable = wanted & sample.valid;
      if (none(reachable)) continue;
      const Spectrum f_cos = eval_bsdf(v.at, v.wo, sample.wi, reachable).f_cos;
      SampledLight light =
          light_sampled(scene_, batch_, e, Int(number), sample, sample.pdf, Float(1.0f), f_cos, reachable);
      for (PathObserver* observer : observers_) observer->lit(e, light);
      const Mask shines = and_not(reachable, is_black(light.ray.contribution));
      shadows_.size += append(scene_, light.ray, shines, shadows_, shadows_.size);
    }
    batch_.trace(shadows_);
  }
  for (PathObserver* observer : observers_) observer->all_scattered(depth);
}

void Whitted::follow(Level& next, int& reflected, int& refracted) const {
  const StageTimer timer(stats_.times, Stage::kShading);
  for (const Encounter& e : encounters_) {
    const Vertex& v = e.vertex;
    const Vec2 zero{Float(0.0f), Float(0.0f)};
    const auto send = [&](const BsdfSample& lobe, Float share, Mask lanes, PathState& to, int& size) {
      Scattering s(lanes & lobe.valid & lobe.specular);
      s.bsdf = lobe;
      WidePath& ray = s.next = e.path;
      ray.origin = ray.reference = offset_origin(v.surface, lobe.wi);
      ray.direction = lobe.wi;
      ray.beta = e.path.beta * lobe.weight * share;
      disperse_along(scene_, v, lobe, ray);
      ray.pdf = e.path.pdf * share;
      // Without the 1 / eta^2 of refraction, which the way out takes back.
      ray.roulette_scale =
          select(lobe.transmission, e.path.roulette_scale * sqr(lobe.eta), e.path.roulette_scale);
      const Float importance = (ray.beta * ray.roulette_scale).max_component();
      s.alive = s.lanes & (min(importance, ray.pdf) >= kLeastImportance);
      for (PathObserver* observer : observers_) observer->scattered(e, s);
      size += append(scene_, ray, s.alive, to, size);
    };
    // The first and the last of a model's lobes, if these are perfect; `pdf` is a perfect lobe's share. Of
    // mixed materials, whose lobes nobody counts, one is drawn, so its weight holds the share.
    const Mask mixed = e.met & ((v.at.flags & kMixed) != 0);
    const Float drawn = e.random(dimension::kChoice).y;
    const BsdfSample first = sample_bsdf(v.at, v.wo, select(mixed, drawn, 0.0f), zero, e.met);
    send(first, select(mixed, 1.0f, first.pdf), e.met, next.reflected, reflected);
    const Mask others = and_not(e.met, mixed);
    const BsdfSample last = sample_bsdf(v.at, v.wo, Float(kOneMinusEpsilon), zero, others);
    const Mask same = first.valid & first.specular & ~(first.transmission ^ last.transmission);
    send(last, last.pdf, and_not(others, same), next.refracted, refracted);
  }
}

const ListedAlgorithm whitted{{"whitted", &make<Whitted>}};
const ListedAlgorithm raycast{{"raycast", &make_for_one_event<Whitted, Whitted::Mirrors::kBlack>}};

}  // namespace tessera::render::TESSERA_ISA
