// Which algorithm can render which scene, as far as traits and the Scene message tell.
#pragma once

#include <string>

#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"

namespace tessera::wire {

/// Why the algorithm cannot render all that the scene has: "sees no media". Empty where it can, or where only
/// building the scene can tell. Media count where they are wanted.
std::string obstacle_to(const AlgorithmTraits& algorithm, const v1::Scene& scene, bool wants_media = true);

}  // namespace tessera::wire
