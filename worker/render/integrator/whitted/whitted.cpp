#include "render/integrator/whitted/whitted.h"

#include "render/core/constants.h"
#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/integrator/vertex/layers.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Rays that bring less of the light to the eye than this are not followed [Hall & Greenberg 1983], nor those
/// of a smaller share: the product of their lobes' probabilities, which materials that make light cannot
/// raise. So a level has at most 1000 rays a sample, however deep the recursion goes.
constexpr float kLeastImportance = 1e-3f;

int first_pair(int depth) { return dimension::kFirstEvent + depth * dimension::kPairsPerEvent; }

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
  follow(depth, next, reflected, refracted);
  return trace(next.reflected, reflected, depth + 1, stop) &&
         trace(next.refracted, refracted, depth + 1, stop);
}

void Whitted::find_points(const PathState& rays, int n, int depth) {
  if (depth > 0) stats_.bounce_rays += static_cast<std::uint64_t>(n);
  {
    const StageTimer timer(stats_.times, Stage::kIntersection);
    find_hits(scene_, rays_, rays, n, depth, PathOrder::kNeighbours, hits_);
  }
  const StageTimer timer(stats_.times, Stage::kShading);
  packets_ = (n + kWidth - 1) / kWidth;
  for (int i = 0; i < packets_; ++i) {
    const Mask active = Mask::first(n - i * kWidth);
    Hit found = load_hit(hits_, i * kWidth);
    Point& point = points_[static_cast<std::size_t>(i)];
    point.path = load(scene_, rays, i * kWidth);
    if (depth == 0) point.path.pdf = Float(1.0f);  // here, a ray's share
    point.hit = active & (found.shape >= 0);
    if (scene_.any_motion) found.time = point.path.time;
    if (none(point.hit)) {  // there may be no surface at all
      add_emission(point, active);
      continue;
    }
    Vertex& v = point.vertex;
    v.wo = -point.path.direction;
    v.time = found.time;
    v.surface = surface_at(scene_.shapes, found, point.path.origin, point.path.direction, point.hit,
                           scene_.any_tangents);
    add_emission(point, active);
    const Float u = random(point, first_pair(depth) + dimension::kRoulette).y;
    interact(scene_, v.surface, v.wo, u, point.hit, v.at);
    if (const Mask partly = partly_open(v, point.hit); any(partly))
      open_surface(scene_, random(point, dimension::kOpacity + depth).x, partly, v);
    if (depth > 0) continue;
    batch_.record_first_hit(v, found.t, point.path.slot, point.hit);
    if (scene_.aovs.of_hits()) batch_.record_hit(found, point.path.slot, point.hit);
  }
}

void Whitted::add_emission(const Point& point, Mask active) {
  const WidePath& path = point.path;
  const Surface& surface = point.vertex.surface;
  if (const Mask lit = point.hit & (surface.light >= 0); any(lit)) {
    const Spectrum radiance = emitted_radiance(scene_.lights, surface.light, surface, point.vertex.wo, lit);
    batch_.add_radiance(radiance * path.beta, path.slot, lit);
    if (tells_layers(scene_)) {
      const Int layers = layers_at_light(scene_.layers, path.layer_state, surface.light, lit);
      batch_.add_to_layers(radiance * path.beta, layers, path.slot, lit);
    }
  }
  const Mask missed = and_not(active, point.hit);
  if (none(missed)) return;
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Spectrum radiance = environment_radiance(scene_.lights, light, path.origin, path.direction, missed);
    batch_.add_radiance(radiance * path.beta, path.slot, missed);
    if (tells_layers(scene_)) {
      const Int layers = layers_at_light(scene_.layers, path.layer_state, Int(light), missed);
      batch_.add_to_layers(radiance * path.beta, layers, path.slot, missed);
    }
  }
}

