// A hole instead of a lens, in kernels: its blur, the rings of its diffraction and its brightness against
// formulas, and connections against rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "optics/hole_diffraction.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/view/sensor.h"
#include "render/sensor/hole_table.h"
#include "render/sensor/sensor.h"
#include "support/kernel/chi2.h"
#include "support/kernel/kernel_scene.h"
#include "support/kernel/random_lanes.h"
#include "wire/algorithm.h"

namespace tessera::render::TESSERA_ISA {
namespace {

using std::numbers::pi;

constexpr FilmSize kFilm{40, 20};
constexpr unsigned kSeeds = 4;

/// A scene in metres. The film is 40 x 20 mm, a millimetre a pixel.
SensorRecord sensor_of(const std::string& hole, bool spectral = false) {
  v1::Camera message;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(
      absl::StrCat("pinhole { film_diagonal_mm: 44.72135955 ", hole, " }"), &message));
  const auto sensor =
      build_sensor(message, kFilm, render_space_about({0, 0, 0}), *wire::find_algorithm(""), spectral);
  EXPECT_TRUE(sensor.ok()) << sensor.status();
  return *sensor;
}

SensorSample random_sample(RandomLanes& numbers) {
  SensorSample sample{{numbers(0, 40), numbers(0, 20)}, {numbers(), numbers()}, Float(0.0f)};
  sample.wavelength = numbers(400, 700);
  return sample;
}

/// Light of a point on the axis, `metres` away: the distances from the middle of the film, mm, at which its
/// connections land.
std::vector<double> image_of_point(const SensorRecord& sensor, float metres, float wavelength,
                                   unsigned seed) {
  constexpr int kSamples = 1 << 17;
  const SensorConnection straight =
      connect_to_sensor(sensor, {Float(0.0f), Float(0.0f), Float(metres)}, {Float(.5f), Float(.5f)},
                        Float(0.0f), Mask::all(), Float(wavelength));
  std::vector<double> image;
  RandomLanes numbers(seed);
  for (int i = 0; i < kSamples; i += kWidth) {
    const SensorConnection seen =
        connect_to_sensor(sensor, {Float(0.0f), Float(0.0f), Float(metres)}, {numbers(), numbers()},
                          Float(0.0f), Mask::all(), Float(wavelength));
    for (int l = 0; l < kWidth; ++l) {
      image.push_back(std::hypot(seen.raster.x.lane(l) - straight.raster.x.lane(l),
                                 seen.raster.y.lane(l) - straight.raster.y.lane(l)));
    }
  }
  return image;
}

TEST(Hole, TheCircleOfBlurIsTheHolesShadow) {
  const SensorRecord sensor = sensor_of("hole_mm: 2 film_distance_mm: 50 diffraction: STRAIGHT");
  for (const float metres : {0.2f, 1.0f, 100.0f}) {
    const double radius = 1 * (1 + .05 / double{metres});
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      std::vector<double> image = image_of_point(sensor, metres, 550, seed);
      std::ranges::sort(image);
      EXPECT_NEAR(image.back(), radius, 1e-3 * radius);
      // Evenly lit: half of the light is within 1 / sqrt(2) of the radius. The median of 2^17 has a deviation
      // of 1e-3 of the radius, of which these are four.
      EXPECT_NEAR(image[image.size() / 2], radius * std::sqrt(.5), 4e-3 * radius);
    }
  }
}

/// With a scene distance, diffraction at that distance is exact, and far above the wavelength's scale the
/// shadow is right at any other distance.
TEST(Hole, SpreadsLightAsFresnelsIntegralDoes) {
  struct Case {
    double hole, scene_metres;
    float metres;
  };
  for (const Case& c : {Case{.07, 0, 1e6f}, {.15, 0, 1e6f}, {.35, 0, 1e6f}, {.6, .3, .3f}, {2, .2, .2f}}) {
    const SensorRecord sensor =
        sensor_of(absl::StrCat("hole_mm: ", c.hole, " film_distance_mm: 50 wavelength_nm: 500 ",
                               "scene_distance: ", c.scene_metres));
    const double farther = 1 + (c.scene_metres > 0 ? .05 / c.scene_metres : 0);
    const double shadow = c.hole / 2 * farther;
    const double fresnel_number = c.hole * c.hole / 4 * farther / (50 * 500e-6);
    // Rings of equal width, and all beyond.
    constexpr int kRings = 60;
    const double most = shadow * std::max(1.3, 1.5 / fresnel_number);
    std::vector<double> part(kRings + 1);
    constexpr int kSteps = 60;
    double all = 0;
    for (int i = 0; i < kRings * kSteps; ++i) {
      const double radius = (i + .5) / (kRings * kSteps) * most / shadow,
                   width = most / shadow / (kRings * kSteps);
      const double light = 2 * radius * optics::hole_irradiance(fresnel_number, radius) * width;
      part[static_cast<std::size_t>(i / kSteps)] += light;
      all += light;
    }
    part[kRings] = 1 - all;
    double log_of_all = 0;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      const std::vector<double> image = image_of_point(sensor, c.metres, 0, seed);
      std::vector<double> observed(kRings + 1), expected;
      for (const double p : part) expected.push_back(p * static_cast<double>(image.size()));
      for (const double radius : image)
        ++observed[std::min(static_cast<std::size_t>(radius / most * kRings), std::size_t{kRings})];
      log_of_all += std::log(std::max(test::chi_square_test(observed, expected).p_value, 1e-300));
    }
    EXPECT_GT(test::regularized_gamma_q(kSeeds, -log_of_all), test::sidak_level(0.01, 5)) << c.hole;
  }
}

