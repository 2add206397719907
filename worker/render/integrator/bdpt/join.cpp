// A vertex of 16 subpaths from the eye: lights that it has hit, lights that shine on it, vertices of subpaths
// from lights that it is joined to, and where it goes on.
#include "render/camera/camera.h"
#include "render/core/constants.h"
#include "render/integrator/bdpt/bidirectional.h"
#include "render/integrator/vcm/merging.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/integrator/vertex/light_choice.h"
#include "render/integrator/vertex/light_end.h"
#include "render/integrator/vertex/roulette.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen subpaths from the eye at the end of their latest segment.
struct Bidirectional::Event {
  int packet, depth;
  WidePath path;
  Hit hit;
  Receiver reference;  // where the path was last scattered
  Sampler sampler;
  int first_pair;          // of this event's dimensions
  PartialWeights weights;  // before arrive() as the path left its last vertex
  Vec2 choice;             // light, BSDF lobe
  Vec2 roulette;           // Russian roulette, mixed material
  Vertex vertex;

  Event(int packet_number, int event, const WidePath& wide_path, const Hit& found, const Sampler& numbers,
        const PartialWeights& sums)
      : packet(packet_number),
        depth(event),
        path(wide_path),
        hit(found),
        reference(wide_path.origin),
        sampler(numbers),
        first_pair(dimension::kFirstEvent + event * dimension::kPairsPerEvent),
        weights(sums) {}
};

namespace {

/// Subpaths end at random only after this many further events, as those of the path tracer do.
constexpr int kRouletteStart = 2;

}  // namespace

void Bidirectional::shade_packet(int packet, int depth) {
  const Mask active = frontier_.lanes(packet);
  const Int entry = frontier_.entries(packet);
  const WidePath path = frontier_.path(scene_, entry, active);
  Event e(packet, depth, path, frontier_.hit(entry, active), batch_.sampler(path.slot, active),
          weights_.load(packet));
  Vertex& v = e.vertex;
  v.wo = -path.direction;
  if (scene_.any_motion) e.hit.time = path.time;
  v.time = e.hit.time;
  if (scene_.volumetric) {
    e.reference.p = path.reference;
    v.medium = path.medium;
    v.in_medium = active & (e.hit.shape == kScatteredByMedium);
  }
  if (scene_.lights.uses_normals) e.reference.normal = path.normal;
  const Mask hit = active & (e.hit.shape >= 0), events = hit | v.in_medium;
  if (const Mask missed = and_not(active, events); any(missed)) add_environment(e, missed);
  if (none(events)) {
    frontier_.drop(packet);
    return;
  }
  v.surface = surface_at(scene_.shapes, e.hit, path.origin, path.direction, hit, scene_.any_tangents);
  add_emission(e, hit);
  const bool last = depth == scene_.max_depth;
  if (last && depth > 0) {
    frontier_.drop(packet);
    return;
  }
  e.roulette = e.sampler.get_2d(e.first_pair + dimension::kRoulette);
  e.choice = e.sampler.get_2d(e.first_pair + dimension::kChoice);
  interact(scene_, v.surface, v.wo, e.roulette.y, hit, v.at);
  if (any(v.in_medium)) put_into_medium(fma(path.direction, e.hit.t, path.origin), v.in_medium, v);
  if (scene_.any_opacity && !scene_.volumetric) {
    if (const Mask partly = partly_open(v, hit); any(partly))
      open_surface(scene_, e.sampler.get_2d(dimension::kOpacity + depth).x, partly, v);
  }
  if (depth == 0) {
    batch_.record_first_hit(v, e.hit.t, path.slot, events);
    if (scene_.aovs.id) batch_.record_ids(e.hit, path.slot, and_not(events, v.in_medium));
  }
  if (last) {
    frontier_.drop(packet);
    return;
  }
  arrive(e, events);
  const Mask wanted = joinable(v, events);
  sample_one_light(e, wanted);
  join_to_light_subpaths(e, wanted);
  if (merging_) merge(e, wanted);
  scatter(e, events);
}

void Bidirectional::queue(const Event& e, WideConnection ray, std::uint32_t salt, Mask shines) {
  if (joins_.size + kWidth > kBatch) {
    // Stages do not nest.
    shading_.reset();
    trace_joins(e.depth);
    shading_.emplace(stats_.times, Stage::kShading);
  }
  ray.slot = e.path.slot;
  if (scene_.volumetric) ray.key = bit_cast<std::int32_t>(hash(batch_.key(e.path.slot, shines) ^ salt));
  joins_.size += append(scene_, ray, shines, joins_, joins_.size);
}

