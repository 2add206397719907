// The responses of an observer or a camera to a spectrum.
#pragma once

#include "spectra/curve.h"
#include "spectra/observer/observer.h"

namespace tessera::spectra {

struct Chromaticity {
  double x, y;
};

/// The three responses to `light`, scaled so that the second is 1 for a light of 1 at all wavelengths: XYZ
/// where `observer` is one of the CIE. Exact for curves as they are, with lines between their samples; so are
/// the others.
Triple tristimulus(const Curve& light, const Observer& observer);

/// The responses to matter of a reflectance (or transmittance) under `light`, scaled so that the second is 1
/// for a reflectance of 1.
Triple tristimulus(const Curve& reflectance, const Curve& light, const Observer& observer);

/// Requires a sum above 0.
Chromaticity chromaticity(const Triple& xyz);

/// XYZ with Y = 1.
Triple xyz_of(const Chromaticity& chromaticity);

}  // namespace tessera::spectra
