// One scattering event of 16 paths: what the ray met, what shines on it, where the path goes on.
#include "render/core/constants.h"
#include "render/integrator/path/packing.h"
#include "render/integrator/path/wavefront.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/integrator/vertex/layers.h"
#include "render/integrator/vertex/light_choice.h"
#include "render/integrator/vertex/partial_weights.h"
#include "render/integrator/vertex/passing.h"
#include "render/integrator/vertex/power_heuristic.h"
#include "render/integrator/vertex/roulette.h"
#include "render/light/area/interpolated_normal.h"
#include "render/light/light_access.h"
#include "render/sampling/sampler.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen paths at the end of their latest segment.
struct Wavefront::Event {
  WidePath path;
  Hit hit;
  Receiver reference;  // where the path was last scattered
  Sampler sampler;
  int first_pair;  // of this event's dimensions
  // Once something was hit
  Vec2 roulette;  // Russian roulette, mixed material
  Vec2 choice;    // light, BSDF lobe
  Vertex vertex;
  // Where paths are guided, or guides made
  GuideCells cells;
  Guided guided;

  // Loaded in place, and what is filled in later is not zeroed: copying costs 4 % of shading, zeroing 6 %.
  TESSERA_INLINE Event(const SceneTables& scene, const SampleBatch& batch, const PathState& paths,
                       const HitState& hits, int pair, int i, Mask active)
      : path(load(scene, paths, i)),
        hit(load_hit(hits, i)),
        reference(path.origin),
        sampler(batch.sampler(path.slot, active)),
        first_pair(pair) {}
};

namespace {

/// At this event and later ones, lights are sampled roughly (measured: docs/decisions/0012-lights.md). Not in
/// media, whose points come arbitrarily close to lamps.
constexpr int kFirstRoughEvent = 2;

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
  const int first_pair = dimension::kFirstEvent + depth * dimension::kPairsPerEvent;
  for (int i = 0; i < alive_; i += kWidth) {
    const Mask active = Mask::first(alive_ - i);
    Event e(scene_, batch_, paths, hits, first_pair, i, active);
    const WidePath& path = e.path;
    Vertex& v = e.vertex;
    v.wo = -path.direction;
    const Mask hit = active & (e.hit.shape >= 0);
    if (scene_.volumetric) {
      e.reference.p = path.reference;
      v.medium = path.medium;
      v.in_medium = active & (e.hit.shape == kScatteredByMedium);
    }
    if (scene_.any_motion) e.hit.time = path.time;
    v.time = e.hit.time;
    if (scene_.lights.uses_normals) e.reference.normal = path.normal;
    e.reference.roughly = depth - 1 >= kFirstRoughEvent && !scene_.volumetric;
    const Mask events = hit | v.in_medium;
    const Mask missed = and_not(active, events);
    if (any(missed) && !scene_.lights.infinite_lights.empty()) add_environment(e, missed, depth);
    const Mask seen = lights_alone ? emits(scene_.shapes, e.hit.shape, hit) : hit;
    if (none(lights_alone ? seen : events)) continue;

    v.surface = surface_at(scene_.shapes, e.hit, path.origin, path.direction, seen, scene_.any_tangents);
    add_emission(e, seen, depth);
    shading_timer_.lap(ShadingPart::kSurfaces);
    if (lights_alone) continue;
    if (scene_.any_mix) e.roulette = e.sampler.get_2d(first_pair + dimension::kRoulette);
    interact(scene_, v.surface, v.wo, e.roulette.y, hit, v.at);
    if (any(v.in_medium)) put_into_medium(fma(path.direction, e.hit.t, path.origin), v.in_medium, v);
    if (scene_.any_opacity && !scene_.paths_pass) {  // else transit() has seen to it
      if (const Mask partly = partly_open(v, hit); any(partly)) {
        open_surface(scene_, e.sampler.get_2d(dimension::kOpacity + depth).x, partly, v);
      }
    }
    // Numbers that nobody looks at are not drawn: Lambertian surfaces have one lobe.
    const bool choosy = !v.at.lambertian || guide_ != nullptr || !one_pair_serves(scene_.lights);
    e.choice = choosy ? e.sampler.get_2d(first_pair + dimension::kChoice) : Vec2{Float(0.0f), Float(0.0f)};
    if (depth == 0) {
      batch_.record_first_hit(v, e.hit.t, path.slot, events);
      if (scene_.aovs.of_hits()) batch_.record_hit(e.hit, path.slot, hit);
    }
    if (last) continue;

    shading_timer_.lap(ShadingPart::kMaterials);
    if (guide_ != nullptr || recorder_ != nullptr) find_guide(e, events, depth);
    if (reuses(depth)) reuse_->at_surface(v, e.hit, e.roulette.y, e.guided, e.path, hit, depth, batch_);
    const Mask settled = settle(e.path, v, e.hit.t, hit, depth);
    sample_one_light(e, events, settled, depth);
    shading_timer_.lap(ShadingPart::kPaths);
    scatter_path(e, and_not(events, settled), depth, kept);
    shading_timer_.lap(ShadingPart::kPaths);
    shading_timer_.share(v.surface.material, hit);
  }
  alive_ = kept;
}

