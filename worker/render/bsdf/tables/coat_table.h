// Energies of rough dielectric boundaries, for coats whose base is diffuse [coated_diffuse.h]: computed once
// a distinct index when a scene is loaded.
#pragma once

#include <cstdint>

#include "render/bsdf/material_table.h"

namespace tessera::render {

// One table, in floats from its offset in MaterialTable::coat_tables on:
//   [kCoatEta]           the index eta that it is for
//   [kCoatThickness]     the optical thickness d of the coat
//   [kCoatInternal + a]  R_int for roughness row a: reflectance for diffuse light from the base
//   [kCoatTransmittance + a * kCoatCosines + c]  T for row a and the angle of column c
// A coat absorbs exp(-d / mu) of light that crosses it under the cosine mu, as pbrt-v4's layers do even where
// there is no medium between them: T holds that of the light refracted smoothly, R_int that of both ways. Row
// a has alpha = (a / (kCoatAlphas - 1))^2, so row 0 is smooth; column c has cos(theta) = (c / (kCoatCosines -
// 1))^2: both quantities change fastest near 0. Between rows and columns, interpolate linearly: the mean
// error for index 1.5 is 3e-4, the largest 5e-3, at 89 degrees.
inline constexpr int kCoatAlphas = 32;
inline constexpr int kCoatCosines = 32;
inline constexpr int kCoatEta = 0;
inline constexpr int kCoatThickness = 1;
inline constexpr int kCoatInternal = 2;
inline constexpr int kCoatTransmittance = kCoatInternal + kCoatAlphas;
inline constexpr int kCoatTableSize = kCoatTransmittance + kCoatAlphas * kCoatCosines;

/// The offset of the table of `eta` > 0 (index of the coat over the index outside) and `thickness` >= 0
/// (optical), which is computed and appended unless it is there.
std::int32_t append_coat_table(float eta, float thickness, MaterialTable& table);

}  // namespace tessera::render
