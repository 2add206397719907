// Daylight: D65, the ACES white, and the D-series by correlated colour temperature. Relative power, 100
// at 560 nm.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "spectra/curve.h"

namespace tessera::spectra {

inline constexpr double kDaylightFirstNm = 300, kDaylightStepNm = 10;
inline constexpr std::size_t kDaylightCount = 54;

/// CIE standard illuminant D65, 300 to 830 nm; linear in between by definition [ISO 11664-2].
inline constexpr std::array<double, kDaylightCount> kD65Power = {
    0.0341,  3.2945,  20.236,  37.0535, 39.9488, 44.9117, 46.6383, 52.0891, 49.9755, 54.6482, 82.7549,
    91.486,  93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811, 109.354, 107.802,
    104.79,  107.689, 104.405, 104.046, 100,     96.3342, 95.788,  88.6856, 90.0062, 89.5991, 87.6987,
    83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349,  61.604,  69.8856,
    75.087,  63.5927, 46.4182, 66.8054, 63.3828, 64.304,  59.4519, 51.959,  57.4406, 60.3125};

/// The D50 of pbrt-v4: from 570 nm on it has less than CIE illuminant D50, which is daylight() of 5003 K.
Curve pbrt_d50();
/// kD65Power as a curve.
Curve illuminant_d65();
/// D65 scaled to a luminance of 1, as tristimulus() of a light has it by the CIE 1931 observer.
Curve unit_d65();
/// The white of ACES [Academy TB-2018-001].
Curve illuminant_aces_d60();

/// Daylight of a correlated colour temperature from 4000 to 25000 K, nothing beyond [CIE 15:2004]. D55
/// is daylight(5500 * 1.4388 / 1.4380): the temperatures in these names are of an older radiation constant.
std::optional<Curve> daylight(double kelvin);

}  // namespace tessera::spectra
