#include "photometry/sky/sky.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "photometry/sky/cie_sky.h"
#include "photometry/sky/perez_sky.h"
#include "photometry/sky/sky_map.h"
#include "photometry/sun/sun_irradiance.h"

namespace tessera::photometry {
namespace {

using std::numbers::pi;

TEST(Sky, GivesTheIlluminancesItIsMadeFor) {
  const HorizonDirection sun = toward(35, 200);
  const Sky sky =
      make_sky(cie_pattern(12).value(), sun, {.diffuse_horizontal = 14'000, .sun_normal = 80'000}, 0.25);
  EXPECT_NEAR(diffuse_horizontal_illuminance(sky), 14'000, 1e-6);
  EXPECT_NEAR(sun_horizontal_illuminance(sky), 80'000 * std::sin(35 * kRadiansPerDegree), 1e-6);
  const double both = 14'000 + 80'000 * std::sin(35 * kRadiansPerDegree);
  EXPECT_NEAR(horizontal_illuminance(sky), both, 1e-6);
  // The ground is lit by both, and diffuse.
  EXPECT_NEAR(luminance(sky, toward(-10, 3)), 0.25 * both / pi, 1e-6);
  EXPECT_EQ(luminance(sky, toward(-10, 3)), luminance(sky, toward(-80, 100)));
}

TEST(Sky, DirectionsComeBackFromTheirAngles) {
  for (const double altitude : {-80.0, -5.0, 0.0, 33.0, 89.0}) {
    for (const double azimuth : {0.0, 90.0, 181.0, 359.0}) {
      const HorizonDirection w = toward(altitude, azimuth);
      EXPECT_NEAR(altitude_degrees(w), altitude, 1e-10);
      EXPECT_NEAR(azimuth_degrees(w), azimuth, 1e-10);
    }
  }
  EXPECT_NEAR(toward(0, 90).east, 1, 1e-15);
  // Precise for angles whose cosine is 1 in doubles.
  EXPECT_NEAR(angle_between(toward(45, 10), toward(45 + 1e-7, 10)) / kRadiansPerDegree, 1e-7, 1e-14);
}

/// [Perez1990]: what a sky without sun has, and how much clearness grows.
TEST(PerezSky, ClearnessIsOneWithoutSun) {
  for (const double zenith : {0.0, 0.7, 1.5})
    EXPECT_DOUBLE_EQ(perez_weather({.direct_normal = 0, .diffuse_horizontal = 120}, zenith, 1367).clearness,
                     1);
  // In the zenith: (diffuse + direct) / diffuse. A brightness of one air mass.
  const PerezWeather noon = perez_weather({.direct_normal = 900, .diffuse_horizontal = 100}, 0, 1367);
  EXPECT_DOUBLE_EQ(noon.clearness, 10);
  EXPECT_NEAR(noon.brightness, 100.0 / 1367, 1e-4);
}

/// Mean efficacies that [Perez1990] and others report: some 110 to 120 lm/W of overcast skies, 120 to 140 of
/// clear ones, 90 to 110 of a high sun.
TEST(PerezSky, EfficaciesAreThoseOfDaylight) {
  const double zenith = 40 * kRadiansPerDegree;
  const Irradiances overcast{.direct_normal = 0, .diffuse_horizontal = 200}, clear{850, 90};
  const Daylight dull = perez_daylight(overcast, perez_weather(overcast, zenith, 1367), zenith, 11);
  EXPECT_GT(dull.diffuse_horizontal / 200, 105);
  EXPECT_LT(dull.diffuse_horizontal / 200, 125);
  EXPECT_EQ(dull.sun_normal, 0);
  const Daylight bright = perez_daylight(clear, perez_weather(clear, zenith, 1367), zenith, 11);
  EXPECT_GT(bright.diffuse_horizontal / 90, 120);
  EXPECT_LT(bright.diffuse_horizontal / 90, 145);
  EXPECT_GT(bright.sun_normal / 850, 90);
  EXPECT_LT(bright.sun_normal / 850, 110);
}

TEST(PerezSky, IsBrightAboutTheSunWhereClearAndInTheZenithWhereOvercast) {
  const HorizonDirection sun = toward(40, 180);
  const double zenith = 50 * kRadiansPerDegree;
  const SkyPattern clear = perez_pattern({.clearness = 7, .brightness = 0.12}, zenith);
  EXPECT_GT(relative_luminance(clear, toward(45, 180), sun),
            3 * relative_luminance(clear, toward(40, 0), sun));
  const SkyPattern overcast = perez_pattern({.clearness = 1, .brightness = 0.2}, zenith);
  EXPECT_GT(relative_luminance(overcast, toward(90, 0), sun),
            1.5 * relative_luminance(overcast, toward(5, 0), sun));
}

TEST(PerezSky, IsSoundForAllThatAWeatherFileMayHold) {
  for (const double diffuse : {0.0, 1.0, 40.0, 300.0, 900.0}) {
    for (const double direct : {0.0, 1.0, 30.0, 400.0, 1100.0}) {
      for (const double altitude : {0.01, 3.0, 20.0, 45.0, 90.0}) {
        const HorizonDirection sun = toward(altitude, 100);
        const double zenith = (90 - altitude) * kRadiansPerDegree;
        const Irradiances measured{direct, diffuse};
        const PerezWeather weather = perez_weather(measured, zenith, kSolarConstant);
        const Daylight daylight = perez_daylight(measured, weather, zenith, 11);
        const Sky sky = make_sky(perez_pattern(weather, zenith), sun, daylight, 0.2);
        EXPECT_NEAR(diffuse_horizontal_illuminance(sky), daylight.diffuse_horizontal,
                    1e-9 * daylight.diffuse_horizontal);
        for (const double up : {0.1, 20.0, 60.0, 90.0}) {
          const double seen = luminance(sky, toward(up, 100));
          EXPECT_TRUE(std::isfinite(seen) && seen >= 0) << diffuse << " " << direct << " " << altitude;
        }
      }
    }
  }
}

TEST(SkyMap, PlacesAreDirectionsOfEqualSolidAngles) {
  constexpr int kSize = 64;
  HorizonDirection mean{0, 0, 0}, square{0, 0, 0};
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const HorizonDirection w = direction_of_map((x + 0.5) / kSize, (y + 0.5) / kSize);
      EXPECT_NEAR(cosine_between(w, w), 1, 1e-12);
      mean.east += w.east, mean.north += w.north, mean.up += w.up;
      square.east += w.east * w.east, square.north += w.north * w.north, square.up += w.up * w.up;
    }
  }
  constexpr double kCells = kSize * kSize;
  for (const double sum : {mean.east, mean.north, mean.up}) EXPECT_NEAR(sum / kCells, 0, 1e-12);
  // A third each; a cell's middle differs from its mean by the square of its width, 0.05^2.
  for (const double sum : {square.east, square.north, square.up}) EXPECT_NEAR(sum / kCells, 1.0 / 3, 1e-3);
  EXPECT_NEAR(direction_of_map(0.5, 0.5).up, 1, 1e-12);
  EXPECT_NEAR(direction_of_map(0, 0).up, -1, 1e-12);
  EXPECT_NEAR(direction_of_map(1, 0.5).east, 1, 1e-12);
  EXPECT_NEAR(direction_of_map(0.5, 1).north, 1, 1e-12);
  EXPECT_GT(direction_of_map(0.4, 0.55).up, 0);
}

TEST(SkyMap, CellsHaveTheLuminanceOfTheirMiddles) {
  constexpr int kSize = 128;
  const HorizonDirection sun = toward(40, 120);
  const Sky sky =
      make_sky(cie_pattern(12).value(), sun, {.diffuse_horizontal = 12'000, .sun_normal = 9e4}, 0.2);
  const std::vector<float> map = sky_map(sky, kSize);
  int compared = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const HorizonDirection w = direction_of_map((x + 0.5) / kSize, (y + 0.5) / kSize);
      // Means differ where luminance bends: at the sun, and at the horizon, where the ground begins.
      if (std::abs(w.up) < 0.06 || angle_between(w, sun) < 0.2) continue;
      const double exact = luminance(sky, w);
      EXPECT_NEAR(map[static_cast<std::size_t>(y * kSize + x)] / exact, 1, 2e-3) << x << " " << y;
      ++compared;
    }
  }
  EXPECT_GT(compared, kSize * kSize * 9 / 10);
}

/// By points that are not those the map was made with.
TEST(SkyMap, HasTheIlluminanceOfTheSky) {
  constexpr int kSize = 64, kSteps = 5;
  for (const int type : {1, 5, 12, 15, 16}) {
    const Sky sky = make_sky(cie_pattern(type).value(), toward(20, 300), {.diffuse_horizontal = 10'000}, 0.5);
    const std::vector<float> map = sky_map(sky, kSize);
    double up = 0;
    for (int y = 0; y < kSize * kSteps; ++y) {
      for (int x = 0; x < kSize * kSteps; ++x) {
        const double cosine = direction_of_map((x + 0.5) / (kSize * kSteps), (y + 0.5) / (kSize * kSteps)).up;
        up += std::max(cosine, 0.0) * map[static_cast<std::size_t>(y / kSteps * kSize + x / kSteps)];
      }
    }
    up *= 4 * pi / (kSize * kSize * kSteps * kSteps);
    // Cells on the horizon have the ground in them, too, at cosines up to 0.05 of an area of 2 pi 0.05 / 2:
    // 1e-3.
    EXPECT_NEAR(up / 10'000, 1, 2e-3) << type;
  }
}

TEST(SkyMap, BelowTheHorizonIsTheGround) {
  const Sky sky = make_sky(cie_pattern(5).value(), toward(20, 0), {.diffuse_horizontal = 1000}, 0.3);
  const std::vector<float> map = sky_map(sky, 32);
  EXPECT_FLOAT_EQ(map.front(), static_cast<float>(0.3 * 1000 / pi));
  // The sky makes up for its light in cells that are half below the horizon: 124 of 1024, whose upper halves
  // have cosines of 0.03 or so, are 0.3 % of its illuminance.
  EXPECT_NEAR(map[16 * 32 + 16] / (1000 / pi), 1, 4e-3);
  EXPECT_NEAR(sky_map(sky, 512)[256 * 512 + 256] / (1000 / pi), 1, 4e-3 / (16 * 16));
}

/// Looks up what a renderer does, row by row.
double illuminance_of(const SunColumn& column) {
  const double step = pi / (column.rows - 1);
  constexpr int kSteps = 64;
  double sum = 0;
  for (int row = 0; row <= column.lit_rows; ++row) {
    for (int i = 0; i < kSteps; ++i) {
      const double x = row + (i + 0.5) / kSteps, angle = x * step;
      const double share = std::clamp(column.lit_rows - x, 0.0, 1.0);
      sum += share * column.luminance * 2 * pi * std::sin(angle) * std::cos(angle) * step / kSteps;
    }
  }
  return sum;
}

TEST(SunColumn, GivesTheIlluminanceOfTheSun) {
  for (const double degrees : {0.01, 0.533, 5.0, 60.0, 90.0}) {
    const SunColumn column = sun_column(degrees, 1e5);
    // The midpoint rule with 64 steps a row, of 32 rows across the radius: (1 / 2048)^2.
    EXPECT_NEAR(illuminance_of(column) / 1e5, 1, 1e-6) << degrees;
    const double radius = (column.lit_rows - 0.5) * pi / (column.rows - 1) / kRadiansPerDegree;
    EXPECT_NEAR(2 * radius / degrees, 1, 0.5 / (column.rows - 1)) << degrees;
  }
  // 1.6e9 cd/m^2 is what the sun has at noon of a clear day: 100,000 lx over 6.8e-5 sr.
  EXPECT_NEAR(sun_column(0.533, 1e5).luminance,
              1e5 / (pi * std::pow(std::sin(0.2665 * kRadiansPerDegree), 2)), 2e6);
}

}  // namespace
}  // namespace tessera::photometry
