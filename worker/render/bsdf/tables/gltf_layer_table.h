// The share that the upper layers of glTF's materials [model/gltf.cpp] reflect of the light along a
// direction: computed when a scene with such materials is loaded.
#pragma once

#include <cstdint>

#include "render/bsdf/material_table.h"

namespace tessera::render {

// One table for all materials, in floats from its offset in MaterialTable::coat_tables on, four an entry:
//   [0] energy of GGX with Schlick's reflectance, the part that belongs to the reflectance along the normal
//   [1] ... and along the surface: F0 [0] + F90 [1] is reflected, [0] + [1] by a perfect mirror
//   [2] energy of a white sheen, which may be above 1
// First kLayerRows entries that are means over diffuse light, for the roughness r / (kLayerRows - 1); then
// kLayerRows rows of kLayerColumns, where column c has cos(theta) = (c / (kLayerColumns - 1))^2. Between rows
// and columns, interpolate linearly: the means are those of what is interpolated.
inline constexpr int kLayerEntry = 4;
inline constexpr int kLayerRows = 32;
inline constexpr int kLayerColumns = 48;

/// Below this, facets are too narrow for single precision.
inline constexpr float kLeastLayerAlpha = 1e-3f;
/// Below this roughness (its alpha is 0.0049) a sheen is a rim that no picture shows.
inline constexpr float kLeastSheenRoughness = 0.07f;

/// Appends the table; returns its offset.
std::int32_t append_layer_table(MaterialTable& table);

}  // namespace tessera::render
