// A job's layers -> LayerTable.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "layers/automaton.h"
#include "render/integrator/scene_tables.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"

namespace tessera::render {

/// The numbers of shapes' messages in the scene: those of the world, then those of each object, counted
/// through.
std::vector<std::int32_t> shape_numbers(const v1::Scene& scene, std::span<const v1::Shape* const> messages);

/// The automata of the layers, which have been checked, for paths that carry states as `states` says, and
/// the numbers of the scene's shapes and lights in it. `numbers`: of each shape of the arrays, as above.
absl::StatusOr<LayerTable> build_layers(const v1::Scene& scene, std::span<const layers::Layer> layers,
                                        wire::LayerStates states, std::span<const std::int32_t> numbers,
                                        const SceneArrays& arrays);

}  // namespace tessera::render
