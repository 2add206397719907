// Luminance as pbrt-v4 scales light spectra by it.
#pragma once

#include <functional>

#include "spectra/curve.h"

namespace tessera::spectra {

/// The sum of y(l) s(l) over 360..830 nm in steps of 1 nm, divided by that of y: 1 for a constant spectrum
/// of 1. `s` maps nanometres to values.
double pbrt_luminance(const std::function<double(double)>& spectrum);
double pbrt_luminance(const Curve& spectrum);

}  // namespace tessera::spectra
