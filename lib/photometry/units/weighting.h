// Weights of spectral radiance by what it does to eyes.
#pragma once

#include <span>

#include "photometry/units/light_unit.h"

namespace tessera::photometry {

/// The part that a spectral radiance of 1 W/(m^2 sr nm) between two wavelengths adds to the radiance,
/// luminance (cd/m^2, 683 lm/W), scotopic luminance (1700 lm/W), or melanopic equivalent daylight luminance.
double band_weight(Weighting weighting, double from_nm, double to_nm);

/// The sum over `bands` of one width from `from_nm` on, spectral radiances in W/(m^2 sr nm).
double weighted(Weighting weighting, std::span<const double> bands, double from_nm, double width_nm);

}  // namespace tessera::photometry
