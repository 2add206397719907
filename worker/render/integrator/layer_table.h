// Which layers light belongs to, as the kernels read it: the automaton of a job's layers
// (proto/layers/automaton.h), and what it calls the shapes and lights of the scene.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

struct LayerTable {
  std::int32_t count = 0;    // of layers; 0: light is not told apart, and the rest is empty
  bool from_lights = false;  // paths begin at the lights: states are those of the reversed automaton
  bool tells_lobes = false;  // diffuse and glossy events differ somewhere
  std::int32_t events = 0, ends = 0;
  std::vector<std::int32_t> begin;   // first state of a path: one, or with from_lights one a source
  std::vector<std::int32_t> next;    // [state * events + event]
  std::vector<std::int32_t> layers;  // bits of layers: [state * ends + source], with from_lights [state]
  std::vector<std::int32_t> first_event_of_shape;  // to which the kind of event is added; empty: 0 for all
  std::vector<std::int32_t> source_of_light;       // of each LightRecord
  std::int32_t one_source = -1;                    // that of all lights, if there is but one
  std::int32_t source_of_media = 0;
};

}  // namespace tessera::render
