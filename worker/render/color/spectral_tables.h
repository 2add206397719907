// Tables that kernels for wavelengths look up: filled by scene/, the same for every ISA.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

/// Curves are sampled every nanometre from the first to the last, and linear in between.
inline constexpr float kFirstNm = 300, kLastNm = 1000;
inline constexpr int kCurveSamples = 701;
static_assert(kCurveSamples == int(kLastNm - kFirstNm) + 1);

/// The wavelength that a quantile of the sampled ones begins at, and one over the density within the
/// quantile.
struct WavelengthQuantile {
  float nm, width;
};

/// Sigmoids are functions of the distance to the middle over the half width.
inline constexpr float kSigmoidMiddleNm = 595, kSigmoidHalfWidthNm = 235;

struct SpectralTables {
  /// The rows of spectra::SigmoidTable, which outlives these tables: four floats an entry, c0, c1, c2 and 0.
  const float* coefficients = nullptr;
  /// The meaning of the rows: -1 / sqrt(largest component), and the ratios of the others to it.
  std::vector<float> levels, ratios;

  /// One after the other, kCurveSamples values each. The first is daylight (D65), of which the colour of
  /// light is a multiple where its own curve is not known.
  std::vector<float> curves;
  /// The number of each light's own curve, by which its colour is multiplied; -1: daylight. Empty where none
  /// has any.
  std::vector<std::int32_t> curve_of_light;
};

/// How a sensor sees light of wavelengths.
struct SensitivityTable {
  /// Wavelengths are sampled by the sum of its sensitivities: quantiles of equal probability.
  std::vector<WavelengthQuantile> quantiles;
  /// Three floats and a zero for each nanometre: what radiance at this wavelength, per nanometre, adds to
  /// red, green and blue. Zero outside from_nm to to_nm, whatever stands here.
  std::vector<float> light;
  /// The same of reflectances, in the light that is white to the sensor: 1 at all wavelengths is (1, 1, 1).
  std::vector<float> matter;
  float from_nm = kFirstNm, to_nm = kLastNm;
  /// Bands of radiance that pictures have besides, side by side from first_band_nm on.
  std::int32_t bands = 0;
  float first_band_nm = 0, bands_per_nm = 0;
};

}  // namespace tessera::render