void Bidirectional::add_environment(const Event& e, Mask missed) {
  if (!filter_.wants(0, e.depth + 2)) return;
  const Vec3 direction = e.path.direction;
  Spectrum sum(0.0f);
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Spectrum radiance = environment_radiance(scene_.lights, light, e.reference.p, direction, missed);
    const auto weight = [&] {
      const Float pdf = sampling_density(scene_.lights, Int(light), e.reference, direction, e.reference.p,
                                         direction, missed);
      return light_end(scene_.lights, Int(light), pdf, e.reference.p, Float(1.0f), -direction, Float(1.0f),
                       missed)
          .hit_weight(e.weights);
    };
    sum += radiance * (e.depth == 0 || !filter_.all() ? Float(1.0f) : weight());
  }
  batch_.add_radiance(sum * e.path.beta, e.path.slot, missed);
}

void Bidirectional::add_emission(const Event& e, Mask hit) {
  const Surface& surface = e.vertex.surface;
  const Mask lit = hit & (surface.light >= 0);
  if (none(lit) || !filter_.wants(0, e.depth + 2)) return;
  Spectrum radiance = emitted_radiance(scene_.lights, surface.light, surface, e.vertex.wo, lit);
  if (e.depth > 0 && filter_.all()) {
    const Float pdf = sampling_density(scene_.lights, surface.light, e.reference, e.path.direction, surface.p,
                                       surface.ng, lit);
    const LightEnd end = light_end(scene_.lights, surface.light, pdf, surface.p, dot(surface.ng, e.vertex.wo),
                                   e.vertex.wo, length_squared(surface.p - e.reference.p), lit);
    radiance *= end.hit_weight(e.weights);
  }
  batch_.add_radiance(radiance * e.path.beta, e.path.slot, lit);
}

void Bidirectional::arrive(Event& e, Mask hit) const {
  const Vertex& v = e.vertex;
  const Float cosine = cosine_at(v, v.wo);
  if (e.depth > 0) {
    e.weights.arrive(length_squared(v.surface.p - e.reference.p), cosine);
    return;
  }
  e.weights = {Float(0.0f), Float(0.0f)};
  if (!sees_points(scene_.camera)) return;
  // Joining the vertex to the same point of the lens would find it so many times a pass.
  const CameraConnection eye =
      connect_to_camera(scene_.camera, v.surface.p, e.sampler.get_2d(dimension::kLens), v.time, hit);
  e.weights.last = power(lights_.paths_a_pass() / max(eye.importance * cosine, 1e-30f));
}

void Bidirectional::sample_one_light(const Event& e, Mask wanted) {
  if (!samples_lights(scene_.lights) || none(wanted) || !filter_.wants(1, e.depth + 2)) return;
  const Vertex& v = e.vertex;
  const LightChoice choice =
      choose_light(scene_.lights, receiver_at(scene_, v),
                   e.sampler.get_2d(e.first_pair + dimension::kLightPoint), e.choice.x, wanted);
  const LightSample& light = choice.sample;
  const Mask reachable = choice.pick.picked & light.valid;
  if (none(reachable)) return;
  const BsdfEval bsdf = eval_scattering(scene_, v, light.wi, reachable);
  const Float pdf = light.pdf * choice.pick.pmf;
  const Spectrum unweighted =
      e.path.beta * bsdf.f_cos * light.radiance * (1.0f / select(reachable, pdf, 1.0f));
  const Mask shines = and_not(reachable, is_black(unweighted));
  if (none(shines)) return;

  const Vec3 point = fma(light.wi, light.distance, v.surface.p);
  const Float weight = weight_unless_alone([&] {
    const LightEnd end = light_end(scene_.lights, choice.pick.light, pdf, point, light.cosine, -light.wi,
                                   sqr(light.distance), shines);
    return end.sampling_weight(e.weights, cosine_at(v, light.wi), bsdf.pdf, back_density(e, light.wi, shines),
                               lights_.merged_at(v));
  });
  WideConnection ray = connect(scene_, v, light.wi, point, shines);
  ray.contribution = unweighted * weight;
  queue(e, ray, 0, shines);
}

