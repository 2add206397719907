#include "photometry/annual/annual_metrics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace tessera::photometry {
namespace {

constexpr double kSpatialTarget = 300, kSpatialShare = 0.5;
constexpr double kDirectSun = 1000;
constexpr int kMostHoursOfDirectSun = 250;

absl::Status check(const SkyPatches& patches, const DaylightCoefficients& coefficients,
                   const AnnualOptions& options) {
  const std::size_t expected = coefficients.points * patches.size();
  if (coefficients.all.size() != expected ||
      (!coefficients.direct.empty() && coefficients.direct.size() != expected)) {
    return absl::InvalidArgumentError(absl::StrCat("daylight coefficients are ", coefficients.points,
                                                   " points x ", patches.size(), " patches, not ",
                                                   coefficients.all.size()));
  }
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::ranges::all_of(coefficients.all, finite) || !std::ranges::all_of(coefficients.direct, finite))
    return absl::InvalidArgumentError("a daylight coefficient is not finite");
  if (!(options.first_hour >= 0 && options.first_hour < options.last_hour && options.last_hour <= 24)) {
    return absl::InvalidArgumentError(absl::StrCat("hours of occupancy from ", options.first_hour, " to ",
                                                   options.last_hour,
                                                   " are none; they ascend within 0 and 24"));
  }
  if (!(options.target_lux > 0 && std::isfinite(options.target_lux)))
    return absl::InvalidArgumentError(absl::StrCat("a target of ", options.target_lux, " lx is not above 0"));
  return absl::OkStatus();
}

double illuminance(std::span<const double> coefficients, std::size_t point, std::span<const double> vector) {
  const std::span<const double> row = coefficients.subspan(point * vector.size(), vector.size());
  return std::inner_product(row.begin(), row.end(), vector.begin(), 0.0);
}

/// Counts an hour; shares are counts until the end.
void count(double lux, const AnnualOptions& options, PointMetrics& point) {
  point.daylight_autonomy += lux >= options.target_lux;
  point.continuous_daylight_autonomy += std::clamp(lux / options.target_lux, 0.0, 1.0);
  point.daylight_autonomy_300 += lux >= kSpatialTarget;
  (lux < 100     ? point.udi_low
   : lux < 300   ? point.udi_supplementary
   : lux <= 3000 ? point.udi_autonomous
                 : point.udi_exceeded) += 1;
  point.mean_lux += lux;
}

void divide(double hours, PointMetrics& point) {
  for (double* const share : {&point.daylight_autonomy, &point.continuous_daylight_autonomy,
                              &point.daylight_autonomy_300, &point.udi_low, &point.udi_supplementary,
                              &point.udi_autonomous, &point.udi_exceeded, &point.mean_lux})
    *share /= hours;
}

}  // namespace

bool is_occupied(const WeatherHour& hour, const AnnualOptions& options) {
  return hour.hour - 1 >= options.first_hour && hour.hour <= options.last_hour;
}

absl::StatusOr<AnnualMetrics> annual_metrics(const Weather& weather, const SkyPatches& patches,
                                             const DaylightCoefficients& coefficients,
                                             const AnnualOptions& options) {
  if (auto s = check(patches, coefficients, options); !s.ok()) return s;
  AnnualMetrics metrics;
  metrics.points.resize(coefficients.points);
  const std::vector<double> night(patches.size(), 0.0);
  for (const WeatherHour& hour : weather.hours) {
    if (!is_occupied(hour, options)) continue;
    const WeatherSky now = sky_of(weather, hour, options.ground_reflectance);
    if (!now.has_data) {
      ++metrics.hours_without_data;
      continue;
    }
    ++metrics.occupied_hours;
    const std::vector<double> all = now.sky ? sky_vector(patches, *now.sky, options.sun) : night;
    const std::vector<double> sun =
        now.sky && !coefficients.direct.empty() ? sun_vector(patches, *now.sky, options.sun) : night;
    if (now.sky) metrics.mean_outside_lux += horizontal_illuminance(*now.sky);
    for (std::size_t i = 0; i < coefficients.points; ++i) {
      count(illuminance(coefficients.all, i, all), options, metrics.points[i]);
      if (!coefficients.direct.empty())
        metrics.points[i].hours_of_direct_sun += illuminance(coefficients.direct, i, sun) > kDirectSun;
    }
  }
  if (metrics.occupied_hours == 0)
    return absl::InvalidArgumentError("no hour of the weather file is within the hours of occupancy");

  const double hours = metrics.occupied_hours;
  metrics.mean_outside_lux /= hours;
  double enough = 0, exposed = 0;
  for (PointMetrics& point : metrics.points) {
    divide(hours, point);
    enough += point.daylight_autonomy_300 >= kSpatialShare;
    exposed += point.hours_of_direct_sun > kMostHoursOfDirectSun;
  }
  if (!metrics.points.empty()) {
    metrics.spatial_daylight_autonomy = enough / static_cast<double>(metrics.points.size());
    metrics.annual_sunlight_exposure = exposed / static_cast<double>(metrics.points.size());
  }
  return metrics;
}

}  // namespace tessera::photometry
