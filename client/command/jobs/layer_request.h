// Layers as the command line asks for them -> expressions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "layers/automaton.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// Layers that --layers and --aov ask for; none: as the scene has it.
struct LayerRequest {
  std::optional<std::vector<layers::Layer>> layers;  // layers in place of the scene's
  std::optional<std::uint32_t> bounces;              // a layer for each number of events up to this one
  bool lights = false;                               // a layer for each light, or group of lights
  bool emission = false;                             // a layer of light that is seen directly
  bool shadow = false;                               // a layer of light that things keep from what is seen
  bool strategies = false;                           // a layer for each way to join paths from both ends
  bool unweighted_strategies = false;                // the same, of what it finds by itself

  bool any() const {
    return layers || bounces || lights || emission || shadow || strategies || unweighted_strategies;
  }
};

/// Takes a word of --aov that asks for layers: "emission", "lights", "shadow", "strategies",
/// "unweighted-strategies", "bounce0..bounce3". False for other words; InvalidArgument for a range of bounces
/// that is none.
absl::StatusOr<bool> take_layer_word(const std::string& word, LayerRequest& asked);

/// The layers of a job whose paths have up to `max_depth` events: those that are asked for, or the scene's,
/// then those of single bounces, of lights, of emission, of shadows and of strategies. InvalidArgument where
/// an expression has a name that nothing in the scene has, or the scene has more lights than there may be
/// layers.
absl::StatusOr<std::vector<layers::Layer>> layers_of_job(const LayerRequest& asked, const v1::Scene& scene,
                                                         std::uint32_t max_depth);

}  // namespace tessera::client
