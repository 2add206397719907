// One scattering event of 16 paths: what the ray met, what shines on it, where the path goes on.
#include "render/core/constants.h"
#include "render/integrator/interaction.h"
#include "render/integrator/passing.h"
#include "render/integrator/path/wavefront.h"
#include "render/light/interpolated_normal.h"
#include "render/light/pick.h"
#include "render/medium/medium.h"
#include "render/sampling/sampler.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen paths at the end of their latest segment.
struct Wavefront::Vertex {
  Vec3 origin, direction;
  Receiver reference;             // where the path was last scattered
  Int medium = Int(-1);           // that the path came through; only in volumetric scenes
  Mask in_medium = Mask::none();  // scattered by it
  Spectrum beta;
  Float pdf, eta_scale;
  Int slot;
  Hit hit;
  Sampler sampler;
  int first_pair;  // of this event's dimensions
  // Once something was hit
  Surface surface;
  Vec2 roulette;  // Russian roulette, mixed material
  Vec2 choice;    // light, BSDF lobe
  Interaction at;

  Vertex(const PathState& paths, const HitState& hits, const SampleState& samples, SamplerKind kind, int pair, int i,
         Mask active)
      : origin(paths.origin.load(i)),
        direction(paths.direction.load(i)),
        reference(origin),
        beta(paths.beta.load(i)),
        pdf(Float::load(paths.pdf + i)),
        eta_scale(Float::load(paths.eta_scale + i)),
        slot(Int::load(paths.slot + i)),
        hit{Float::load(hits.t + i),       Float::load(hits.u + i),   Float::load(hits.v + i),
            Int::load(hits.primitive + i), Int::load(hits.shape + i), Int::load(hits.instance + i)},
        sampler(kind, gather(samples.pixel_hash, slot, active), gather(samples.reversed_sample, slot, active)),
        first_pair(pair) {}
};

namespace {

/// Paths end at random only after this many further events, and once their throughput is below the inverse of
/// kRouletteCaution. Measured: docs/decisions/0006-media-and-passing.md.
constexpr int kRouletteStart = 3;
constexpr float kRouletteCaution = 2;

/// At this event and later ones, lights are sampled roughly (measured: docs/decisions/0012-lights.md). Not in media,
/// whose points come arbitrarily close to lamps.
constexpr int kFirstRoughEvent = 2;

/// Power heuristic with exponent 2 [Veach 1997], for one sample of each strategy.
Float power_heuristic(Float pdf, Float other) {
  const Float a = sqr(pdf), b = sqr(other);
  // Overflowing squares: the larger density wins outright.
  return select(is_finite(a + b), a / max(a + b, 1e-38f), select(pdf > other, Float(1.0f), Float(0.0f)));
}

}  // namespace

