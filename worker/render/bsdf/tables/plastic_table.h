// Energies of the coat of Mitsuba 3's "plastic" and "roughplastic" [plastic.h], made when a scene is loaded.
//
// They are made the way that renderer makes them, coarse as it is, because images of the format show it: the
// diffuse reflectance inside a rough coat is a mean over 64 evenly spaced cosines, ends included, which
// is 1.6 % too little.
#pragma once

#include <cstdint>

#include "render/bsdf/material_table.h"
#include "render/bsdf/tables/boundary_energy.h"

namespace tessera::render {

// One table, in floats from its offset in MaterialTable::coat_tables on:
//   [kPlasticInternal]           reflectance for diffuse light from the base
//   [kPlasticTransmittance + i]  rough coats only: T at cosine i / (kPlasticCosines - 1); interpolated
//   linearly
inline constexpr int kPlasticCosines = 64;
inline constexpr int kPlasticInternal = 0;
inline constexpr int kPlasticTransmittance = 1;

/// Appends the table of a coat of index `eta` > 0 over that outside; returns its offset.
std::int32_t append_plastic_table(float eta, const BoundaryFacets& facets, MaterialTable& table);

}  // namespace tessera::render
