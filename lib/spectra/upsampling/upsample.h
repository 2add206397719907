// Colours as spectra: what a renderer of wavelengths makes of RGB.
#pragma once

#include "spectra/color/rgb.h"
#include "spectra/upsampling/sigmoid.h"

namespace tessera::spectra {

class SigmoidTable;

/// The table that reflectances are looked up in (own_table.h). Thread-safe.
const SigmoidTable& sigmoid_table();

/// Colours within the gamut of Rec.709 differ by less from what they become, in CIEDE2000.
inline constexpr double kMostUpsamplingError = 0.35;

struct UpsampledReflectance {
  SigmoidCoefficients coefficients;
  /// CIEDE2000 to what was asked for, where a component was not in [0, 1]: then a sigmoid of that colour is
  /// fitted, if there is one. Else 0, which is below kMostUpsamplingError.
  double error;
};

/// A reflectance of the colour `rgb` in linear Rec.709 under D65. Seen under it again, it differs by less
/// than 0.35 in CIEDE2000 for every colour with components in [0, 1] (0.06 on average), and not at all for
/// greys, whose reflectance is constant. Others are clamped to [-1, 2], and NaN counts as 0. Thread-safe.
UpsampledReflectance upsample_reflectance(const Rgb& rgb);

struct UpsampledEmission {
  /// The spectrum is scale times the sigmoid times D65 with a luminance of 1 (unit_d65).
  float scale;
  SigmoidCoefficients coefficients;
  /// The same as of a reflectance, where a component was negative; those that are not finite are as large as
  /// can be.
  double error;
};

/// Light of the colour `rgb` in linear Rec.709: a grey c is c times D65.
UpsampledEmission upsample_emission(const Rgb& rgb);

}  // namespace tessera::spectra
