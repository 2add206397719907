// Participating media as the kernels read them: plain records, filled by scene/, the same for every ISA.
#pragma once

#include <cstdint>
#include <vector>

#include "render/color/bands.h"
#include "render/core/affine_data.h"

namespace tessera::render {

/// Samples at the centres of the cells of the unit cube.
struct DensityGrid {
  std::int32_t size[3] = {1, 1, 1};
  std::int32_t channels = 1;   // 1 or kBands, together
  Affine grid_from_render;     // maps to the unit cube
  std::vector<float> samples;  // x fastest
};

/// A quantity of a medium: the same everywhere, or `grid` (an index into MediumTable::grids) times `value`.
struct MediumValue {
  float value[kBands] = {0, 0, 0};
  std::int32_t grid = -1;
  // Jobs of wavelengths only: in SpectralTables::curves, in place of the value; of an emission, the curve
  // that the value is multiplied by, -1: daylight.
  std::int32_t curve = -1;
};

struct MediumRecord {
  MediumValue sigma_t;   // 1/length, render space
  MediumValue albedo;    // sigma_s / sigma_t; or sigma_s itself where `scattering_is_sigma_s`
  MediumValue emission;  // radiance per length of absorption
  float g = 0;           // Henyey-Greenstein asymmetry
  bool scattering_is_sigma_s = false;
  bool emits = false;
  bool homogeneous = true;
  // Not homogeneous: where the medium is, and bounds of sigma_t there.
  Affine bounds_from_render;  // maps to the unit cube
  std::int32_t cells[3] = {1, 1, 1};
  std::vector<float> majorants;  // largest component of sigma_t in a cell of the unit cube, x fastest
};

struct MediumTable {
  std::vector<MediumRecord> media;
  std::vector<DensityGrid> grids;
};

/// Fills cells and majorants of a medium that is not homogeneous, whose other members are set [Novak et al.
/// 2014].
void build_majorants(const MediumTable& table, MediumRecord& medium);

}  // namespace tessera::render
