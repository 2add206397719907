// A vertex of 16 subpaths from the eye: lights that it has hit, lights that shine on it, vertices of subpaths
// from lights that it is joined to, and where it goes on.
#include "render/core/constants.h"
#include "render/transport/bdpt/bidirectional.h"
#include "render/transport/bdpt/merging.h"
#include "render/transport/bdpt/ways.h"
#include "render/transport/vertex/encounter.h"
#include "render/transport/vertex/ghost_light.h"
#include "render/transport/vertex/layers.h"
#include "render/transport/vertex/roulette.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen subpaths from the eye at the end of their latest segment.
struct Bidirectional::Event : Encounter {
  int packet;
  PartialWeights weights;  // before arrive_at() as the path left its last vertex

  Event(const SceneTables& scene, const WidePath& paths, const Hit& hits, const Sampler& sampler, int event,
        Mask active, int packet_number, const PartialWeights& sums)
      : Encounter(scene, paths, hits, sampler, event, active), packet(packet_number), weights(sums) {}
};

void Bidirectional::shade_packet(int packet, int depth) {
  const Mask active = frontier_.lanes(packet);
  const Int entry = frontier_.entries(packet);
  const WidePath path = frontier_.path(scene_, entry, active);
  Event e(scene_, path, frontier_.hit(entry, active), batch_.sampler(path.slot, active), depth, active,
          packet, weights_.load(packet));
  if (any(e.missed)) add_environment(e, e.missed);
  if (none(e.met)) {
    frontier_.drop(packet);
    return;
  }
  e.find_surface(scene_, e.on_surface);
  add_emission(e, e.on_surface);
  const bool last = depth == scene_.max_depth;
  if (last && depth > 0) {
    frontier_.drop(packet);
    return;
  }
  e.find_scattering(scene_);
  disperse_at(scene_, e.vertex, e.met, e.path);
  e.choice = e.random(dimension::kChoice);
  const Vertex& v = e.vertex;
  if (depth == 0) batch_.record_first_hit(v, e.hit, path.slot, e.met);
  if (last) {
    frontier_.drop(packet);
    return;
  }
  e.weights = arrive_at(scene_, v, depth, e.reference.p, e.numbers.get_2d(dimension::kLens),
                        e.path.wavelengths, lights_.paths_a_pass(), e.weights, e.met);
  const Mask wanted = joinable(v, e.met);
  sample_one_light(e, wanted);
  join_to_light_subpaths(e, wanted);
  if (merging_) merge(e, wanted);
  scatter(e, e.met);
}

void Bidirectional::queue(const Event& e, WideConnection ray, std::uint32_t salt, Mask shines) {
  if (joins_.size + kWidth > kBatch) {
    // Stages do not nest.
    shading_.reset();
    trace_joins(e.depth);
    shading_.emplace(stats_.times, Stage::kShading);
  }
  ray.slot = e.path.slot;
  if (scene_.volumetric) {
    ray.key = bit_cast<std::int32_t>(hash(batch_.key(e.path.slot, shines) ^ salt));
    ray.wavelengths = e.path.wavelengths;
  }
  joins_.size += append(scene_, ray, shines, joins_, joins_.size);
}

Float Bidirectional::weight_of_sky(const Event& e, std::int32_t light, Mask missed) const {
  const Vec3 direction = e.path.direction;
  if (e.depth == 0) {
    return weight_against_ghost_light(scene_, e.path.pdf, e.reference, direction, Int(light), e.reference.p,
                                      direction, missed);
  }
  if (!filter_.all()) return Float(1.0f);
  return weight_of_hit(scene_, e.weights, e.reference, direction, Int(light), missed);
}

void Bidirectional::add_environment(const Event& e, Mask missed) {
  if (!filter_.wants(0, e.depth + 2)) return;
  const Vec3 direction = e.path.direction;
  Spectrum sum(0.0f);
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Spectrum radiance =
        environment_light(scene_, spectra_of(scene_, e.path), light, e.reference, direction, missed);
    const Spectrum weighed = radiance * weight_of_sky(e, light, missed);
    sum += weighed;
    if (tells_layers(scene_)) add_to_layers_of_hits(e, weighed, radiance, Int(light), missed);
  }
  batch_.add_radiance(sum * e.path.beta, e.path.slot, missed);
}

void Bidirectional::add_emission(const Event& e, Mask hit) {
  const Surface& surface = e.vertex.surface;
  const Mask lit = hit & (surface.light >= 0);
  if (none(lit) || !filter_.wants(0, e.depth + 2)) return;
  const Spectrum unweighted = emitted_light(scene_, spectra_of(scene_, e.path), surface, e.vertex.wo, lit);
  Spectrum radiance = unweighted;
  if (e.depth == 0) {
    radiance *= weight_against_ghost_light(scene_, e.path.pdf, e.reference, e.path.direction, surface.light,
                                           surface.p, surface.ng, lit);
  } else if (filter_.all()) {
    radiance *=
        weight_of_hit(scene_, e.weights, e.reference, e.path.direction, surface.light, surface.p, surface.ng,
                      dot(surface.ng, e.vertex.wo), length_squared(surface.p - e.reference.p), lit);
  }
  batch_.add_radiance(radiance * e.path.beta, e.path.slot, lit);
  if (tells_layers(scene_)) add_to_layers_of_hits(e, radiance, unweighted, surface.light, lit);
}

