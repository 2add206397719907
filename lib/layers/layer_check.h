// The text of layers, as errors show it.
#pragma once

#include "absl/status/statusor.h"
#include "layers/automaton.h"
#include "layers/expression.h"

namespace tessera::layers {

/// The paths that the layer is of, in the order from the camera. InvalidArgument, naming the layer and the
/// column, where its text is no rule.
absl::StatusOr<Node> paths_of(const Layer& layer);

}  // namespace tessera::layers
