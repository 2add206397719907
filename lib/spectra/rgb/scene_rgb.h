// Measured spectra to linear Rec.709, as scenes are rendered in RGB.
//
// All integrals run over 360..830 nm with the CIE 1931 2-degree matching functions in steps of 5 nm.
//
// "White" differs between light and matter, as it does in pbrt-v4:
//  - Emission is what an observer sees: XYZ of the spectrum, with luminance Y = 1 for a spectrum that is 1
//    everywhere, then to Rec.709 without adaptation. An equal-energy spectrum is therefore slightly pink,
//    (1.205, 0.948, 0.909), and D65 is (1, 1, 1) times its luminance.
//  - Reflectance is what an observer sees under D65, the white of Rec.709; a constant c is exactly (c, c, c).
// The scene's `constant` spectrum stands for a colour without hue, and is (c, c, c) in both uses; no function
// here is needed for it.
#pragma once

#include <vector>

#include "spectra/color/rgb.h"
#include "spectra/curve.h"
#include "spectra/observer/observer.h"

namespace tessera::spectra {

/// Radiance of an emission spectrum. Components out of the gamut of Rec.709 come out as zero, not negative.
Rgb emission_rgb(const Curve& spectrum);

/// Reflectance or transmittance, clamped to [0, 1].
Rgb reflectance_rgb(const Curve& spectrum);

/// The part that one wavelength has in R, G and B of a reflectance under D65: it sums to 1 over all
/// wavelengths; single ones may be negative.
struct ReflectanceShare {
  double nm;
  Triple rgb;
};

/// All of them, a nanometre apart: the tables interpolated between their steps.
std::vector<ReflectanceShare> reflectance_shares();

/// emission_rgb of Planck's law at `kelvin`, scaled so that its greatest value over all wavelengths is 1
/// [pbrt-v4 BlackbodySpectrum]. Black for temperatures that are not positive.
Rgb blackbody_rgb(float kelvin);

/// Luminance Y of the spectrum that emission_rgb and blackbody_rgb convert; pbrt-v4 divides light spectra by
/// it.
double emission_luminance(const Curve& spectrum);
double blackbody_luminance(float kelvin);

/// Complex indices of refraction, a pair for each of R, G, B.
struct ConductorRgb {
  Rgb eta, k;
};

/// The indices that best stand for a metal in an RGB renderer: each channel has the normal-incidence
/// reflectance that the spectral metal shows under D65 (clamped to [0, 0.9999]), and the mean eta over what
/// that channel sees; k follows from these two.
ConductorRgb conductor_rgb(const Curve& eta, const Curve& k);

/// Index of refraction at the sodium D line, 589.3 nm.
float dielectric_eta(const Curve& eta);

}  // namespace tessera::spectra