Float Bidirectional::back_density(const Event& e, Vec3 from, Mask active) const {
  // From the first vertex a path from the light can only go on to the lens, which chance never finds.
  if (e.depth == 0) return Float(0.0f);
  return eval_scattering(scene_, e.vertex, from, e.vertex.wo, active, Transport::kImportance).pdf;
}

void Bidirectional::join_to_light_subpaths(const Event& e, Mask wanted) {
  if (none(wanted)) return;
  // Events are as many as both sides have.
  const int events = std::min(lights_.events(), scene_.max_depth - 1 - e.depth);
  for (int event = 0; event < events; ++event) {
    const LightVertex* const y = lights_.at(event, e.packet);
    if (y == nullptr) break;
    if (const Mask both = wanted & y->joinable; any(both) && filter_.wants(event + 2, e.depth + 2))
      join(e, *y, event, both);
  }
}

void Bidirectional::join(const Event& e, const LightVertex& y, int event, Mask wanted) {
  const Vertex &z = e.vertex, &x = y.vertex;
  const Vec3 to_light = x.surface.p - z.surface.p;
  const Float distance_squared = length_squared(to_light);
  const Mask apart = wanted & (distance_squared > 0.0f);
  const Float inverse_square = 1.0f / select(apart, distance_squared, 1.0f);
  const Vec3 w = to_light * sqrt(inverse_square);
  const BsdfEval at_eye = eval_scattering(scene_, z, w, apart);
  const BsdfEval at_light = eval_scattering(scene_, x, -w, x.wo, apart);
  const Spectrum unweighted = e.path.beta * at_eye.f_cos * y.beta * at_light.f_cos *
                              (adjoint_ratio(x, w) * inverse_square * lights_.paths_a_pass());
  const Mask shines = and_not(apart & is_finite(unweighted), is_black(unweighted));
  if (none(shines)) return;

  const Float weight = weight_unless_alone([&] {
    const Float forward = eval_scattering(scene_, x, x.wo, -w, shines, Transport::kImportance).pdf;
    const Float from_light =
        y.weights.ways(at_eye.pdf * cosine_at(x, w) * inverse_square, at_light.pdf, lights_.merged_at(x));
    const Float from_eye = e.weights.ways(forward * cosine_at(z, w) * inverse_square,
                                          back_density(e, w, shines), lights_.merged_at(z));
    return weight_of_way(from_light, from_eye);
  });
  WideConnection ray =
      connect(scene_, z, w, select(x.in_medium, x.surface.p, offset_origin(x.surface, -w)), shines);
  ray.contribution = unweighted * weight;
  queue(e, ray, join_salt(event), and_not(shines, is_black(ray.contribution)));
}

void Bidirectional::merge(const Event& e, Mask wanted) {
  const Mask merges = and_not(wanted, e.vertex.in_medium);
  if (none(merges) || !filter_.all()) return;
  const Spectrum light = merging_->gather(e.vertex, e.weights, e.depth, merges);
  batch_.add_radiance(light * e.path.beta, e.path.slot, merges);
}

void Bidirectional::scatter(const Event& e, Mask hit) {
  const Vertex& v = e.vertex;
  const Vec2 u = e.sampler.get_2d(e.first_pair + dimension::kBsdfDirection);
  const BsdfSample bsdf = sample_scattering(scene_, v, e.choice.y, u, hit);
  WidePath next = e.path;
  next.origin = next.reference = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  next.beta = e.path.beta * bsdf.weight;
  next.roulette_scale =
      select(bsdf.transmission, e.path.roulette_scale * sqr(bsdf.eta), e.path.roulette_scale);
  if (scene_.lights.uses_normals) next.normal = receiver_at(scene_, v).normal;
  if (scene_.volumetric)
    next.medium = medium_behind(scene_.shapes, v.surface, bsdf.wi, v.medium, and_not(hit, v.in_medium));
  Mask alive = and_not(hit & bsdf.valid, is_black(next.beta));
  if (e.depth > kRouletteStart) alive &= survive_roulette(next.beta, next.roulette_scale, e.roulette.x);

  const Float back = back_density(e, bsdf.wi, and_not(alive, bsdf.specular));
  weights_.store(
      e.weights.scattered(cosine_at(v, bsdf.wi), bsdf.pdf, back, lights_.merged_at(v), bsdf.specular),
      e.packet);
  frontier_.replace(scene_, e.packet, next, alive);
}

}  // namespace tessera::render::TESSERA_ISA