void Whitted::add_light(std::int32_t light, int depth) {
  const StageTimer timer(stats_.times, Stage::kShadow);
  shadows_.size = 0;
  for (int i = 0; i < packets_; ++i) {
    const Point& point = points_[static_cast<std::size_t>(i)];
    const Vertex& v = point.vertex;
    const Mask wanted = joinable(v, point.hit);
    if (none(wanted)) continue;
    const LightSample sample =
        sample_light(scene_.lights, Int(light), receiver_at(scene_, v),
                     random(point, first_pair(depth) + dimension::kLightPoint), wanted);
    const Mask reachable = wanted & sample.valid;
    if (none(reachable)) continue;
    const Spectrum f_cos = eval_bsdf(v.at, v.wo, sample.wi, reachable).f_cos;
    WideConnection ray =
        connect(scene_, v, sample.wi, fma(sample.wi, sample.distance, v.surface.p), reachable);
    ray.contribution =
        point.path.beta * f_cos * sample.radiance * (1.0f / select(reachable, sample.pdf, 1.0f));
    ray.slot = point.path.slot;
    if (tells_layers(scene_)) {
      const Int state = state_after(scene_, v, point.path.layer_state, v.wo, sample.wi, Mask::none(),
                                    {batch_.sampler(point.path.slot, point.hit), depth, true}, reachable);
      ray.layers = layers_at_light(scene_.layers, state, Int(light), reachable);
      if (shadow_layers_) {
        WideConnection blocked = ray;
        blocked.layers = shadows_at_light(scene_.layers, state, Int(light), reachable);
        shadow_layers_->add(blocked, reachable, batch_, depth);
      }
    }
    shadows_.size +=
        append(scene_, ray, and_not(reachable, is_black(ray.contribution)), shadows_, shadows_.size);
  }
  const float* const times = scene_.any_motion ? shadows_.time : nullptr;
  rays_.occluded(arrays_of(shadows_.origin, shadows_.direction, times), shadows_.size, shadows_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(shadows_.size);
  batch_.add_contributions(shadows_);
  if (shadow_layers_) shadow_layers_->trace(batch_, depth);
}

void Whitted::follow(int depth, Level& next, int& reflected, int& refracted) const {
  const StageTimer timer(stats_.times, Stage::kShading);
  for (int i = 0; i < packets_; ++i) {
    const Point& point = points_[static_cast<std::size_t>(i)];
    const Vertex& v = point.vertex;
    const Vec2 zero{Float(0.0f), Float(0.0f)};
    const auto send = [&](const BsdfSample& lobe, Float share, Mask lanes, PathState& to, int& size) {
      WidePath ray = point.path;
      ray.origin = ray.reference = offset_origin(v.surface, lobe.wi);
      ray.direction = lobe.wi;
      ray.beta = point.path.beta * lobe.weight * share;
      ray.pdf = point.path.pdf * share;
      // Without the 1 / eta^2 of refraction, which the way out takes back.
      ray.roulette_scale =
          select(lobe.transmission, point.path.roulette_scale * sqr(lobe.eta), point.path.roulette_scale);
      if (tells_layers(scene_)) {
        ray.layer_state =
            state_after(scene_, v, point.path.layer_state, v.wo, lobe.wi, lobe.specular,
                        {batch_.sampler(point.path.slot, point.hit), depth, false}, lanes & lobe.specular);
      }
      const Float importance = (ray.beta * ray.roulette_scale).max_component();
      const Mask matters = min(importance, ray.pdf) >= kLeastImportance;
      size += append(scene_, ray, lanes & lobe.valid & lobe.specular & matters, to, size);
    };
    // The first and the last of a model's lobes, if these are perfect; `pdf` is a perfect lobe's share. Of
    // mixed materials, whose lobes nobody counts, one is drawn, so its weight holds the share.
    const Mask mixed = point.hit & ((v.at.flags & kMixed) != 0);
    const Float drawn = random(point, first_pair(depth) + dimension::kChoice).y;
    const BsdfSample first = sample_bsdf(v.at, v.wo, select(mixed, drawn, 0.0f), zero, point.hit);
    send(first, select(mixed, 1.0f, first.pdf), point.hit, next.reflected, reflected);
    const Mask others = and_not(point.hit, mixed);
    const BsdfSample last = sample_bsdf(v.at, v.wo, Float(kOneMinusEpsilon), zero, others);
    const Mask same = first.valid & first.specular & ~(first.transmission ^ last.transmission);
    send(last, last.pdf, and_not(others, same), next.refracted, refracted);
  }
}

}  // namespace tessera::render::TESSERA_ISA
