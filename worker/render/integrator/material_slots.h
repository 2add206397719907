// The parameters of the materials at 16 points: constants fetched, textures looked up.
#pragma once

#include "render/integrator/interaction.h"

namespace tessera::render::TESSERA_ISA {

/// Fills `part.params` for lanes whose kind, material and flags are set.
void load_parameters(const SceneTables& scene, const Surface& surface, Int record, Mask active, MaterialPart& part);

}  // namespace tessera::render::TESSERA_ISA