void Wavefront::find_guide(Event& e, Mask events, int depth) {
  const Vertex& v = e.vertex;
  const Mask lanes = guidable(v, events);
  const UInt key = hash(batch_.key(e.path.slot, events), UInt(static_cast<std::uint32_t>(depth)));
  e.cells = guide_cells_at(v.surface.p, face_forward(v.at.frame.z, v.wo),
                           {to_unit_float(key), to_unit_float(hash(key))});
  if (guide_ != nullptr) e.guided = guide_->at(e.cells, lanes);
}

void Wavefront::add_environment(const Event& e, Mask missed, int depth) {
  const Vec3 direction = e.path.direction;
  Spectrum sum(0.0f);
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Spectrum radiance = environment_radiance(scene_.lights, light, e.reference.p, direction, missed);
    Float weight(1.0f);
    const Mask weighed = missed & (e.path.pdf > 0.0f);
    if (any(weighed)) {
      const Float pdf =
          light_pdf(scene_.lights, Int(light), e.reference, direction, e.reference.p, direction, weighed) *
          pick_pmf(scene_.lights, Int(light), e.reference, weighed);
      weight = select(weighed, power_heuristic(e.path.pdf, pdf), weight);
      if (reuses(depth) && shares_sky())
        weight = select(reuse_->share_emission(e.path, radiance, pdf, weighed, depth), 0.0f, weight);
    }
    sum += radiance * weight;
    if (tells_layers(scene_)) {
      const Int layers = layers_at_light(scene_.layers, e.path.layer_state, Int(light), missed);
      batch_.add_to_layers(radiance * weight * e.path.beta, layers, e.path.slot, missed);
    }
  }
  batch_.add_radiance(sum * e.path.beta, e.path.slot, missed);
}

void Wavefront::add_emission(const Event& e, Mask hit, int depth) {
  const Surface& surface = e.vertex.surface;
  const Mask lit = hit & (surface.light >= 0);
  if (none(lit)) return;
  Spectrum radiance = emitted_radiance(scene_.lights, surface.light, surface, e.vertex.wo, lit);
  const Mask weighed = lit & (e.path.pdf > 0.0f);
  if (any(weighed)) {
    const Float pdf = light_pdf(scene_.lights, surface.light, e.reference, e.path.direction, surface.p,
                                surface.ng, weighed) *
                      pick_pmf(scene_.lights, surface.light, e.reference, weighed);
    Float weight = select(weighed, power_heuristic(e.path.pdf, pdf), 1.0f);
    if (reuses(depth) && shares_lamps()) {
      const Mask lanes = and_not(weighed, has_interpolated_normals(scene_.lights, surface.light, weighed));
      weight = select(reuse_->share_emission(e.path, radiance, pdf, lanes, depth), 0.0f, weight);
    }
    radiance *= weight;
  }
  if (scene_.lights.any_interpolated) {
    const Float distance = length(surface.p - e.reference.p);
    radiance *= interpolated_normal_factor(scene_.lights, surface.light, surface, e.vertex.wo, distance,
                                           e.path.pdf, lit);
  }
  batch_.add_radiance(radiance * e.path.beta, e.path.slot, lit);
  if (tells_layers(scene_)) {
    const Int layers = layers_at_light(scene_.layers, e.path.layer_state, surface.light, lit);
    batch_.add_to_layers(radiance * e.path.beta, layers, e.path.slot, lit);
  }
}