Int Bidirectional::layers_of_way(const Event& e, int s) const {
  return Int(layers_of_strategy(scene_.layers, s, e.depth + 2));
}

void Bidirectional::add_to_layers_of_hits(const Event& e, Spectrum light, Spectrum unweighted,
                                          Int light_number, Mask lanes) {
  const Int layers = layers_at_light(scene_.layers, e.path.layer_state, light_number, lanes);
  batch_.add_to_layers(light * e.path.beta, unweighted * e.path.beta, layers & layers_of_way(e, 0),
                       e.path.slot, lanes);
}

EyeVertex Bidirectional::eye_vertex(const Event& e) const {
  return {e.vertex,
          e.weights,
          e.path.beta,
          e.depth,
          lights_.merged_at(e.vertex),
          e.path.dispersed,
          spectra_of(scene_, e.path)};
}

void Bidirectional::sample_one_light(const Event& e, Mask wanted) {
  if (!samples_lights(scene_.lights) || none(wanted) || !filter_.wants(1, e.depth + 2)) return;
  const LightChoice choice = choose_light(scene_.lights, receiver_at(scene_, e.vertex),
                                          e.random(dimension::kLightPoint), e.choice.x, wanted);
  WayLight way = light_of(scene_, eye_vertex(e), choice, filter_.all());
  if (none(way.shines)) return;
  way.ray.contribution = way.unweighted * way.weight;
  if (tells_layers(scene_)) {
    const Int state = state_after_join(e, way.w, way.shines), light = choice.pick.light;
    way.ray.layers = layers_at_light(scene_.layers, state, light, way.shines) & layers_of_way(e, 1);
    if (scene_.layers.unweighted != 0) way.ray.inverse_weight = inverse_of(way.weight);
    if (shadow_layers_) look_for_shadow(e, way.ray, way.unweighted, state, light, way.shines);
  }
  queue(e, way.ray, 0, way.shines);
}

void Bidirectional::look_for_shadow(const Event& e, WideConnection ray, Spectrum light, Int state,
                                    Int light_number, Mask shines) {
  ray.contribution = light;
  ray.slot = e.path.slot;
  ray.layers = shadows_at_light(scene_.layers, state, light_number, shines);
  if (scene_.volumetric) {
    ray.key = bit_cast<std::int32_t>(batch_.key(e.path.slot, shines));
    ray.wavelengths = e.path.wavelengths;
  }
  shadow_layers_->add(ray, shines, batch_, e.depth);
}

Int Bidirectional::state_after_join(const Event& e, Vec3 wi, Mask active) const {
  return state_after(scene_, e.vertex, e.path.layer_state, e.vertex.wo, wi, Mask::none(),
                     {e.numbers, e.depth, true}, active);
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
  WayLight way = light_of(scene_, eye_vertex(e), y, lights_.paths_a_pass(), lights_.merged_at(y.vertex),
                          filter_.all(), wanted);
  if (none(way.shines)) return;
  way.ray.contribution = way.unweighted * way.weight;
  if (tells_layers(scene_)) {
    // Both subpaths have the numbers of the same sample.
    const Int from_light = light_state_after(scene_, y.vertex, y.layer_state, -way.w, y.vertex.wo,
                                             Mask::none(), light_lobe(e.numbers, event, true), way.shines);
    way.ray.layers =
        layers_of_join(scene_.layers, state_after_join(e, way.w, way.shines), from_light, way.shines) &
        layers_of_way(e, event + 2);
    if (scene_.layers.unweighted != 0) way.ray.inverse_weight = inverse_of(way.weight);
  }
  queue(e, way.ray, join_salt(event), and_not(way.shines, is_black(way.ray.contribution)));
}

void Bidirectional::merge(const Event& e, Mask wanted) {
  const Mask merges = and_not(wanted, e.vertex.in_medium);
  if (none(merges) || !filter_.all()) return;
  if (!tells_layers(scene_)) {
    const Spectrum light = merging_->gather(e.vertex, e.weights, e.depth, e.path.dispersed, merges, nullptr);
    batch_.add_radiance(light * e.path.beta, e.path.slot, merges);
    return;
  }
  GatheredLayers layers{scene_, e.path.layer_state, {e.numbers, e.depth, true}, {}};
  const Spectrum light = merging_->gather(e.vertex, e.weights, e.depth, e.path.dispersed, merges, &layers);
  batch_.add_radiance(light * e.path.beta, e.path.slot, merges);
  layers.sums.scale(e.path.beta);
  batch_.add_to_layers(layers.sums, e.path.slot, merges);
}

void Bidirectional::scatter(const Event& e, Mask hit) {
  const Vertex& v = e.vertex;
  EyeStep step =
      step_from_eye(scene_, eye_vertex(e), e.path, e.choice.y, e.random(dimension::kBsdfDirection), hit);
  WidePath& next = step.next;
  if (tells_layers(scene_)) {
    next.layer_state = state_after(scene_, v, e.path.layer_state, v.wo, next.direction, step.specular,
                                   {e.numbers, e.depth, false}, step.alive);
  }
  if (e.depth > kRouletteStart)
    step.alive &= survive_roulette(next.beta, next.roulette_scale, e.roulette_number(scene_));
  weights_.store(step.weights, e.packet);
  frontier_.replace(scene_, e.packet, next, step.alive);
}

}  // namespace tessera::render::TESSERA_ISA
