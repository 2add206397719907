// Daylight of a year: how often there is enough of it, and how often too much.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "photometry/annual/sky_patches.h"
#include "photometry/annual/sky_vector.h"
#include "photometry/weather/weather.h"

namespace tessera::photometry {

struct AnnualOptions {
  double target_lux = 300;                // of daylight autonomy
  double first_hour = 8, last_hour = 18;  // of occupancy, every day, by the clock
  double ground_reflectance = 0.2;
  SunPlacement sun = SunPlacement::kNearest4;
};

/// Illuminances in lx of points by each patch of 1 cd/m^2, the ground's first: points x patches, a row a
/// point.
struct DaylightCoefficients {
  std::size_t points = 0;
  std::span<const double> all;  // by all light
  /// Light straight from the patches, through openings and glass alone: for the hours of direct sun.
  /// Empty: none.
  std::span<const double> direct;
};

/// Shares of the occupied hours, 0 to 1.
struct PointMetrics {
  double daylight_autonomy = 0;             // at or above the target
  double continuous_daylight_autonomy = 0;  // the same, and the part of the target that other hours reach
  double daylight_autonomy_300 = 0;         // at or above 300 lx
  // Useful daylight illuminance [Mardaljevic2012]: below 100, to 300, to 3000 lx, above.
  double udi_low = 0, udi_supplementary = 0, udi_autonomous = 0, udi_exceeded = 0;
  double mean_lux = 0;
  int hours_of_direct_sun = 0;  // above 1000 lx by the sun alone
};

struct AnnualMetrics {
  std::vector<PointMetrics> points;
  int occupied_hours = 0;
  int hours_without_data = 0;   // occupied ones by day that the weather file has no radiation of; in no share
  double mean_outside_lux = 0;  // horizontal, of the occupied hours
  // [IESLM83]: sDA 300/50 %, the share of points with 300 lx in half of the hours at least; ASE 1000,250h,
  // the share with direct sun in more than 250 hours, 0 where no direct coefficients are there.
  double spatial_daylight_autonomy = 0;
  double annual_sunlight_exposure = 0;
};

/// Whether an hour, all of it, is within the hours of occupancy.
bool is_occupied(const WeatherHour& hour, const AnnualOptions& options);

/// Goes through the occupied hours of a year. Points count alike. InvalidArgument where the coefficients are
/// not points x patches or not finite, the hours of occupancy are none, or no hour of the year is occupied.
absl::StatusOr<AnnualMetrics> annual_metrics(const Weather& weather, const SkyPatches& patches,
                                             const DaylightCoefficients& coefficients,
                                             const AnnualOptions& options = {});

}  // namespace tessera::photometry
