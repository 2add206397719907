// Tables of thin films: computed when a scene with an iridescent material is loaded.
#pragma once

#include <vector>

#include "render/bsdf/tables/gltf_layer_table.h"

namespace tessera::render {

// Interference as R, G and B see it. Entry i, four floats: for red, green and blue the mean of
// cos(2 pi x / wavelength) over what the channel sees of a reflectance under D65, where x = i kFilmStepNm is
// a difference of optical paths; then 0. Between entries, interpolate linearly (error 1.6e-3). From the last
// entry on it is 0: there all is below 8e-3.
inline constexpr int kFilmEntry = 4;
inline constexpr int kFilmEntries = 1501;
inline constexpr float kFilmStepNm = 8;

// From kFacetCosines on: cosines under which light of one direction meets the facets that reflect it,
// weighted by 1 - Schlick's weight: two that stand for all, by Gauss's rule. Rows and columns are those of
// layer_table.h, without means; four floats an entry: the smaller cosine, the larger one, and the part that
// counts as the smaller; then 0.
inline constexpr int kFacetCosines = kFilmEntry * kFilmEntries;

std::vector<float> film_table();

}  // namespace tessera::render