void Wavefront::sample_one_light(const Event& e, Mask events, Mask settled, int depth) {
  const Vertex& v = e.vertex;
  const Mask wanted = joinable(v, events);
  if (!samples_lights(scene_.lights) || none(wanted)) return;

  Receiver here = receiver_at(scene_, v);
  here.roughly = depth >= kFirstRoughEvent && !scene_.volumetric;
  const Vec2 point = e.sampler.get_2d(e.first_pair + dimension::kLightPoint);
  const auto [choice, light] = choose_light(scene_.lights, here, point, e.choice.x, wanted);
  shading_timer_.lap(ShadingPart::kLights);
  const Mask reachable = choice.picked & light.valid;
  if (none(reachable)) return;
  BsdfEval bsdf = eval_scattering(scene_, v, light.wi, reachable);
  if (guide_ != nullptr) bsdf.pdf = mixed_pdf(*guide_, e.guided, light.wi, bsdf.pdf, reachable);

  shading_timer_.lap(ShadingPart::kMaterials);
  const Float pdf = light.pdf * choice.pmf;
  const Float weight = select(light.delta | settled, Float(1.0f), power_heuristic(pdf, bsdf.pdf));
  Spectrum contribution = e.path.beta * bsdf.f_cos * light.radiance * (weight / select(reachable, pdf, 1.0f));
  if (scene_.lights.any_interpolated) {
    contribution *=
        interpolated_normal_factor(scene_.lights, choice.light, v.surface.p, light, bsdf.pdf, reachable);
  }
  if (reuses(depth) && shares_lamps()) {
    Mask lanes = and_not(reachable, has_interpolated_normals(scene_.lights, choice.light, reachable));
    if (!shares_sky()) {
      const Int kind = kind_of(scene_.lights, choice.light, reachable);
      lanes = and_not(lanes, kind == static_cast<std::int32_t>(LightKind::kInfinite));
    }
    const Mask shared = reuse_->share_light(e.path.slot, light.wi, pdf, light.delta, lanes, depth, batch_);
    contribution = select(shared, light.radiance, contribution);
  }
  const Mask shines = and_not(reachable, is_black(contribution));

  // From the offset origin to the point just before the light: the offset of a large surface may exceed the
  // light's own margin, and would then make the light shadow itself.
  WideConnection ray = connect(scene_, v, light.wi, fma(light.wi, light.distance, v.surface.p), shines);
  ray.contribution = contribution;
  ray.slot = e.path.slot;
  if (scene_.volumetric) ray.key = bit_cast<std::int32_t>(batch_.key(ray.slot, shines));
  if (tells_layers(scene_)) {
    const Int state = state_behind(e, light.wi, depth, shines);
    ray.layers = layers_at_light(scene_.layers, state, choice.light, shines);
    if (shadow_layers_) look_for_shadow(e, ray, state, choice.light, weight, depth, shines);
  }
  shadows_.size += append_at_end(scene_, ray, shines, shadows_, shadows_.size);
}

/// The state of the layers' automaton behind the vertex, for light that comes along `wi` and is scattered
/// there.
Int Wavefront::state_behind(const Event& e, Vec3 wi, int depth, Mask lanes) const {
  return state_after(scene_, e.vertex, e.path.layer_state, e.vertex.wo, wi, Mask::none(),
                     {e.sampler, depth, true}, lanes);
}

/// A sampled light tells all of its shadow, but that of the sky, of which some is not sampled: that is
/// weighed as light is.
void Wavefront::look_for_shadow(const Event& e, WideConnection ray, Int state, Int light, Float weight,
                                int depth, Mask shines) {
  const Mask sky = kind_of(scene_.lights, light, shines) == static_cast<std::int32_t>(LightKind::kInfinite);
  ray.contribution = ray.contribution * select(sky, 1.0f, inverse_of(weight));
  ray.layers = shadows_at_light(scene_.layers, state, light, shines);
  shadow_layers_->add(ray, shines, batch_, depth);
}

/// The other part of it: in the direction in which the path goes on.
void Wavefront::look_for_shadow_of_sky(const Event& e, const BsdfSample& bsdf, Spectrum beta, int depth,
                                       Mask lanes) {
  if (none(lanes)) return;
  const Vertex& v = e.vertex;
  const Int state = state_behind(e, bsdf.wi, depth, lanes);
  Receiver here = receiver_at(scene_, v);
  here.roughly = depth >= kFirstRoughEvent && !scene_.volumetric;
  WideConnection ray =
      connect(scene_, v, bsdf.wi, fma(bsdf.wi, Float(kInfiniteDistance), v.surface.p), lanes);
  ray.slot = e.path.slot;
  // Apart from the numbers on the way to sampled lights.
  if (scene_.volumetric) ray.key = bit_cast<std::int32_t>(hash(batch_.key(ray.slot, lanes) ^ 0x536b7921u));
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Float pdf = light_pdf(scene_.lights, Int(light), here, bsdf.wi, v.surface.p, bsdf.wi, lanes) *
                      pick_pmf(scene_.lights, Int(light), here, lanes);
    ray.contribution = environment_radiance(scene_.lights, light, v.surface.p, bsdf.wi, lanes) *
                       power_heuristic(bsdf.pdf, pdf) * beta;
    ray.layers = shadows_at_light(scene_.layers, state, Int(light), lanes);
    shadow_layers_->add(ray, lanes, batch_, depth);
  }
}

