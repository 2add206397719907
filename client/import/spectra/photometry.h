// Luminance of spectra, with the CIE 1931 colour-matching function y.
#pragma once

#include <functional>

#include "import/spectra/named_spectra.h"

namespace tessera::client {

/// The integral of y(l) s(l) dl over 360..830 nm, divided by that of y: 1 for a constant spectrum of 1. `s`
/// maps nanometres to values.
double luminance(const std::function<double(double)>& spectrum);
double luminance(const SpectrumTable& spectrum);

/// Value of the piecewise-linear spectrum at a wavelength.
double evaluate(const SpectrumTable& spectrum, double wavelength_nm);

/// Planck's law, normalised to a maximum of 1 over all wavelengths.
double normalized_blackbody(double wavelength_nm, double kelvin);

}  // namespace tessera::client
