// Spectra -> linear Rec.709.
#pragma once

#include <array>

#include "import/spectra/named_spectra.h"

namespace tessera::client {

enum class SeenUnder {
  kEqualEnergy,  // an emitted spectrum as it is: a constant one is not white in Rec.709, whose white is D65
  kD65,          // a reflectance in daylight: a constant one is grey
};

/// The colour of a spectrum that is zero outside its samples, integrated in 1000 steps over 360..830 nm as
/// Mitsuba 3's RGB modes do. Components may be negative or above 1. Needs at least two samples.
std::array<double, 3> linear_rgb(const SpectrumTable& spectrum, SeenUnder light);

/// Linear Rec.709 of CIE XYZ.
std::array<double, 3> rec709_from_xyz(const std::array<double, 3>& xyz);

}  // namespace tessera::client
