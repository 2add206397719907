// Checks of a hand-written scene, before anything is uploaded.
#pragma once

#include "import/input/diagnostics.h"
#include "import/tessera_scene/blob_refs.h"

namespace tessera::client::tessera_scene {

/// Reports every name that refers to nothing (with the nearest that exists), names used twice, elements
/// without a kind, and matrices of another size than 0 or 16 as errors; a scene without light and
/// reflectances above 1 as warnings. Animations are checked, too. Each at its line and column, as far as
/// `locations` knows them. Numbers and files are for others to check.
void check_scene(const v1::Scene& scene, std::uint32_t file, Locations* locations, Diagnostics& diagnostics);

}  // namespace tessera::client::tessera_scene
