#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <tuple>
#include <vector>

#include "photometry/annual/annual_metrics.h"
#include "photometry/sky/cie_sky.h"

namespace tessera::photometry {
namespace {

using std::numbers::pi;
using testing::HasSubstr;

TEST(SkyPatches, AreThoseOfTregenzaAndReinhart) {
  EXPECT_EQ(SkyPatches::tregenza().size(), 145u + 1);
  EXPECT_EQ(SkyPatches::reinhart(2).size(), 577u + 1);
  EXPECT_EQ(SkyPatches::reinhart(4).size(), 2305u + 1);
  // Rows of 12 degrees, 30 patches in the lowest; the first one in the north.
  const SkyPatch& first = SkyPatches::tregenza().sky(1);
  EXPECT_NEAR(first.high / kRadiansPerDegree, 12, 1e-12);
  EXPECT_NEAR(first.azimuth_width / kRadiansPerDegree, 12, 1e-12);
  EXPECT_NEAR(first.middle().east, 0, 1e-12);
  EXPECT_NEAR(SkyPatches::tregenza().sky(145).low / kRadiansPerDegree, 84, 1e-12);
}

TEST(SkyPatches, CoverTheSkyOnce) {
  for (const int factor : {1, 2, 3}) {
    const SkyPatches patches = SkyPatches::reinhart(factor);
    double solid_angle = 0, integral = 0;
    for (std::size_t number = 1; number < patches.size(); ++number) {
      const SkyPatch& patch = patches.sky(number);
      solid_angle += patch.solid_angle(), integral += patch.horizontal_integral();
      EXPECT_EQ(patches.number_of(patch.middle()), number);
      for (const double u : {0.01, 0.99}) {
        for (const double v : {0.01, 0.99}) EXPECT_EQ(patches.number_of(patch.at(u, v)), number);
      }
      EXPECT_EQ(patches.nearest(patch.middle(), 1).front(), number);
    }
    EXPECT_NEAR(solid_angle, 2 * pi, 1e-12);
    EXPECT_NEAR(integral, pi, 1e-12);
    EXPECT_EQ(patches.number_of(toward(-1, 50)), 0u);
    EXPECT_EQ(patches.number_of(toward(90, 0)), patches.size() - 1);
  }
}

double sum(const SkyPatches& patches, const std::vector<double>& vector, double (SkyPatch::*weight)() const) {
  double total = 0;
  for (std::size_t number = 1; number < patches.size(); ++number)
    total += vector[number] * (patches.sky(number).*weight)();
  return total;
}

TEST(SkyVector, HasTheIlluminancesOfSkyAndSun) {
  const SkyPatches patches = SkyPatches::tregenza();
  for (const int type : {1, 5, 12, 14}) {
    const Sky sky = make_sky(cie_pattern(type).value(), toward(33, 250),
                             {.diffuse_horizontal = 20'000, .sun_normal = 70'000}, 0.2);
    const std::vector<double> without = sky_vector(patches, sky, SunPlacement::kNone);
    EXPECT_NEAR(sum(patches, without, &SkyPatch::horizontal_integral), 20'000, 1e-6) << type;
    EXPECT_EQ(without[0], sky.ground_luminance);
    for (const SunPlacement placement : {SunPlacement::kOwnPatch, SunPlacement::kNearest4}) {
      const std::vector<double> sun = sun_vector(patches, sky, placement),
                                all = sky_vector(patches, sky, placement);
      EXPECT_NEAR(sum(patches, sun, &SkyPatch::solid_angle), 70'000, 1e-6) << type;
      for (std::size_t i = 0; i < all.size(); ++i)
        EXPECT_NEAR(all[i], without[i] + sun[i], 1e-9 * (1 + all[i]));
      EXPECT_GT(sun[patches.number_of(sky.sun)], 0);
    }
  }
}

TEST(SkyVector, OfAUniformSkyIsUniform) {
  const SkyPatches patches = SkyPatches::reinhart(2);
  const Sky sky = make_sky(cie_pattern(5).value(), toward(20, 0), {.diffuse_horizontal = 1000 * pi}, 0);
  const std::vector<double> vector = sky_vector(patches, sky, SunPlacement::kNearest4);
  for (std::size_t number = 1; number < vector.size(); ++number) EXPECT_NEAR(vector[number], 1000, 1e-6);
}

/// A year without sun whose skies have the same irradiance all day.
Weather overcast_year(double diffuse) {
  Weather weather;
  weather.place = {48, 11};
  weather.utc_offset_hours = 1;
  constexpr int kDays[12] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  for (int month = 1; month <= 12; ++month) {
    for (int day = 1; day <= kDays[month - 1]; ++day) {
      for (int hour = 1; hour <= 24; ++hour)
        weather.hours.push_back({.year = 2001,
                                 .month = month,
                                 .day = day,
                                 .hour = hour,
                                 .direct_normal = 0,
                                 .diffuse_horizontal = diffuse});
    }
  }
  return weather;
}

/// Coefficients of a horizontal point under open sky, times a factor.
std::vector<double> open_point(const SkyPatches& patches, double factor) {
  std::vector<double> row(patches.size(), 0.0);
  for (std::size_t number = 1; number < patches.size(); ++number)
    row[number] = factor * patches.sky(number).horizontal_integral();
  return row;
}

std::vector<double> together(std::initializer_list<std::vector<double>> rows) {
  std::vector<double> all;
  for (const std::vector<double>& row : rows) all.insert(all.end(), row.begin(), row.end());
  return all;
}

TEST(AnnualMetrics, CountHoursOfOccupancy) {
  const SkyPatches patches = SkyPatches::tregenza();
  const std::vector<double> all =
      together({open_point(patches, 1), open_point(patches, 0.02), open_point(patches, 0)});
  const auto metrics = annual_metrics(overcast_year(100), patches, {.points = 3, .all = all, .direct = {}});
  ASSERT_TRUE(metrics.ok()) << metrics.status();
  EXPECT_EQ(metrics->occupied_hours, 3650);
  const auto& [open, dim, dark] = std::tie(metrics->points[0], metrics->points[1], metrics->points[2]);
  EXPECT_NEAR(open.mean_lux / metrics->mean_outside_lux, 1, 1e-9);
  EXPECT_NEAR(dim.mean_lux / metrics->mean_outside_lux, 0.02, 1e-9);
  for (const PointMetrics& point : metrics->points) {
    EXPECT_NEAR(point.udi_low + point.udi_supplementary + point.udi_autonomous + point.udi_exceeded, 1,
                1e-12);
    EXPECT_GE(point.continuous_daylight_autonomy, point.daylight_autonomy);
    EXPECT_EQ(point.daylight_autonomy, point.daylight_autonomy_300);
  }
  // 100 W/m^2 are 9,000 to 13,000 lx wherever the sun is up: more than 3000 lx, or night.
  EXPECT_NEAR(open.udi_exceeded + open.udi_low, 1, 1e-12);
  EXPECT_EQ(open.daylight_autonomy, open.udi_exceeded);
  // A fiftieth of it by day: supplementary, and less than the target.
  EXPECT_EQ(dim.udi_supplementary, open.udi_exceeded);
  EXPECT_EQ(dim.daylight_autonomy, 0);
  EXPECT_NEAR(dim.continuous_daylight_autonomy, dim.mean_lux / 300, 1e-12);
  EXPECT_EQ(dark.udi_low, 1);
  EXPECT_NEAR(metrics->spatial_daylight_autonomy, 1.0 / 3, 1e-12);
  EXPECT_EQ(metrics->annual_sunlight_exposure, 0);
}

TEST(AnnualMetrics, CountHoursOfDirectSun) {
  Weather sunny = overcast_year(50);
  for (WeatherHour& hour : sunny.hours) hour.direct_normal = 600;
  const SkyPatches patches = SkyPatches::tregenza();
  const std::vector<double> all = together({open_point(patches, 1), open_point(patches, 0.3)});
  const std::vector<double> direct = together({open_point(patches, 1), open_point(patches, 0)});
  const auto metrics = annual_metrics(sunny, patches, {.points = 2, .all = all, .direct = direct},
                                      {.first_hour = 10, .last_hour = 14});
  ASSERT_TRUE(metrics.ok()) << metrics.status();
  EXPECT_EQ(metrics->occupied_hours, 4 * 365);
  // 600 W/m^2 of a sun that is up 15 degrees at least in those hours: 60,000 lx times 0.25 and more, every
  // hour.
  EXPECT_EQ(metrics->points[0].hours_of_direct_sun, 4 * 365);
  EXPECT_EQ(metrics->points[1].hours_of_direct_sun, 0);
  EXPECT_EQ(metrics->annual_sunlight_exposure, 0.5);
}

TEST(AnnualMetrics, LeaveOutAndCountHoursWithoutData) {
  Weather weather = overcast_year(100);
  for (std::size_t i = 0; i < weather.hours.size(); ++i)
    if (weather.hours[i].hour == 13 && weather.hours[i].month == 6)
      weather.hours[i].diffuse_horizontal.reset();
  const SkyPatches patches = SkyPatches::tregenza();
  const std::vector<double> all = open_point(patches, 1);
  const auto metrics = annual_metrics(weather, patches, {.points = 1, .all = all, .direct = {}});
  ASSERT_TRUE(metrics.ok());
  EXPECT_EQ(metrics->hours_without_data, 30);
  EXPECT_EQ(metrics->occupied_hours, 3650 - 30);
}

TEST(AnnualMetrics, RefuseWhatMakesNoSense) {
  const SkyPatches patches = SkyPatches::tregenza();
  const Weather weather = overcast_year(100);
  std::vector<double> all = open_point(patches, 1);
  const auto refusal = [&](const DaylightCoefficients& coefficients, const AnnualOptions& options = {}) {
    return std::string(annual_metrics(weather, patches, coefficients, options).status().message());
  };
  EXPECT_THAT(refusal({.points = 2, .all = all, .direct = {}}), HasSubstr("2 points x 146 patches, not 146"));
  EXPECT_THAT(refusal({.points = 1, .all = all, .direct = {}}, {.first_hour = 18, .last_hour = 8}),
              HasSubstr("from 18 to 8 are none"));
  EXPECT_THAT(refusal({.points = 1, .all = all, .direct = {}}, {.first_hour = 8.2, .last_hour = 8.9}),
              HasSubstr("no hour of the weather file"));
  EXPECT_THAT(refusal({.points = 1, .all = all, .direct = {}}, {.target_lux = 0}), HasSubstr("not above 0"));
  all[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal({.points = 1, .all = all, .direct = {}}), HasSubstr("not finite"));
}

}  // namespace
}  // namespace tessera::photometry
