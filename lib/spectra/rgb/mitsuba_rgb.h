// Spectra to linear Rec.709 as Mitsuba 3's RGB modes integrate them.
#pragma once

#include "spectra/curve.h"
#include "spectra/observer/observer.h"

namespace tessera::spectra {

enum class SeenUnder {
  /// An emitted spectrum as it is: a constant one is not white in Rec.709, whose white is D65.
  kEqualEnergy,
  /// A reflectance in daylight: a constant one is grey.
  kD65,
};

/// The colour of a spectrum that is zero outside its samples, integrated in 1000 steps over 360..830 nm.
/// Components may be negative or above 1. Needs at least two samples.
Triple mitsuba_rgb(const Curve& spectrum, SeenUnder light);

/// Linear Rec.709 of CIE XYZ, with the matrix that Mitsuba 3 has.
Triple mitsuba_rgb_from_xyz(const Triple& xyz);

}  // namespace tessera::spectra