/// Where the parabola has its least value that is nearest to values between two places.
double least_of_parabola(const std::vector<double>& values, std::size_t first, std::size_t end) {
  const double middle = static_cast<double>(first + end) / 2;
  double squares = 0, fourths = 0, sum = 0, slope = 0, bend = 0;
  for (std::size_t i = first; i < end; ++i) {
    const double x = static_cast<double>(i) + .5 - middle;
    squares += x * x, fourths += x * x * x * x;
    sum += values[i], slope += x * values[i], bend += x * x * values[i];
  }
  const auto count = static_cast<double>(end - first);
  const double a = (bend - squares * sum / count) / (fourths - squares * squares / count),
               b = slope / squares;
  return middle - b / (2 * a);
}

/// The first dark ring, found where the least light falls: times the radius cubed, light by area is alike on
/// both sides of it.
TEST(Hole, TheFirstDarkRingIsAirys) {
  for (const bool spectral : {false, true}) {
    const SensorRecord sensor = sensor_of("hole_mm: 0.07 film_distance_mm: 50 wavelength_nm: 500", spectral);
    for (const float nm : {450.0f, 500.0f, 620.0f}) {
      if (!spectral && nm != 500) continue;
      const double airy = 1.21967 * double{nm} * 1e-6 * 50 / .07;
      std::vector<double> light(200);
      for (unsigned seed = 0; seed < kSeeds; ++seed) {
        for (const double radius : image_of_point(sensor, 1e6f, nm, seed)) {
          const auto bin = static_cast<std::size_t>(radius / airy * 100);
          if (bin < light.size()) light[bin] += std::pow((static_cast<double>(bin) + .5) / 100, 2);
        }
      }
      EXPECT_NEAR(least_of_parabola(light, 80, 120), 100, 2) << nm;
    }
  }
}

/// Mean weight of rays from a place of the film, mm from its middle.
double weight_at(const SensorRecord& sensor, float x, unsigned seed) {
  constexpr int kSamples = 1 << 16;
  RandomLanes numbers(seed);
  double sum = 0;
  for (int i = 0; i < kSamples; i += kWidth) {
    const SensorRay ray =
        start_ray(sensor, {{Float(20 + x), Float(10.0f)}, {numbers(), numbers()}, Float(0.0f)});
    for (int l = 0; l < kWidth; ++l) sum += ray.weight.lane(l);
  }
  return sum / kSamples;
}

TEST(Hole, IlluminanceIsByTheHolesAreaAndTheFourthPowerOfTheCosine) {
  for (const char* const way : {"diffraction: STRAIGHT", ""}) {
    for (const double hole : {.2, 2.0}) {
      const std::string message = absl::StrCat("hole_mm: ", hole, " film_distance_mm: 25 ", way);
      const SensorRecord radiance = sensor_of(message),
                         plain = sensor_of(message + " brightness: IRRADIANCE");
      const double middle = pi * hole * hole / 4 / (hole * hole / 4 + 25 * 25);
      for (const float x : {0.0f, 10.0f, 19.0f}) {
        const double falloff = std::pow(1 + double{x} * double{x} / (25 * 25), -2);
        EXPECT_NEAR(weight_at(plain, x, 1), middle * falloff, 5e-3 * middle * falloff) << hole << " " << x;
        EXPECT_NEAR(weight_at(radiance, x, 1), falloff, 5e-3 * falloff) << hole << " " << x;
      }
    }
  }
}

