#include "render/integrator/radiosity/radiosity.h"

#include <bit>
#include <cmath>

#include "render/core/constants.h"
#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/light/selection/pick.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A patch is not asked from nearer than so many of its sizes: its light is not known that finely.
constexpr double kNearInPatches = 2;
/// Paths in corners end here, at their patches, however near.
constexpr int kMostNear = 8;

}  // namespace

/// Sixteen points that rays have met.
struct Radiosity::Point {
  WidePath path;
  Hit found;
  Vertex vertex;
  Mask hit = Mask::none();
};

Radiosity::Radiosity(const IntegratorContext& context)
    : scene_(context.scene),
      rays_(context.rays),
      stats_(context.stats),
      solved_(*static_cast<const radiosity::Solved*>(context.prepared)),
      batch_(context) {}

bool Radiosity::render(SampleSource& work, Film& film, std::stop_token stop) {
  while (batch_.start(work, paths_)) {
    if (stop.stop_requested()) return false;
    alive_ = batch_.size();
    for (int depth = 0; alive_ > 0; ++depth) meet(depth);
    batch_.finish(film, scene_.radiosity.final_gather);
  }
  return true;
}

Vec2 Radiosity::random(const Point& point, int pair) const {
  return batch_.sampler(point.path.slot, point.hit).get_2d(pair);
}

void Radiosity::meet(int depth) {
  if (depth > 0) stats_.bounce_rays += static_cast<std::uint64_t>(alive_);
  {
    const StageTimer timer(stats_.times, Stage::kIntersection);
    find_hits(scene_, rays_, paths_, alive_, depth, PathOrder::kNeighbours, hits_);
  }
  const bool gather = scene_.radiosity.final_gather;
  int kept = 0;
  shadows_.size = 0;
  {
    const StageTimer timer(stats_.times, Stage::kShading);
    for (int i = 0; i < alive_; i += kWidth) {
      const Mask active = Mask::first(alive_ - i);
      Point point{.path = load(scene_, paths_, i), .found = load_hit(hits_, i), .vertex = {}};
      point.hit = active & (point.found.shape >= 0);
      Vertex& v = point.vertex;
      v.wo = -point.path.direction;
      v.time = Float(0.0f);
      v.surface = surface_at(scene_.shapes, point.found, point.path.origin, point.path.direction, point.hit,
                             scene_.any_tangents);
      // Sampled light is found from the point before.
      if (depth == 0) add_emission(point, active);
      if (none(point.hit)) continue;
      interact(scene_, v.surface, v.wo, random(point, dimension::kFirstEvent + dimension::kRoulette).y,
               point.hit, v.at);
      if (depth == 0) {
        batch_.record_first_hit(v, point.found.t, point.path.slot, point.hit);
        if (scene_.aovs.of_hits()) batch_.record_hit(point.found, point.path.slot, point.hit);
      }
      Mask open = point.hit;
      if (!gather || depth > 0) open = and_not(open, add_patches(point, open, !gather || depth == kMostNear));
      if (none(open)) continue;
      add_light(point, open, depth);
      scatter(point, open, depth, kept);
    }
    alive_ = kept;
  }
  const StageTimer timer(stats_.times, Stage::kShadow);
  rays_.occluded(arrays_of(shadows_.origin, shadows_.direction, nullptr), shadows_.size, shadows_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(shadows_.size);
  batch_.add_contributions(shadows_);
}

void Radiosity::add_emission(const Point& point, Mask active) {
  const WidePath& path = point.path;
  const Surface& surface = point.vertex.surface;
  if (const Mask lit = point.hit & (surface.light >= 0); any(lit)) {
    const Spectrum radiance = emitted_radiance(scene_.lights, surface.light, surface, point.vertex.wo, lit);
    batch_.add_radiance(radiance * path.beta, path.slot, lit);
  }
  const Mask missed = and_not(active, point.hit);
  if (none(missed)) return;
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Spectrum radiance = environment_radiance(scene_.lights, light, path.origin, path.direction, missed);
    batch_.add_radiance(radiance * path.beta, path.slot, missed);
  }
}

