// One scattering event of 16 paths: what the ray met, what shines on it, where the path goes on.
#include "render/transport/path/packing.h"
#include "render/transport/path/wavefront.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/light_choice.h"
#include "render/transport/vertex/met_light.h"
#include "render/transport/vertex/roulette.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Lanes whose shape emits.
TESSERA_INLINE Mask emits(const ShapeTable& table, Int shape, Mask hit) {
  if (none(hit)) return hit;  // there may be no shapes, whose table cannot be read
  return hit & (gather_member(table.shapes.data(), &ShapeRecord::first_light, shape, hit) >= 0);
}

}  // namespace

void Wavefront::shade(int depth) {
  const StageTimer timer(stats_.times, Stage::kShading);
  shading_timer_.start();
  // Few paths fill few packets, in whatever order.
  constexpr int kLeastToSort = 4 * kWidth;
  // The last segment of a path brings the light of what it meets, and nothing else.
  const bool last = depth == max_depth_, lights_alone = last && depth > 0;
  const bool sort = scene_.shading_groups > 0 && alive_ >= kLeastToSort && !lights_alone;
  if (sort) sort_by_group();
  const PathState& paths = sort ? sorted_.paths : paths_;
  const HitState& hits = sort ? sorted_.hits : hits_;
  int kept = 0;
  for (int i = 0; i < alive_; i += kWidth) {
    Encounter e(scene_, batch_, paths, hits, depth, i, Mask::first(alive_ - i));
    e.reference.roughly = samples_roughly(scene_, depth - 1);
    if (any(e.missed) && !scene_.lights.infinite_lights.empty()) add_environment(e);
    const Mask seen = lights_alone ? emits(scene_.shapes, e.hit.shape, e.on_surface) : e.on_surface;
    if (none(lights_alone ? seen : e.met)) continue;

    e.find_surface(scene_, seen);
    add_emission(e, seen);
    shading_timer_.lap(ShadingPart::kSurfaces);
    if (lights_alone) continue;
    e.find_scattering(scene_);
    // Numbers that nobody looks at are not drawn: Lambertian surfaces have one lobe.
    const bool choosy = !e.vertex.at.lambertian || steering_ != nullptr || !one_pair_serves(scene_.lights);
    e.choice = choosy ? e.random(dimension::kChoice) : Vec2{Float(0.0f), Float(0.0f)};
    if (depth == 0) batch_.record_first_hit(e.vertex, e.hit, e.path.slot, e.met);
    if (last) continue;

    shading_timer_.lap(ShadingPart::kMaterials);
    e.settled = Mask::none();
    for (PathObserver* observer : observers_) observer->met(e);
    disperse_at(scene_, e.vertex, e.met, e.path);
    sample_one_light(e);
    shading_timer_.lap(ShadingPart::kPaths);
    scatter_path(e, kept);
    shading_timer_.lap(ShadingPart::kPaths);
    shading_timer_.share(e.vertex.surface.material, e.on_surface);
  }
  alive_ = kept;
}

void Wavefront::add_environment(const Encounter& e) {
  const Mask weighed = e.missed & (e.path.pdf > 0.0f);
  Spectrum sum(0.0f);
  for (const std::int32_t number : scene_.lights.infinite_lights) {
    MetLight light = sky_met(scene_, e, number, weighed);
    for (PathObserver* observer : observers_) observer->emitted(e, light);
    sum += light.arriving;
  }
  batch_.add_radiance(sum * e.path.beta, e.path.slot, e.missed);
}

void Wavefront::add_emission(const Encounter& e, Mask hit) {
  const Mask lit = hit & (e.vertex.surface.light >= 0);
  if (none(lit)) return;
  MetLight light = lamps_met(scene_, e, lit, lit & (e.path.pdf > 0.0f));
  interpolate_normals(scene_, e, light);
  for (PathObserver* observer : observers_) observer->emitted(e, light);
  batch_.add_radiance(light.arriving * e.path.beta, e.path.slot, lit);
}

void Wavefront::sample_one_light(const Encounter& e) {
  const Vertex& v = e.vertex;
  const Mask wanted = joinable(v, e.met);
  if (!samples_lights(scene_.lights) || none(wanted)) return;

  const Vec2 point = e.random(dimension::kLightPoint);
  const auto [choice, sample] =
      choose_light(scene_.lights, receiver_at(scene_, e), point, e.choice.x, wanted);
  shading_timer_.lap(ShadingPart::kLights);
  const Mask reachable = choice.picked & sample.valid;
  if (none(reachable)) return;
  BsdfEval bsdf = eval_scattering(scene_, v, sample.wi, reachable);
  if (steering_ != nullptr) bsdf.pdf = steering_->pdf(e.steered, sample.wi, bsdf.pdf, reachable);

  shading_timer_.lap(ShadingPart::kMaterials);
  const Float pdf = sample.pdf * choice.pmf;
  const Float weight = select(sample.delta | e.settled, Float(1.0f), power_heuristic(pdf, bsdf.pdf));
  SampledLight light =
      light_sampled(scene_, batch_, e, choice.light, sample, pdf, weight, bsdf.f_cos, reachable);
  interpolate_normals(scene_, e, bsdf.pdf, light);
  for (PathObserver* observer : observers_) observer->lit(e, light);
  const Mask shines = and_not(reachable, is_black(light.ray.contribution));
  shadows_.size += append_at_end(scene_, light.ray, shines, shadows_, shadows_.size);
}

void Wavefront::scatter_path(const Encounter& e, int& kept) {
  const Vertex& v = e.vertex;
  const Vec2 u = e.random(dimension::kBsdfDirection);
  Scattering s(and_not(e.met, e.settled));
  s.bsdf = steering_ != nullptr ? steering_->sample(e, u, s.lanes)
                                : sample_scattering(scene_, v, e.choice.y, u, s.lanes);
  const BsdfSample& bsdf = s.bsdf;
  shading_timer_.lap(ShadingPart::kMaterials);
  WidePath& next = s.next;
  next.origin = next.reference = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  next.beta = e.path.beta * bsdf.weight;
  next.wavelengths = e.path.wavelengths;
  next.dispersed = e.path.dispersed;
  disperse_along(scene_, v, bsdf, next);
  next.pdf = select(bsdf.specular, Float(0.0f), bsdf.pdf);
  next.roulette_scale =
      select(bsdf.transmission, e.path.roulette_scale * sqr(bsdf.eta), e.path.roulette_scale);
  next.slot = e.path.slot;
  next.time = v.time;
  if (scene_.lights.uses_normals) next.normal = receiver_at(scene_, v).normal;
  if (scene_.volumetric) {
    next.medium = medium_behind(scene_.shapes, v.surface, bsdf.wi, v.medium, and_not(s.lanes, v.in_medium));
  }
  s.alive = and_not(s.lanes & bsdf.valid, is_black(next.beta));
  for (PathObserver* observer : observers_) observer->scattered(e, s);
  if (e.depth > kRouletteStart) {
    Spectrum raised = next.beta;
    const Mask survives = survive_roulette(raised, next.roulette_scale, e.roulette_number(scene_));
    next.beta = select(s.spared, next.beta, raised);
    s.alive &= survives | s.spared;
  }
  for (PathObserver* observer : observers_) observer->ended(e, s);

  // Entries are read 16 at a time, or sorted elsewhere, before they are overwritten, and never move up.
  kept += append_at_end(scene_, next, s.alive, paths_, kept);
}

}  // namespace tessera::render::TESSERA_ISA
