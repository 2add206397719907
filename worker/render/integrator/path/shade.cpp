// One scattering event of 16 paths: what the ray met, what shines on it, where the path goes on.
#include "render/core/constants.h"
#include "render/integrator/interaction.h"
#include "render/integrator/path/wavefront.h"
#include "render/light/light.h"
#include "render/sampling/discrete.h"
#include "render/sampling/sampler.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen paths at the end of their latest segment.
struct Wavefront::Vertex {
  Vec3 origin, direction;
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

/// Power heuristic with exponent 2 [Veach 1997], for one sample of each strategy.
Float power_heuristic(Float pdf, Float other) {
  const Float a = sqr(pdf), b = sqr(other);
  // Overflowing squares: the larger density wins outright.
  return select(is_finite(a + b), a / max(a + b, 1e-38f), select(pdf > other, Float(1.0f), Float(0.0f)));
}

}  // namespace

void Wavefront::shade(int depth) {
  int kept = 0;
  const int first_pair = dimension::kFirstBounce + depth * dimension::kPairsPerBounce;
  for (int i = 0; i < alive_; i += kWidth) {
    const Mask active = Mask::first(alive_ - i);
    Vertex v(paths_, hits_, samples_, scene_.sampler.kind, first_pair, i, active);

    const Mask hit = active & (v.hit.shape >= 0);
    const Mask missed = and_not(active, hit);
    if (any(missed) && !scene_.lights.infinite_lights.empty()) add_environment(v, missed);
    if (none(hit)) continue;

    v.surface = surface_at(scene_.shapes, v.hit, v.origin, v.direction, hit, scene_.any_tangents);
    add_emission(v, hit);
    const bool last = depth == scene_.max_depth;
    if (last && depth > 0) continue;
    v.roulette = v.sampler.get_2d(first_pair + dimension::kRoulette);
    v.choice = v.sampler.get_2d(first_pair + dimension::kChoice);
    v.at = interact(scene_, v.surface, v.roulette.y, hit);
    if (depth == 0) record_first_hit(v, hit);
    if (last) continue;

    sample_one_light(v, hit);
    scatter_path(v, hit, depth, kept);
  }
  alive_ = kept;
}

void Wavefront::add_environment(const Vertex& v, Mask missed) {
  Spectrum sum(0.0f);
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Spectrum radiance = environment_radiance(scene_.lights, light, v.direction, missed);
    Float weight(1.0f);
    const Mask weighed = missed & (v.pdf > 0.0f);
    if (any(weighed)) {
      const Float pdf = light_pdf(scene_.lights, Int(light), v.origin, v.direction, v.origin, v.direction, weighed) *
                        scene_.lights.selection.pmf[light];
      weight = select(weighed, power_heuristic(v.pdf, pdf), weight);
    }
    sum += radiance * weight;
  }
  sum *= v.beta;
  for (int c = 0; c < kSpectrumLanes; ++c) {
    float* radiance = samples_.radiance.c[c];
    scatter(gather(radiance, v.slot, missed) + sum.c[c], radiance, v.slot, missed);
  }
}

void Wavefront::add_emission(const Vertex& v, Mask hit) {
  const Mask lit = hit & (v.surface.light >= 0);
  if (none(lit)) return;
  Spectrum radiance = emitted_radiance(scene_.lights, v.surface.light, v.surface.ng, -v.direction, lit);
  const Mask weighed = lit & (v.pdf > 0.0f);
  if (any(weighed)) {
    const Float pdf = light_pdf(scene_.lights, v.surface.light, v.origin, v.direction, v.surface.p, v.surface.ng, weighed) *
                      gather(scene_.lights.selection.pmf.data(), v.surface.light, weighed);
    radiance *= select(weighed, power_heuristic(v.pdf, pdf), 1.0f);
  }
  radiance *= v.beta;
  for (int c = 0; c < kSpectrumLanes; ++c) {
    float* sum = samples_.radiance.c[c];
    scatter(gather(sum, v.slot, lit) + radiance.c[c], sum, v.slot, lit);
  }
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

void Wavefront::sample_one_light(const Vertex& v, Mask hit) {
  const Mask wanted = hit & ((v.at.flags & kAllDelta) == 0);
  if (scene_.lights.lights.empty() || none(wanted)) return;

  const DiscreteSample choice = sample_discrete(scene_.lights.selection, v.choice.x, wanted);
  const LightSample light = sample_light(scene_.lights, choice.index, v.surface.p,
                                         v.sampler.get_2d(v.first_pair + dimension::kLightPoint), wanted);
  const Mask reachable = wanted & light.valid;
  if (none(reachable)) return;
  const BsdfEval bsdf = eval_bsdf(v.at, -v.direction, light.wi, reachable);

  const Float pdf = light.pdf * choice.pmf;
  const Float weight = select(light.delta, Float(1.0f), power_heuristic(pdf, bsdf.pdf));
  const Spectrum contribution = v.beta * bsdf.f_cos * light.radiance * (weight / select(reachable, pdf, 1.0f));
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
  shadows_.size += count(shines);
}

void Wavefront::scatter_path(const Vertex& v, Mask hit, int depth, int& kept) {
  const BsdfSample bsdf = sample_bsdf(v.at, -v.direction, v.choice.y,
                                      v.sampler.get_2d(v.first_pair + dimension::kBsdfDirection), hit);
  Spectrum beta = v.beta * bsdf.weight;
  const Float eta_scale = select(bsdf.transmission, v.eta_scale * sqr(bsdf.eta), v.eta_scale);
  Mask alive = and_not(hit & bsdf.valid, is_black(beta));

  // Russian roulette on what the path can still bring, refraction's scaling set aside.
  if (depth > 1) {
    const Float survival = clamp((beta * eta_scale).max_component(), 0.05f, 1.0f);
    alive &= v.roulette.x < survival;
    beta *= 1.0f / survival;
  }

  // Entries are read 16 at a time before they are overwritten, and never move up.
  paths_.origin.append(offset_origin(v.surface, bsdf.wi), alive, kept);
  paths_.direction.append(bsdf.wi, alive, kept);
  paths_.beta.append(beta, alive, kept);
  compress_store(select(bsdf.specular, Float(0.0f), bsdf.pdf), alive, paths_.pdf + kept);
  compress_store(eta_scale, alive, paths_.eta_scale + kept);
  compress_store(v.slot, alive, paths_.slot + kept);
  kept += count(alive);
}

}  // namespace tessera::render::TESSERA_ISA
