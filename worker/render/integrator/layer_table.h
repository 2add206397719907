// Which layers light belongs to, as the kernels read it: the automaton of a job's layers
// (lib/layers/automaton.h), and what it calls the shapes and lights of the scene.
#pragma once

#include <cstdint>
#include <vector>

#include "layers/strategies.h"

namespace tessera::render {

/// States of paths that begin at one end, the camera or the lights, and are read to the other.
struct LayerAutomaton {
  std::int32_t states = 0, events = 0, ends = 0;
  std::vector<std::int32_t> begin;  // first state of a path: one, or from lights one a source
  std::vector<std::int32_t> next;   // [state * events + event]
  // Bits of layers, where the other end comes next: [state * ends + end]
  std::vector<std::int32_t> layers;   // layers of light that arrives
  std::vector<std::int32_t> shadows;  // layers of light that something is in the way of; empty: none has any
};

/// Layers of light that some strategies find.
struct LayersOfStrategies {
  layers::Strategies strategies;
  std::int32_t layers = 0;  // bits
};

struct LayerTable {
  std::int32_t count = 0;    // number of layers; 0: light is not told apart, and the rest is empty
  bool tells_lobes = false;  // diffuse and glossy events differ somewhere
  bool has_shadows = false;  // some layers are of light that something is in the way of
  LayerAutomaton from_camera;
  // Only for algorithms whose paths begin at the lights, too
  LayerAutomaton from_lights;
  std::vector<std::int32_t>
      joined;                   // bits of layers: [state from the camera * from_lights.states + the other]
  std::int32_t unweighted = 0;  // bits of layers of what strategies find by themselves
  std::int32_t of_any_strategy = 0;  // bits of layers that ask for none
  std::vector<LayersOfStrategies> of_strategies;
  std::vector<std::int32_t> first_event_of_shape;  // the kind of event is added to it; empty: 0 for all
  std::vector<std::int32_t> source_of_light;       // source of each LightRecord
  std::int32_t one_source = -1;                    // source of all lights, if there is but one
  std::int32_t source_of_media = 0;
};

}  // namespace tessera::render
