// The parameters of the materials at 16 points: constants fetched, textures looked up.
#pragma once

#include "render/integrator/interaction.h"

namespace tessera::render::TESSERA_ISA {

/// Fills `part.params` for lanes whose kind, material and flags are set. `common` is the record of all active
/// lanes, null where they differ.
void load_parameters(const SceneTables& scene, const Surface& surface, Int record,
                     const MaterialRecord* common, Mask active, MaterialPart& part);

}  // namespace tessera::render::TESSERA_ISA
