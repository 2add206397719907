// The state of the layers' automaton on its way along paths: which event a vertex is, and which layers the
// light has that is found there. Nothing of it is asked where a job has no layers.
//
// An algorithm that joins paths from both ends says LayerStates::kFromCamera. Its eye paths carry states, and
// the vertices of its light paths keep their events: next_state() for each of these, from the connection back
// to the light, and layers_at_light() at its end give the layers of the whole path.
#pragma once

#include <optional>
#include <vector>

#include "render/integrator/layer_table.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/integrator/vertex/vertex.h"
#include "render/sampling/sampler.h"

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
  const LayerTable& table = scene.layers;
  return Int(tells_layers(scene) && !table.from_lights ? table.begin.front() : 0);
}
TESSERA_INLINE Int source_of(const LayerTable& table, Int light, Mask active) {
  if (table.one_source >= 0) return Int(table.one_source);
  return look_up(table.source_of_light, light, active);
}
/// The state of paths that begin at these lights.
TESSERA_INLINE Int state_at_light(const LayerTable& table, Int light, Mask active) {
  return look_up(table.begin, source_of(table, light, active), active);
}

/// The layers of a path in this state that comes to a source of light, as bits. With from_lights: of light
/// that reaches the eye from there without an event.
TESSERA_INLINE Int layers_at_source(const LayerTable& table, Int state, Int source, Mask active) {
  if (table.from_lights) return look_up(table.layers, look_up(table.begin, source, active), active);
  return look_up(table.layers, state * table.ends + source, active);
}
TESSERA_INLINE Int layers_at_light(const LayerTable& table, Int state, Int light, Mask active) {
  return layers_at_source(table, state, source_of(table, light, active), active);
}
/// With from_lights: of a path in this state that comes to the eye.
TESSERA_INLINE Int layers_at_eye(const LayerTable& table, Int state, Mask active) {
  return look_up(table.layers, state, active);
}

/// A number that decides whether an event is of the diffuse or of the glossy lobes, where both give light
/// that way: looked up only where it does.
struct LobeChoice {
  const Sampler& sampler;
  int event;           // of the path
  bool to_connection;  // the vertex is joined to a light or to the eye; else the path goes on

  TESSERA_INLINE Float number() const {
    const Vec2 u = sampler.get_2d(dimension::kLayerLobes + event);
    return to_connection ? u.x : u.y;
  }
};

/// The event by which the vertex scatters light between `wo` and `wi`, which are the two directions of
/// eval_scattering() in its order. `specular`: by a perfect lobe. Where light is of diffuse and of glossy
/// lobes the event is of one of them, with the probability of its part of the light.
Int event_at(const SceneTables& scene, const Vertex& v, Vec3 wo, Vec3 wi, Mask specular,
             const LobeChoice& choice, Mask active);

/// The state after an event.
TESSERA_INLINE Int next_state(const LayerTable& table, Int state, Int event, Mask active) {
  return look_up(table.next, state * table.events + event, active);
}
TESSERA_INLINE Int state_after(const SceneTables& scene, const Vertex& v, Int state, Vec3 wo, Vec3 wi,
                               Mask specular, const LobeChoice& choice, Mask active) {
  return next_state(scene.layers, state, event_at(scene, v, wo, wi, specular, choice, active), active);
}

}  // namespace tessera::render::TESSERA_ISA
