#include "import/pbrt/file/color_space.h"

#include <cmath>

#include "spectra/color/rgb_space.h"

namespace tessera::client::pbrt {
namespace {

/// Rounded to ten digits, of which each row sums to 1.
spectra::Matrix3 rec709_matrix(const spectra::RgbSpace& from) {
  spectra::Matrix3 matrix = spectra::rgb_from_rgb(spectra::kRec709, from);
  for (spectra::Triple& row : matrix) {
    for (double& element : row) element = std::round(element * 1e10) / 1e10;
  }
  return matrix;
}

}  // namespace

std::optional<ColorSpace> color_space_of(std::string_view name) {
  if (name == "srgb") return ColorSpace::kSrgb;
  if (name == "dci-p3") return ColorSpace::kDciP3;
  if (name == "rec2020") return ColorSpace::kRec2020;
  if (name == "aces2065-1") return ColorSpace::kAces2065;
  return std::nullopt;
}

std::array<double, 3> rec709_from(ColorSpace from, const std::array<double, 3>& rgb) {
  if (from == ColorSpace::kSrgb) return rgb;
  static const spectra::Matrix3 from_p3 = rec709_matrix(spectra::kP3D65),
                                from_rec2020 = rec709_matrix(spectra::kRec2020),
                                from_aces = rec709_matrix(spectra::kAces2065);
  return spectra::times(from == ColorSpace::kDciP3     ? from_p3
                        : from == ColorSpace::kRec2020 ? from_rec2020
                                                       : from_aces,
                        rgb);
}

}  // namespace tessera::client::pbrt
