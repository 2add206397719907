#include "render/scene/view/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "spectra/light/daylight.h"
#include "spectra/sensor/sensor_response.h"

namespace tessera::render {
namespace {

using spectra::SensorResponse;
using spectra::Triple;

static_assert(kFirstNm == spectra::kLeastSensorNm && kLastNm == spectra::kMostSensorNm);

absl::StatusOr<std::vector<spectra::Curve>> sensitivities_of(const v1::Film& film) {
  if (film.sensitivities_size() != 1 && film.sensitivities_size() != 3) {
    return absl::InvalidArgumentError(absl::StrCat(
        "film: sensor 'film' needs one or three sensitivities; it has ", film.sensitivities_size()));
  }
  std::vector<spectra::Curve> curves;
  for (int i = 0; i < film.sensitivities_size(); ++i) {
    const v1::SampledSpectrum& own = film.sensitivities(i);
    curves.push_back({{own.wavelengths_nm().begin(), own.wavelengths_nm().end()},
                      {own.values().begin(), own.values().end()}});
    const spectra::Curve& curve = curves.back();
    const auto fault = [&](absl::string_view what) {
      return absl::InvalidArgumentError(absl::StrCat("film: sensitivity ", i + 1, ": ", what));
    };
    if (const absl::Status status = spectra::check_curve(curve); !status.ok()) return fault(status.message());
    if (std::ranges::any_of(curve.values, [](float value) { return value < 0; }))
      return fault("a value is negative");
    if (curve.nm.size() < 2 || curve.nm.back() <= kFirstNm || curve.nm.front() >= kLastNm)
      return fault(
          absl::StrCat("two samples or more between ", kFirstNm, " and ", kLastNm, " nm were expected"));
  }
  return curves;
}

/// Quantiles of the wavelengths by what the sensor and the bands see of them, half each where there are
/// bands; and of all of them by a little, so that no weight is without bound.
std::vector<WavelengthQuantile> quantiles_of(const SensorResponse& sensor, const spectra::Bands& bands) {
  constexpr int kQuantiles = 256;
  constexpr double kEvenPart = 0.02;
  double from = sensor.from_nm, to = sensor.to_nm;
  if (bands.count > 0) from = std::min(from, bands.from_nm), to = std::max(to, bands.to_nm);
  // The density is constant between neighbouring nodes.
  std::vector<double> nodes = {from, to, sensor.from_nm, sensor.to_nm};
  if (bands.count > 0) nodes.insert(nodes.end(), {bands.from_nm, bands.to_nm});
  for (double nm = std::ceil(from); nm < to; ++nm) nodes.push_back(nm);
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  const auto is_in = [](double nm, double begin, double end) { return nm > begin && nm < end; };
  const auto seen_at = [&](double nm) {
    if (!is_in(nm, sensor.from_nm, sensor.to_nm)) return 0.0;
    const double place = nm - sensor.first_nm();
    const auto row = static_cast<std::size_t>(place);
    return std::lerp(sensor.sensitivity[row], sensor.sensitivity[row + 1], place - static_cast<double>(row));
  };
  std::vector<double> seen, cumulative = {0};
  double sum = 0;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    seen.push_back(seen_at((nodes[i] + nodes[i + 1]) / 2) * (nodes[i + 1] - nodes[i]));
    sum += seen.back();
  }
  const double of_bands = bands.count > 0 ? 0.5 : 0;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double width = nodes[i + 1] - nodes[i], middle = (nodes[i] + nodes[i + 1]) / 2;
    double probability = (1 - of_bands) * seen[i] / sum;
    if (bands.count > 0 && is_in(middle, bands.from_nm, bands.to_nm))
      probability += of_bands * width / (bands.to_nm - bands.from_nm);
    cumulative.push_back(cumulative.back() + (1 - kEvenPart) * probability + kEvenPart * width / (to - from));
  }
  std::vector<double> bounds;
  for (int k = 0; k <= kQuantiles; ++k) {
    const double wanted = cumulative.back() * k / kQuantiles;
    const auto above = std::lower_bound(cumulative.begin() + 1, cumulative.end() - 1, wanted);
    const auto i = static_cast<std::size_t>(above - cumulative.begin());
    bounds.push_back(std::lerp(nodes[i - 1], nodes[i],
                               (wanted - cumulative[i - 1]) / (cumulative[i] - cumulative[i - 1])));
  }
  std::vector<WavelengthQuantile> quantiles;
  for (int k = 0; k < kQuantiles; ++k)
    quantiles.push_back({static_cast<float>(bounds[k]), static_cast<float>(bounds[k + 1] - bounds[k])});
  return quantiles;
}

}  // namespace

absl::StatusOr<SensitivityTable> build_sensitivity(const wire::FilmSensor& asked, const v1::Film& film) {
  std::vector<spectra::Curve> own;
  if (asked.sensor.kind == spectra::SensorKind::kFilm) {
    auto curves = sensitivities_of(film);
    if (!curves.ok()) return curves.status();
    own = *std::move(curves);
  }
  auto response = spectra::sensor_response(asked.sensor, asked.white, asked.space, own);
  if (!response.ok()) return absl::InvalidArgumentError(absl::StrCat("film: ", response.status().message()));

  SensitivityTable table;
  table.quantiles = quantiles_of(*response, asked.bands);
  table.from_nm = static_cast<float>(response->from_nm), table.to_nm = static_cast<float>(response->to_nm);
  const spectra::Curve white = asked.white ? *asked.white : spectra::unit_d65();
  const Triple of_white = spectra::seen(*response, white);
  for (int i = 0; i < kCurveSamples; ++i) {
    // Beside the ends of what is seen, rows go on, so that lines reach them.
    const double nm = kFirstNm + i, row = nm - response->first_nm();
    const bool has_row = row >= 0 && row < static_cast<double>(response->rows.size());
    const Triple here = has_row ? response->rows[static_cast<std::size_t>(row)] : Triple{0, 0, 0};
    for (std::size_t c = 0; c < 3; ++c) {
      table.light.push_back(static_cast<float>(here[c]));
      table.matter.push_back(static_cast<float>(here[c] * white.at(nm) / of_white[c]));
    }
    table.light.push_back(0), table.matter.push_back(0);
  }
  if (asked.bands.count > 0) {
    table.bands = asked.bands.count;
    table.first_band_nm = static_cast<float>(asked.bands.from_nm);
    table.bands_per_nm = static_cast<float>(1 / asked.bands.width());
  }
  return table;
}

}  // namespace tessera::render