TEST(Hole, ConnectionsLeadToWhereTheRayBegan) {
  for (const char* const way :
       {"hole_mm: 2 diffraction: STRAIGHT", "hole_mm: 0.3 scene_distance: 0.5", "hole_mm: 0.3"}) {
    for (const bool spectral : {false, true}) {
      const SensorRecord sensor = sensor_of(absl::StrCat(way, " film_distance_mm: 50"), spectral);
      EXPECT_EQ(sensor.disperses, spectral && sensor.hole->wavelengths > 1);
      RandomLanes numbers(5);
      for (int i = 0; i < 200; ++i) {
        const SensorSample sample = random_sample(numbers);
        const SensorRay ray = start_ray(sensor, sample);
        const Vec3 point = fma(ray.direction, exp(numbers(-2, 4)), ray.origin);
        const SensorConnection seen =
            connect_to_sensor(sensor, point, sample.u_lens, Float(0.0f), Mask::all(), sample.wavelength);
        for (int l = 0; l < kWidth; ++l) {
          ASSERT_NEAR(seen.raster.x.lane(l), sample.raster.x.lane(l), 2e-3);
          ASSERT_NEAR(seen.raster.y.lane(l), sample.raster.y.lane(l), 2e-3);
          ASSERT_NEAR(length(seen.lens - ray.origin).lane(l), 0, 1e-6);
          ASSERT_NEAR(seen.importance.lane(l), seen.density.lane(l) * ray.weight.lane(l),
                      1e-5 * seen.importance.lane(l));
        }
      }
    }
  }
}

/// The importance of points of a tilted plane, over all of a square of it, against the weights of rays that
/// meet that square, for columns of the film.
TEST(Hole, ImportanceIntegratesToTheWeightsOfRays) {
  constexpr int kSamples = 1 << 19;
  constexpr float kHalf = 1, kDepth = 1.5f, kTilt = .2f;  // depth of x: kDepth + kTilt x
  for (const char* const way : {"hole_mm: 12 diffraction: STRAIGHT", "hole_mm: 0.05 wavelength_nm: 700"}) {
    const SensorRecord sensor = sensor_of(absl::StrCat(way, " film_distance_mm: 30"));
    double log_of_all = 0;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      std::vector<double> by_ray(40), by_point(40), variance(40);
      RandomLanes numbers(seed);
      const auto add = [&](std::vector<double>& sums, double place, double value) {
        const auto column = static_cast<std::size_t>(place);
        sums[column] += value / kSamples, variance[column] += value * value / kSamples / kSamples;
      };
      for (int i = 0; i < kSamples; i += kWidth) {
        const SensorSample sample = random_sample(numbers);
        const SensorRay ray = start_ray(sensor, sample);
        const Float t =
            (kDepth + kTilt * ray.origin.x - ray.origin.z) / (ray.direction.z - kTilt * ray.direction.x);
        const Vec3 met = fma(ray.direction, t, ray.origin);
        const Vec3 point{numbers(-kHalf, kHalf), numbers(-kHalf, kHalf), Float(0.0f)};
        const Vec3 on_plane{point.x, point.y, fma(point.x, Float(kTilt), Float(kDepth))};
        const SensorConnection seen = connect_to_sensor(sensor, on_plane, {numbers(), numbers()}, Float(0.0f),
                                                        Mask::all(), sample.wavelength);
        const Vec3 w = normalize(seen.lens - on_plane);
        for (int l = 0; l < kWidth; ++l) {
          // 40 x 20 pixels; rays are spread over all of them.
          if (t.lane(l) > 0 && std::abs(met.x.lane(l)) < kHalf && std::abs(met.y.lane(l)) < kHalf)
            add(by_ray, sample.raster.x.lane(l), 800.0 * ray.weight.lane(l));
          const double column = seen.raster.x.lane(l), row = seen.raster.y.lane(l);
          if (!(column >= 0 && column < 40 && row >= 0 && row < 20)) continue;
          // The area of the plane over that of its shadow along z is in the cosine.
          const double cosine = std::abs(double{w.z.lane(l)} - double{kTilt} * w.x.lane(l));
          add(by_point, column, seen.importance.lane(l) * cosine * 4 * kHalf * kHalf);
        }
      }
      double chi2 = 0;
      for (std::size_t i = 0; i < 40; ++i) chi2 += std::pow(by_ray[i] - by_point[i], 2) / variance[i];
      log_of_all += std::log(std::max(test::regularized_gamma_q(20, chi2 / 2), 1e-300));
    }
    EXPECT_GT(test::regularized_gamma_q(kSeeds, -log_of_all), test::sidak_level(0.01, 2)) << way;
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