/// Keeps the density and the receiver of paths that pass clear glass, as rays to lights do: light behind it
/// is weighed as if it were not there. Within glass a negative density marks an odd number of reflections:
/// such a path leaves as if the glass as a whole had mirrored it, and light samples do not find its light.
void Wavefront::keep_reference(const Event& e, const BsdfSample& bsdf, Mask events, WidePath& next) const {
  const Vertex& v = e.vertex;
  const Mask bent = and_not(events & bsdf.specular, v.in_medium);
  if (none(bent)) return;
  const Mask glass = clear_glass_at(scene_, v.surface, e.path.direction, bent);
  const Mask inside = glass & (v.at.kind == static_cast<std::int32_t>(BsdfKind::kDielectric)) &
                      (dot(v.wo, v.at.frame.z) < 0.0f);
  const Mask mirrored = and_not(inside, bsdf.transmission), leaving = inside & bsdf.transmission;
  const Mask kept = mirrored | (glass & bsdf.transmission);
  const auto keep = [&](const auto& before, auto& now) { now = select(kept, before, now); };
  keep(select(mirrored, -e.path.pdf, select(leaving, max(e.path.pdf, 0.0f), e.path.pdf)), next.pdf);
  keep(e.path.reference, next.reference);
  if (scene_.lights.uses_normals) keep(e.path.normal, next.normal);
}

void Wavefront::scatter_path(const Event& e, Mask events, int depth, int& kept) {
  const Vertex& v = e.vertex;
  const Vec2 u = e.sampler.get_2d(e.first_pair + dimension::kBsdfDirection);
  GuidedSample sample;
  if (guide_ != nullptr) {
    sample = sample_guided(scene_, *guide_, e.guided, v, e.choice.y, u, events);
  } else {
    sample.bsdf = sample_scattering(scene_, v, e.choice.y, u, events);
    sample.bsdf_pdf = sample.bsdf.pdf;
  }
  const BsdfSample& bsdf = sample.bsdf;
  shading_timer_.lap(ShadingPart::kMaterials);
  WidePath next;
  next.origin = next.reference = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  next.beta = e.path.beta * bsdf.weight;
  next.pdf = select(bsdf.specular, Float(0.0f), bsdf.pdf);
  next.roulette_scale =
      select(bsdf.transmission, e.path.roulette_scale * sqr(bsdf.eta), e.path.roulette_scale);
  if (guide_ != nullptr) {
    // Roulette goes by what samples of the BSDF would have brought: those that follow the guide have little
    // throughput because there are many of them.
    const Mask guided = e.guided.followed & (sample.bsdf_pdf > 0.0f);
    next.roulette_scale *= select(guided, max(bsdf.pdf / sample.bsdf_pdf, 1.0f), 1.0f);
  }
  next.slot = e.path.slot;
  if (scene_.lights.uses_normals) next.normal = receiver_at(scene_, v).normal;
  next.time = v.time;
  if (scene_.volumetric) {
    next.medium = medium_behind(scene_.shapes, v.surface, bsdf.wi, v.medium, and_not(events, v.in_medium));
  }
  if (scene_.straight_shadows) keep_reference(e, bsdf, events, next);
  Mask alive = and_not(events & bsdf.valid, is_black(next.beta));
  if (tells_layers(scene_)) {
    next.layer_state = state_after(scene_, v, e.path.layer_state, v.wo, bsdf.wi, bsdf.specular,
                                   {e.sampler, depth, false}, alive);
    if (shadow_layers_)
      look_for_shadow_of_sky(e, bsdf, next.beta, depth, and_not(joinable(v, alive), bsdf.specular));
  }
  if (depth > kRouletteStart) {
    const Float number =
        scene_.any_mix ? e.roulette.x : e.sampler.get_2d(e.first_pair + dimension::kRoulette).x;
    const Mask spared = reuses(depth) ? reuse_->spared(next.slot, events, depth) : Mask::none();
    Spectrum raised = next.beta;
    const Mask survives = survive_roulette(raised, next.roulette_scale, number);
    next.beta = select(spared, next.beta, raised);
    alive &= survives | spared;
  }

  if (recorder_ != nullptr) {
    const Mask learnt = guidable(v, events) & bsdf.valid;
    recorder_->add(guide_, e.guided, e.cells, sample, e.path.beta, next.slot, learnt, alive);
  }

  // Entries are read 16 at a time, or sorted elsewhere, before they are overwritten, and never move up.
  kept += append_at_end(scene_, next, alive, paths_, kept);
}

}  // namespace tessera::render::TESSERA_ISA
