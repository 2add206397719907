// The state of the layers' automaton on its way along paths: which event a vertex is, and which layers the
// light has that is found there. Nothing of it is asked where a job has no layers.
//
// Paths from the camera carry states of the automaton, paths from lights those of the reversed one. Where two
// are joined, or a photon is gathered, the pair of both states says which layers the whole path has: all that
// the one has read, and all that the other has, are known by them (layers_of_join).
#pragma once

#include <optional>
#include <vector>

#include "render/integrator/layer_table.h"
#include "render/sampling/sampler.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/layer_sums.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

TESSERA_INLINE bool tells_layers(const SceneTables& scene) { return scene.layers.count > 0; }

/// table[index]. Paths side by side are often alike, and one look-up costs less than sixteen.
TESSERA_INLINE Int look_up(const std::vector<std::int32_t>& table, Int index, Mask active) {
  if (const std::optional<std::int32_t> same = common_value(index, active))
    return Int(table[static_cast<std::size_t>(*same)]);
  return gather(table.data(), index, active);
}

/// The state of paths that begin at the eye, before their first event.
TESSERA_INLINE Int state_at_eye(const SceneTables& scene) {
  return Int(tells_layers(scene) ? scene.layers.from_camera.begin.front() : 0);
}
TESSERA_INLINE Int source_of(const LayerTable& table, Int light, Mask active) {
  if (table.one_source >= 0) return Int(table.one_source);
  return look_up(table.source_of_light, light, active);
}
/// The state of paths that begin at these lights.
TESSERA_INLINE Int state_at_light(const LayerTable& table, Int light, Mask active) {
  return look_up(table.from_lights.begin, source_of(table, light, active), active);
}

/// The layers of a path in this state that comes to a source of light, as bits.
TESSERA_INLINE Int layers_at_source(const LayerTable& table, Int state, Int source, Mask active) {
  return look_up(table.from_camera.layers, state * table.from_camera.ends + source, active);
}
TESSERA_INLINE Int layers_at_light(const LayerTable& table, Int state, Int light, Mask active) {
  return layers_at_source(table, state, source_of(table, light, active), active);
}
/// The layers of shadows of a path in this state, which is behind an event, where something is between this
/// and the light.
TESSERA_INLINE Int shadows_at_light(const LayerTable& table, Int state, Int light, Mask active) {
  return look_up(table.from_camera.shadows, state * table.from_camera.ends + source_of(table, light, active),
                 active);
}
/// The layers of a path from a light that comes to the eye in this state.
TESSERA_INLINE Int layers_at_eye(const LayerTable& table, Int state, Mask active) {
  return look_up(table.from_lights.layers, state, active);
}
/// The layers of a path from the eye in the state `eye` that ends where one from a light is in the state
/// `light`, every event being in one of them.
TESSERA_INLINE Int layers_of_join(const LayerTable& table, Int eye, Int light, Mask active) {
  return look_up(table.joined, eye * table.from_lights.states + light, active);
}

/// The layers, as bits, of all light that a strategy of `s` vertices from the light and `t` from the eye
/// finds.
inline std::int32_t layers_of_strategy(const LayerTable& table, int s, int t) {
  std::int32_t layers = table.of_any_strategy;
  for (const LayersOfStrategies& asked : table.of_strategies) {
    if (asked.strategies.has(s, t)) layers |= asked.layers;
  }
  return layers;
}

/// A number that decides whether an event is of the diffuse or of the glossy lobes, where both give light
/// that way: looked up only where it does.
struct LobeChoice {
  const Sampler& sampler;
  int event;           // the event's number in the path
  bool to_connection;  // the vertex is joined to a light, the eye or another path; else the path goes on
  int pairs = dimension::kLayerLobes;  // first pair of dimensions; each event has one

  TESSERA_INLINE Float number() const {
    const Vec2 u = sampler.get_2d(pairs + event);
    return to_connection ? u.x : u.y;
  }
};

/// The event by which the vertex scatters light between `wo` and `wi`, which are the two directions of
/// eval_scattering() in its order. `specular`: by a perfect lobe. Where light is of diffuse and of glossy
/// lobes the event is of one of them, with the probability of its part of the light.
Int event_at(const SceneTables& scene, const Vertex& v, Vec3 wo, Vec3 wi, Mask specular,
             const LobeChoice& choice, Mask active);

/// The state after an event.
TESSERA_INLINE Int next_state(const LayerAutomaton& automaton, Int state, Int event, Mask active) {
  return look_up(automaton.next, state * automaton.events + event, active);
}
/// The same for the event at a vertex, of paths from the camera and from lights; directions as in event_at().
TESSERA_INLINE Int state_after(const SceneTables& scene, const Vertex& v, Int state, Vec3 wo, Vec3 wi,
                               Mask specular, const LobeChoice& choice, Mask active) {
  return next_state(scene.layers.from_camera, state, event_at(scene, v, wo, wi, specular, choice, active),
                    active);
}
TESSERA_INLINE Int light_state_after(const SceneTables& scene, const Vertex& v, Int state, Vec3 wo, Vec3 wi,
                                     Mask specular, const LobeChoice& choice, Mask active) {
  return next_state(scene.layers.from_lights, state, event_at(scene, v, wo, wi, specular, choice, active),
                    active);
}

/// Layers of the light that is gathered at 16 vertices of paths from the eye from photons around them.
struct GatheredLayers {
  const SceneTables& scene;
  Int state;  // state before the event that the vertex is
  LobeChoice choice;
  LayerSums sums;

  /// The states behind vertices that reflect all light diffusely.
  Int state_after_diffuse_reflection(const Vertex& v, Mask lanes) const;
  /// Adds light of photons that came from `directions` to the vertices, in these states.
  void add(const Vertex& v, Spectrum light, Vec3 directions, Int photon_states, Mask lanes);
};

}  // namespace tessera::render::TESSERA_ISA