void Wavefront::shade(int depth) {
  const StageTimer timer(stats_.times, Stage::kShading);
  shading_timer_.start();
  // Few paths fill few packets, in whatever order.
  constexpr int kLeastToSort = 4 * kWidth;
  const bool sort = scene_.shading_groups > 0 && alive_ >= kLeastToSort;
  if (sort) sort_by_group();
  const PathState& paths = sort ? sorted_.paths : paths_;
  const HitState& hits = sort ? sorted_.hits : hits_;
  int kept = 0;
  const int first_pair = dimension::kFirstBounce + depth * dimension::kPairsPerBounce;
  for (int i = 0; i < alive_; i += kWidth) {
    const Mask active = Mask::first(alive_ - i);
    Vertex v(paths, hits, samples_, scene_.sampler.kind, first_pair, i, active);

    const Mask hit = active & (v.hit.shape >= 0);
    if (scene_.volumetric) {
      v.reference.p = paths.reference.load(i);
      v.medium = Int::load(paths.medium + i);
      v.in_medium = active & (v.hit.shape == kScatteredByMedium);
    }
    if (scene_.any_motion) v.hit.time = Float::load(paths.time + i);
    if (scene_.lights.uses_normals) v.reference.normal = paths.normal.load(i);
    v.reference.roughly = depth - 1 >= kFirstRoughEvent && !scene_.volumetric;
    const Mask events = hit | v.in_medium;
    const Mask missed = and_not(active, events);
    if (any(missed) && !scene_.lights.infinite_lights.empty()) add_environment(v, missed);
    if (none(events)) continue;

    v.surface = surface_at(scene_.shapes, v.hit, v.origin, v.direction, hit, scene_.any_tangents);
    add_emission(v, hit);
    shading_timer_.lap(ShadingPart::kSurfaces);
    const bool last = depth == max_depth_;
    if (last && depth > 0) continue;
    if (depth > kRouletteStart || scene_.any_mix) {
      v.roulette = v.sampler.get_2d(first_pair + dimension::kRoulette);
    }
    v.choice = v.sampler.get_2d(first_pair + dimension::kChoice);
    interact(scene_, v.surface, -v.direction, v.roulette.y, hit, v.at);
    if (any(v.in_medium)) {
      // A point without a surface: nothing to offset from, and the medium's phase function in place of a BSDF.
      v.surface.p = select(v.in_medium, v.origin + v.direction * v.hit.t, v.surface.p);
      v.at.flags = select(v.in_medium, Int(0), v.at.flags);
    }
    if (scene_.any_opacity && !scene_.volumetric) make_partly_opaque(v, hit, depth);  // else transit() has seen to it
    if (depth == 0) record_first_hit(v, events);
    if (last) continue;

    shading_timer_.lap(ShadingPart::kMaterials);
    sample_one_light(v, events, depth);
    shading_timer_.lap(ShadingPart::kPaths);
    scatter_path(v, events, depth, kept);
    shading_timer_.lap(ShadingPart::kPaths);
    shading_timer_.share(v.surface.material, hit);
  }
  alive_ = kept;
}

void Wavefront::add_environment(const Vertex& v, Mask missed) {
  Spectrum sum(0.0f);
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Spectrum radiance = environment_radiance(scene_.lights, light, v.reference.p, v.direction, missed);
    Float weight(1.0f);
    const Mask weighed = missed & (v.pdf > 0.0f);
    if (any(weighed)) {
      const Float pdf =
          light_pdf(scene_.lights, Int(light), v.reference, v.direction, v.reference.p, v.direction, weighed) *
          pick_pmf(scene_.lights, Int(light), v.reference, weighed);
      weight = select(weighed, power_heuristic(v.pdf, pdf), weight);
    }
    sum += radiance * weight;
  }
  add_radiance(sum * v.beta, v.slot, missed);
}

void Wavefront::add_emission(const Vertex& v, Mask hit) {
  const Mask lit = hit & (v.surface.light >= 0);
  if (none(lit)) return;
  Spectrum radiance = emitted_radiance(scene_.lights, v.surface.light, v.surface, -v.direction, lit);
  const Mask weighed = lit & (v.pdf > 0.0f);
  if (any(weighed)) {
    const Float pdf =
        light_pdf(scene_.lights, v.surface.light, v.reference, v.direction, v.surface.p, v.surface.ng, weighed) *
        pick_pmf(scene_.lights, v.surface.light, v.reference, weighed);
    radiance *= select(weighed, power_heuristic(v.pdf, pdf), 1.0f);
  }
  if (scene_.lights.any_interpolated) {
    const Float distance = length(v.surface.p - v.reference.p);
    radiance *= interpolated_normal_factor(scene_.lights, v.surface.light, v.surface, -v.direction, distance, v.pdf, lit);
  }
  add_radiance(radiance * v.beta, v.slot, lit);
}

