#include "image/spectral_metrics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "image/spectral_image.h"
#include "spectra/color/lab.h"
#include "spectra/color/rgb_space.h"
#include "spectra/color/tristimulus.h"
#include "spectra/light/daylight.h"

namespace tessera::client {
namespace {

/// Returns what an observer sees of the bands, in XYZ of D65's white.
absl::StatusOr<Image> colors_of(const Image& image, const spectra::Observer& observer) {
  const auto sensor = spectra::sensor_response({spectra::SensorKind::kObserver, observer},
                                               spectra::unit_d65(), spectra::kRec709);
  if (!sensor.ok()) return sensor.status();
  return seen_by(image, *sensor);
}

}  // namespace

absl::StatusOr<SpectralComparison> compare_bands(const Image& reference, const Image& test,
                                                 const spectra::Observer& observer, double epsilon) {
  const auto of_reference = bands_of(reference), of_test = bands_of(test);
  if (!of_reference.ok())
    return absl::InvalidArgumentError(absl::StrCat("reference: ", of_reference.status().message()));
  if (!of_test.ok()) return absl::InvalidArgumentError(absl::StrCat("test: ", of_test.status().message()));
  SpectralComparison result{.width = reference.data.width(), .height = reference.data.height()};
  if (test.data.width() != result.width || test.data.height() != result.height)
    return absl::InvalidArgumentError(absl::StrCat("sizes differ: ", result.width, " x ", result.height,
                                                   " and ", test.data.width(), " x ", test.data.height()));
  const auto is_same = [](const BandPlane& a, const BandPlane& b) {
    return std::abs(a.from_nm - b.from_nm) < 1e-3 && std::abs(a.to_nm - b.to_nm) < 1e-3;
  };
  if (!std::ranges::equal(*of_reference, *of_test, is_same)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("bands differ: %u from %g to %g nm, and %u from %g to %g nm", of_reference->size(),
                        of_reference->front().from_nm, of_reference->back().to_nm, of_test->size(),
                        of_test->front().from_nm, of_test->back().to_nm));
  }
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < reference.pixel_count(); ++i) {
    bool finite = true;
    for (std::size_t b = 0; b < of_test->size(); ++b)
      finite = finite && std::isfinite(reference.channels[(*of_reference)[b].channel].values[i]) &&
               std::isfinite(test.channels[(*of_test)[b].channel].values[i]);
    if (finite) pixels.push_back(i);
  }
  result.non_finite_pixels = reference.pixel_count() - pixels.size();
  if (pixels.empty()) return absl::InvalidArgumentError("no pixel is finite in both images");
  const auto count = static_cast<double>(pixels.size());
  for (std::size_t b = 0; b < of_test->size(); ++b) {
    const std::vector<float>&r = reference.channels[(*of_reference)[b].channel].values,
          &t = test.channels[(*of_test)[b].channel].values;
    BandError band{.centre_nm = (*of_reference)[b].centre_nm};
    for (const std::size_t i : pixels) band.mean_reference += r[i] / count, band.mean_test += t[i] / count;
    const double floor = epsilon * band.mean_reference * band.mean_reference;
    for (const std::size_t i : pixels) {
      const double difference = double{t[i]} - double{r[i]}, square = double{r[i]} * double{r[i]} + floor;
      if (difference != 0) band.relmse += difference * difference / square / count;
    }
    if (band.mean_reference != 0) band.bias_percent = 100 * (band.mean_test / band.mean_reference - 1);
    result.bands.push_back(band);
  }
  const auto seen_reference = colors_of(reference, observer), seen_test = colors_of(test, observer);
  if (!seen_reference.ok()) return seen_reference.status();
  if (!seen_test.ok()) return seen_test.status();
  const spectra::Matrix3 xyz = spectra::xyz_from_rgb(spectra::kRec709);
  const spectra::Triple white = spectra::xyz_of(spectra::kWhiteD65);
  const auto lab = [&](const Image& image, std::size_t i) {
    return spectra::lab_of(spectra::times(xyz, {image.channels[0].values[i], image.channels[1].values[i],
                                                image.channels[2].values[i]}),
                           white);
  };
  for (const std::size_t i : pixels) {
    const double difference = spectra::delta_e2000(lab(*seen_reference, i), lab(*seen_test, i));
    result.mean_delta_e += difference / count;
    result.most_delta_e = std::max(result.most_delta_e, difference);
  }
  return result;
}

std::string to_text(const SpectralComparison& comparison) {
  std::string text = absl::StrFormat("%d x %d pixels, %u not finite\n%12s %14s %14s %9s %12s\n",
                                     comparison.width, comparison.height, comparison.non_finite_pixels,
                                     "band (nm)", "reference", "test", "bias (%)", "relMSE");
  for (const BandError& band : comparison.bands)
    absl::StrAppendFormat(&text, "%12.3f %14.6g %14.6g %+9.3f %12.4e\n", band.centre_nm, band.mean_reference,
                          band.mean_test, band.bias_percent, band.relmse);
  absl::StrAppendFormat(&text, "CIEDE2000: mean %.4f, greatest %.4f", comparison.mean_delta_e,
                        comparison.most_delta_e);
  return text;
}

std::string to_json(const SpectralComparison& comparison) {
  nlohmann::ordered_json bands = nlohmann::ordered_json::array();
  for (const BandError& band : comparison.bands)
    bands.push_back({{"nm", band.centre_nm},
                     {"mean_ref", band.mean_reference},
                     {"mean_test", band.mean_test},
                     {"bias_percent", band.bias_percent},
                     {"relmse", band.relmse}});
  return nlohmann::ordered_json{{"size", {comparison.width, comparison.height}},
                                {"non_finite_pixels", comparison.non_finite_pixels},
                                {"bands", std::move(bands)},
                                {"mean_delta_e", comparison.mean_delta_e},
                                {"most_delta_e", comparison.most_delta_e}}
      .dump();
}

}  // namespace tessera::client
