#include "render/textbook/radiosity/radiosity.h"

#include <bit>
#include <cmath>

#include "render/core/constants.h"
#include "render/integrator/algorithm_list.h"
#include "render/integrator/stage_timer.h"
#include "render/light/selection/pick.h"
#include "render/transport/vertex/met_light.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A patch is not asked from nearer than so many of its sizes: its light is not known that finely.
constexpr double kNearInPatches = 2;
/// Paths in corners end here, at their patches, however near.
constexpr int kMostNear = 8;

}  // namespace

Radiosity::Radiosity(const IntegratorContext& context)
    : scene_(context.scene),
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

void Radiosity::meet(int depth) {
  batch_.find_hits(paths_, alive_, depth, hits_);
  const bool gather = scene_.radiosity.final_gather;
  int kept = 0;
  {
    const StageTimer timer(stats_.times, Stage::kShading);
    for (int i = 0; i < alive_; i += kWidth) {
      const Mask active = Mask::first(alive_ - i);
      Encounter e(scene_, batch_, paths_, hits_, depth, i, active);
      e.find_surface(scene_, e.on_surface);
      // Sampled light is found from the point before.
      if (depth == 0) add_emission(e);
      if (none(e.met)) continue;
      const Vertex& v = e.vertex;
      interact(scene_, v.surface, v.wo, e.random(dimension::kRoulette).y, spectra_of(scene_, e.path),
               e.on_surface, e.vertex.at);
      if (depth == 0) batch_.record_first_hit(v, e.hit, e.path.slot, e.met);
      Mask open = e.on_surface;
      if (!gather || depth > 0) open = and_not(open, add_patches(e, open, !gather || depth == kMostNear));
      if (none(open)) continue;
      add_light(e, open);
      scatter(e, open, kept);
    }
    alive_ = kept;
  }
  const StageTimer timer(stats_.times, Stage::kShadow);
  batch_.trace(shadows_);
}

void Radiosity::add_emission(const Encounter& e) {
  const auto add = [&](const MetLight& light) {
    batch_.add_radiance(light.arriving * e.path.beta, e.path.slot, light.lanes);
  };
  if (const Mask lit = e.on_surface & (e.vertex.surface.light >= 0); any(lit))
    add(lamps_met(scene_, e, lit, Mask::none()));
  if (none(e.missed)) return;
  for (const std::int32_t light : scene_.lights.infinite_lights) add(sky_met(scene_, e, light, Mask::none()));
}

/// Adds what the patches there reflect, of lanes that are far enough from them; returns these.
Mask Radiosity::add_patches(const Encounter& e, Mask wanted, bool seen_directly) {
  const Vertex& v = e.vertex;
  alignas(64) std::int32_t shape[kWidth], primitive[kWidth], instance[kWidth], behind[kWidth];
  alignas(64) float t[kWidth], b1[kWidth], b2[kWidth], band[kBands][kWidth] = {};
  e.hit.shape.store(shape), e.hit.primitive.store(primitive);
  e.hit.instance.store(instance), e.hit.t.store(t);
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
      const double size = std::sqrt(solved_.surfaces.area(side)) * std::exp2(-shown.patch_level);
      if (double{t[i]} < kNearInPatches * size) continue;
    }
    added |= std::uint32_t{1} << i;
    for (int b = 0; b < kBands; ++b) band[b][i] = shown.irradiance.band[b];
  }
  const Mask lanes = Mask::from_bits(added);
  const Spectrum irradiance = color_of([&](int b) { return Float::load(band[b]); });
  batch_.add_radiance(e.path.beta * albedo_of(v.at, lanes) * irradiance * kInvPi, e.path.slot, lanes);
  return lanes;
}

void Radiosity::add_light(const Encounter& e, Mask wanted) {
  if (!samples_lights(scene_.lights)) return;
  const Vertex& v = e.vertex;
  const Receiver here = receiver_at(scene_, v);
  Vec2 u = e.random(dimension::kLightPoint);
  const LightPick choice = pick_light(scene_.lights, here, e.random(dimension::kChoice).x, wanted);
  const LightSample light = sample_light(scene_.lights, choice.light, here, u, choice.picked);
  const Mask reachable = choice.picked & light.valid;
  if (none(reachable)) return;
  const Spectrum f_cos = eval_bsdf(v.at, v.wo, light.wi, reachable).f_cos;
  const WideConnection ray = light_sampled(scene_, batch_, e, choice.light, light, light.pdf * choice.pmf,
                                           Float(1.0f), f_cos, reachable)
                                 .ray;
  shadows_.size +=
      append(scene_, ray, and_not(reachable, is_black(ray.contribution)), shadows_, shadows_.size);
}

void Radiosity::scatter(const Encounter& e, Mask wanted, int& kept) {
  const Vertex& v = e.vertex;
  const BsdfSample bsdf =
      sample_bsdf(v.at, v.wo, e.random(dimension::kChoice).y, e.random(dimension::kBsdfDirection), wanted);
  WidePath next = e.path;
  next.origin = next.reference = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  next.beta = e.path.beta * bsdf.weight;
  // Entries are read 16 at a time before they are overwritten.
  kept += append(scene_, next, and_not(wanted & bsdf.valid, is_black(next.beta)), paths_, kept);
}

const ListedAlgorithm listed_radiosity{
    {"radiosity", &make<Radiosity>, radiosity::kPhases, &radiosity::prepare}};

}  // namespace tessera::render::TESSERA_ISA