void Wavefront::record_first_hit(const Vertex& v, Mask hit) {
  scatter(Float(1.0f), samples_.coverage, v.slot, hit);
  if (scene_.aovs.depth) scatter(v.hit.t, samples_.depth, v.slot, hit);
  if (scene_.aovs.normal) {
    const Vec3 n = face_forward(v.at.frame.z, -v.direction);
    scatter(n.x, samples_.normal.x, v.slot, hit);
    scatter(n.y, samples_.normal.y, v.slot, hit);
    scatter(n.z, samples_.normal.z, v.slot, hit);
  }
  if (scene_.aovs.albedo) {
    const Spectrum albedo = albedo_of(v.at, hit);
    for (int c = 0; c < kSpectrumLanes; ++c) scatter(albedo.c[c], samples_.albedo.c[c], v.slot, hit);
  }
}

void Wavefront::make_partly_opaque(Vertex& v, Mask hit, int depth) {
  const Mask partly = hit & ((v.at.flags & kHasOpacity) != 0);
  if (none(partly)) return;
  const Float u = v.sampler.get_2d(dimension::kOpacity + depth).x;
  const Mask open = partly & (u >= opacity_of(scene_, v.at.material, v.surface, partly));
  v.at.kind = select(open, Int(static_cast<std::int32_t>(BsdfKind::kInterface)), v.at.kind);
  v.at.flags = select(open, Int(kAllDelta), v.at.flags);
}

Receiver Wavefront::receiver(const Vertex& v) const {
  if (!scene_.lights.uses_normals) return v.surface.p;
  const Mask one_way = and_not(reflects_only(v.at), v.in_medium);
  const Vec3 n = face_forward(v.at.frame.z, -v.direction);
  return {v.surface.p, {select_or_zero(one_way, n.x), select_or_zero(one_way, n.y), select_or_zero(one_way, n.z)}};
}

void Wavefront::sample_one_light(const Vertex& v, Mask events, int depth) {
  const Mask wanted = events & ((v.at.flags & kAllDelta) == 0);
  if (!samples_lights(scene_.lights) || none(wanted)) return;

  Receiver here = receiver(v);
  here.roughly = depth >= kFirstRoughEvent && !scene_.volumetric;
  // One pair for the light and the point on it stratifies the points over all lights together (measured:
  // docs/decisions/0010-bench.md), as long as the pick leaves enough of the number's 24 bits.
  constexpr std::size_t kMostTogether = 256;
  const bool together = scene_.lights.lights.size() <= kMostTogether;
  Vec2 point = v.sampler.get_2d(v.first_pair + dimension::kLightPoint);
  const LightPick choice = pick_light(scene_.lights, here, together ? point.x : v.choice.x, wanted);
  if (together) point.x = choice.u;
  const LightSample light = sample_light(scene_.lights, choice.light, here, point, choice.picked);
  shading_timer_.lap(ShadingPart::kLights);
  const Mask reachable = choice.picked & light.valid;
  if (none(reachable)) return;
  BsdfEval bsdf = eval_bsdf(v.at, -v.direction, light.wi, and_not(reachable, v.in_medium));
  const Mask in_medium = reachable & v.in_medium;
  if (any(in_medium)) {
    const Float phase = phase_value(scene_.media, v.medium, -v.direction, light.wi, in_medium);
    bsdf.f_cos = select(in_medium, Spectrum(phase), bsdf.f_cos);
    bsdf.pdf = select(in_medium, phase, bsdf.pdf);
  }

  shading_timer_.lap(ShadingPart::kMaterials);
  const Float pdf = light.pdf * choice.pmf;
  const Float weight = select(light.delta, Float(1.0f), power_heuristic(pdf, bsdf.pdf));
  Spectrum contribution = v.beta * bsdf.f_cos * light.radiance * (weight / select(reachable, pdf, 1.0f));
  if (scene_.lights.any_interpolated) {
    contribution *= interpolated_normal_factor(scene_.lights, choice.light, v.surface.p, light, bsdf.pdf, reachable);
  }
  const Mask shines = and_not(reachable, is_black(contribution));

  // From the offset origin to the point just before the light: the offset of a large surface may exceed the light's
  // own margin, and would then make the light shadow itself.
  const Vec3 origin = offset_origin(v.surface, light.wi);
  const Vec3 to_light = v.surface.p + light.wi * light.distance - origin;
  const Float distance = length(to_light);
  const int at = shadows_.size;
  shadows_.origin.append(origin, shines, at);
  shadows_.direction.append(to_light * (1.0f / max(distance, 1e-30f)), shines, at);
  compress_store(distance, shines, shadows_.distance + at);
  shadows_.contribution.append(contribution, shines, at);
  compress_store(v.slot, shines, shadows_.slot + at);
  if (scene_.any_motion) compress_store(v.hit.time, shines, shadows_.time + at);
  if (scene_.volumetric) {
    const Mask on_surface = and_not(shines, v.in_medium);
    compress_store(medium_behind(scene_.shapes, v.surface, light.wi, v.medium, on_surface), shines,
                   shadows_.medium + at);
  }
  shadows_.size += count(shines);
}

