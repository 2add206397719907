// Factors that give rough boundaries back the light that scatters more than once between their facets,
// computed when a scene with such materials is loaded [balance.h].
//
// Single scattering f loses energy. With a factor s of every direction, f(wo, wi) s(wo) s(wi) loses none if
//   s(wo) * integral of f(wo, wi) s(wi) |cos theta_i| dwi = 1 for all wo,
// over both sides of a boundary that transmits. There is one such s, which alternating normalisation finds
// [Sinkhorn & Knopp 1967]: single scattering is scaled up to its energy as in [Turquin 2019], but
// reciprocally.
#pragma once

#include <cstdint>

#include "render/bsdf/material_table.h"

namespace tessera::render {

// One table, in floats from its offset in MaterialTable::coat_tables on:
//   [kBalanceFirst]     square root of the roughness of row 0
//   [kBalancePerRow]    rows per unit of the square root of roughness; 0 when all rows are alike
//   [kBalanceKept + r]  mean energy that single scattering keeps of diffuse light from above, for row r
//   [kBalanceFactors + (side * kBalanceRows + r) * kBalanceCosines + c]  s; side 1: below the surface
//   (dielectrics)
// Anisotropic facets of constant roughness fill half of the rows. Rows are roughnesses along the direction's
// azimuth; column c has cos(theta) = (c / (kBalanceCosines - 1))^2, as s changes fastest near 0. Between rows
// and columns, interpolate linearly.
inline constexpr int kBalanceRows = 25;
inline constexpr int kBalanceCosines = 52;
inline constexpr int kBalanceFirst = 0;
inline constexpr int kBalancePerRow = 1;
inline constexpr int kBalanceKept = 2;
inline constexpr int kBalanceFactors = kBalanceKept + kBalanceRows;

/// Purpose of a table.
struct BalancedFacets {
  float alpha_x = 0, alpha_y = 0;  // roughness; not both below kSmoothAlpha (microfacet.h)
  bool textured = false;  // any roughness from 0 to 1, the same along x and y; the above do not count then
  bool beckmann = false;
  bool separable_masking = false;
  float eta = 0;  // > 0: index below the surface over that above; 0: a mirror

  auto operator<=>(const BalancedFacets&) const = default;
};

/// Appends a table; returns its offset.
std::int32_t append_balance_table(const BalancedFacets& facets, MaterialTable& table);

}  // namespace tessera::render