/// Adds what the patches there reflect, of lanes that are far enough from them; returns these.
Mask Radiosity::add_patches(const Point& point, Mask wanted, bool seen_directly) {
  const Vertex& v = point.vertex;
  alignas(64) std::int32_t shape[kWidth], primitive[kWidth], instance[kWidth], behind[kWidth];
  alignas(64) float t[kWidth], b1[kWidth], b2[kWidth], band[kBands][kWidth] = {};
  point.found.shape.store(shape), point.found.primitive.store(primitive);
  point.found.instance.store(instance), point.found.t.store(t);
  v.surface.barycentric.x.store(b1), v.surface.barycentric.y.store(b2);
  select(dot(v.wo, v.surface.ng) < 0.0f, Int(1), Int(0)).store(behind);
  std::uint32_t added = 0;
  for (std::uint32_t bits = wanted.bits(); bits != 0; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    const radiosity::Side side = solved_.surfaces.side_of_hit(shape[i], primitive[i], instance[i]) +
                                 static_cast<radiosity::Side>(behind[i]);
    const double u = double{b1[i]}, w = double{b2[i]};
    const radiosity::Shown shown = radiosity::look_up(solved_.solution, side, {{1 - u - w, u, w}});
    if (!seen_directly) {
      const double size = std::sqrt(solved_.surfaces.area(side)) * std::exp2(-shown.level);
      if (double{t[i]} < kNearInPatches * size) continue;
    }
    added |= std::uint32_t{1} << i;
    for (int b = 0; b < kBands; ++b) band[b][i] = shown.irradiance.band[b];
  }
  const Mask lanes = Mask::from_bits(added);
  const Spectrum irradiance = spectrum_of([&](int b) { return Float::load(band[b]); });
  batch_.add_radiance(point.path.beta * albedo_of(v.at, lanes) * irradiance * kInvPi, point.path.slot, lanes);
  return lanes;
}

void Radiosity::add_light(const Point& point, Mask wanted, int depth) {
  if (!samples_lights(scene_.lights)) return;
  const Vertex& v = point.vertex;
  const Receiver here = receiver_at(scene_, v);
  const int first_pair = dimension::kFirstEvent + depth * dimension::kPairsPerEvent;
  Vec2 u = random(point, first_pair + dimension::kLightPoint);
  const LightPick choice =
      pick_light(scene_.lights, here, random(point, first_pair + dimension::kChoice).x, wanted);
  const LightSample light = sample_light(scene_.lights, choice.light, here, u, choice.picked);
  const Mask reachable = choice.picked & light.valid;
  if (none(reachable)) return;
  const Spectrum f_cos = eval_bsdf(v.at, v.wo, light.wi, reachable).f_cos;
  WideConnection ray = connect(scene_, v, light.wi, fma(light.wi, light.distance, v.surface.p), reachable);
  ray.contribution =
      point.path.beta * f_cos * light.radiance * (1.0f / select(reachable, light.pdf * choice.pmf, 1.0f));
  ray.slot = point.path.slot;
  shadows_.size +=
      append(scene_, ray, and_not(reachable, is_black(ray.contribution)), shadows_, shadows_.size);
}

void Radiosity::scatter(const Point& point, Mask wanted, int depth, int& kept) {
  const Vertex& v = point.vertex;
  const int first_pair = dimension::kFirstEvent + depth * dimension::kPairsPerEvent;
  const BsdfSample bsdf = sample_bsdf(v.at, v.wo, random(point, first_pair + dimension::kChoice).y,
                                      random(point, first_pair + dimension::kBsdfDirection), wanted);
  WidePath next = point.path;
  next.origin = next.reference = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  next.beta = point.path.beta * bsdf.weight;
  // Entries are read 16 at a time before they are overwritten.
  kept += append(scene_, next, and_not(wanted & bsdf.valid, is_black(next.beta)), paths_, kept);
}

}  // namespace tessera::render::TESSERA_ISA