void Wavefront::scatter_path(const Vertex& v, Mask events, int depth, int& kept) {
  const Vec2 u = v.sampler.get_2d(v.first_pair + dimension::kBsdfDirection);
  Float u_lobe = v.choice.y;
  Mask hit = events;
  if (scene_.volumetric) {
    hit = and_not(events, v.in_medium);
    // Where light that passes does so in transit(), a sheet reflects what is left: 0 chooses that lobe.
    u_lobe = select((v.at.flags & kPassesStraight) != 0, Float(0.0f), u_lobe);
  }
  BsdfSample bsdf = sample_bsdf(v.at, -v.direction, u_lobe, u, hit);
  Int medium = v.medium;
  if (any(v.in_medium)) {
    const PhaseSample phase = sample_phase(scene_.media, v.medium, -v.direction, u, v.in_medium);
    bsdf.wi = select(v.in_medium, phase.wi, bsdf.wi);
    bsdf.weight = select(v.in_medium, Spectrum(1.0f), bsdf.weight);
    bsdf.pdf = select(v.in_medium, phase.pdf, bsdf.pdf);
    bsdf.valid |= v.in_medium;
    bsdf.specular = and_not(bsdf.specular, v.in_medium);
    bsdf.transmission = and_not(bsdf.transmission, v.in_medium);
  }
  shading_timer_.lap(ShadingPart::kMaterials);
  if (scene_.volumetric) medium = medium_behind(scene_.shapes, v.surface, bsdf.wi, v.medium, hit);
  Spectrum beta = v.beta * bsdf.weight;
  const Float eta_scale = select(bsdf.transmission, v.eta_scale * sqr(bsdf.eta), v.eta_scale);
  Mask alive = and_not(events & bsdf.valid, is_black(beta));

  // Russian roulette on what the path can still bring, refraction's scaling set aside.
  if (depth > kRouletteStart) {
    const Float survival = clamp((beta * eta_scale).max_component() * kRouletteCaution, 0.05f, 1.0f);
    alive &= v.roulette.x < survival;
    beta *= 1.0f / survival;
  }

  // Entries are read 16 at a time, or sorted elsewhere, before they are overwritten, and never move up.
  const Vec3 origin = offset_origin(v.surface, bsdf.wi);
  paths_.origin.append(origin, alive, kept);
  paths_.direction.append(bsdf.wi, alive, kept);
  paths_.beta.append(beta, alive, kept);
  compress_store(select(bsdf.specular, Float(0.0f), bsdf.pdf), alive, paths_.pdf + kept);
  compress_store(eta_scale, alive, paths_.eta_scale + kept);
  compress_store(v.slot, alive, paths_.slot + kept);
  if (scene_.lights.uses_normals) paths_.normal.append(receiver(v).normal, alive, kept);
  if (scene_.any_motion) compress_store(v.hit.time, alive, paths_.time + kept);
  if (scene_.volumetric) {
    paths_.reference.append(origin, alive, kept);
    compress_store(medium, alive, paths_.medium + kept);
  }
  kept += count(alive);
}

}  // namespace tessera::render::TESSERA_ISA
