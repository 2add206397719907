// Error of an image's bands against those of a reference.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "image/image.h"
#include "spectra/observer/observer.h"

namespace tessera::client {

struct BandError {
  double centre_nm = 0;
  double mean_reference = 0, mean_test = 0;
  double bias_percent = 0;  // of mean_reference
  double relmse = 0;  // mean of (T - R)^2 / (R^2 + epsilon m^2), where m is the mean of the reference's band
};

struct SpectralComparison {
  std::int32_t width = 0, height = 0;
  std::uint64_t non_finite_pixels = 0;  // in either image; left out
  std::vector<BandError> bands;         // by their wavelengths
  // Means over pixels of the difference CIEDE2000 between what an observer sees of the bands, and the
  // greatest of them; white is daylight (D65) of a luminance of 1.
  double mean_delta_e = 0, most_delta_e = 0;
};

/// InvalidArgument when sizes or bands differ, or no pixel is finite.
absl::StatusOr<SpectralComparison> compare_bands(const Image& reference, const Image& test,
                                                 const spectra::Observer& observer, double epsilon = 0.01);

/// For people; several lines, the last without its end.
std::string to_text(const SpectralComparison& comparison);
/// The fields of SpectralComparison as an object: "size", "non_finite_pixels", "bands" [{"nm", "mean_ref",
/// "mean_test", "bias_percent", "relmse"} ...], "mean_delta_e", "most_delta_e".
std::string to_json(const SpectralComparison& comparison);

}  // namespace tessera::client
