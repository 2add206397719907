// Images with bands of spectral radiance, in the layout of Fichet, Pacanowski and Wilkie [2021].
#pragma once

#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "image/image.h"
#include "spectra/sensor/sensor_response.h"

namespace tessera::client {

inline constexpr const char kFilmOfImage[] = "tessera.film";  // metadata: the words of spectra::parse_film()

struct BandPlane {
  double centre_nm, from_nm, to_nm;
  std::size_t channel;
};

/// The bands of an image, by their wavelengths. Where its metadata do not tell their widths, bands meet
/// half-way between their centres. InvalidArgument for an image without bands, or with one of unknown width.
absl::StatusOr<std::vector<BandPlane>> bands_of(const Image& image);

/// Returns what a sensor sees of the bands, as if radiance were the same all over each: R, G and B, and the
/// image's A where it has one. Metadata are the image's but for the space.
absl::StatusOr<Image> seen_by(const Image& image, const spectra::SensorResponse& sensor);

}  // namespace tessera::client
