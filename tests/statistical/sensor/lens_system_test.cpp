// Lens systems in kernels: their rays against those of the optics library, their weights against its
// irradiance, and a picture against a thin lens's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "optics/image_quality.h"
#include "optics/pupil.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/view/lens.h"
#include "render/scene/view/sensor.h"
#include "render/sensor/sensor.h"
#include "render/transport/path/wavefront.h"
#include "statistical/sensor/lens_on_film.h"
#include "support/kernel/kernel_scene.h"
#include "support/kernel/random_lanes.h"
#include "wire/algorithm.h"
#include "wire/lens_message.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr FilmSize kFilm{360, 240};

/// US patent 3,552,829, example 1.
const char* const kDoubleGauss = R"(lens {
    surfaces { radius_mm: 56.655 thickness_mm: 5.24 diameter_mm: 38.5 dispersion { abbe { index: 1.815 number: 45.2 } } }
    surfaces { radius_mm: 600 thickness_mm: 0.565 diameter_mm: 38.5 }
    surfaces { radius_mm: 25.68 thickness_mm: 6.56 diameter_mm: 33.5 dispersion { abbe { index: 1.694 number: 54.6 } } }
    surfaces { radius_mm: 51.875 thickness_mm: 0.8 diameter_mm: 28.716 }
    surfaces { radius_mm: 84.6 thickness_mm: 2.255 diameter_mm: 34 dispersion { abbe { index: 1.63003 number: 35.4 } } }
    surfaces { radius_mm: 17.295 thickness_mm: 5.865 diameter_mm: 24.5 }
    surfaces { thickness_mm: 5.565 diameter_mm: 24.1 stop: true }
    surfaces { radius_mm: -19.475 thickness_mm: 2.855 diameter_mm: 24 dispersion { abbe { index: 1.7918 number: 25.9 } } }
    surfaces { radius_mm: 246.02 thickness_mm: 6.185 diameter_mm: 31 dispersion { abbe { index: 1.8004 number: 42.7 } } }
    surfaces { radius_mm: -35.965 thickness_mm: 0.095 diameter_mm: 31 }
    surfaces { radius_mm: -125.895 thickness_mm: 4.05 diameter_mm: 31.5 dispersion { abbe { index: 1.8004 number: 42.7 } } }
    surfaces { radius_mm: -37.625 thickness_mm: 0.095 diameter_mm: 31.5 }
    surfaces { radius_mm: 198.13 thickness_mm: 4.05 diameter_mm: 31.5 dispersion { abbe { index: 1.71615 number: 53.7 } } }
    surfaces { radius_mm: -63.025 thickness_mm: 36.5 diameter_mm: 31.5 }
  } )";
/// A condenser with an asphere, a conic and a cylinder in front of it.
const char* const kAspheres = R"(lens {
    surfaces { radius_mm: -900 thickness_mm: 3 diameter_mm: 30 index: 1.5 cylindrical: true axis_degrees: 30 }
    surfaces { thickness_mm: 4 diameter_mm: 30 }
    surfaces { thickness_mm: 2 diameter_mm: 20 stop: true }
    surfaces { radius_mm: 40 thickness_mm: 9 diameter_mm: 26 index: 1.5 conic: -0.6 aspheric: [1e-7, -2e-10] }
    surfaces { radius_mm: -90 thickness_mm: 50 diameter_mm: 26 conic: -1.2 }
  } )";

LensOnFilm camera_of(const std::string& lens, bool spectral = false) {
  return lens_on_film(lens, kFilm, {.spectral = spectral});
}

TEST(LensSystemSensor, RaysComeFromTheirPlaceOnTheFilm) {
  struct Case {
    const char *lens, *use;
    double mm;  // millimetres that a unit of the scene is
  };
  for (const Case& c : {Case{kDoubleGauss, "focus_distance: 2 f_number: 1.4", 1000},
                        {kDoubleGauss, "focus_distance: 1000 f_number: 4 blades: 6 units_per_mm: 1", 1},
                        {kAspheres, "focus_distance: 3", 1000}}) {
    for (const bool spectral : {false, true}) {
      const LensOnFilm camera = camera_of(absl::StrCat(c.lens, c.use), spectral);
      const double mm = c.mm;
      RandomLanes numbers(7);
      int valid = 0, all = 0;
      for (int i = 0; i < 4000; i += kWidth) {
        SensorSample sample{{numbers(0, 360), numbers(0, 240)}, {numbers(), numbers()}, Float(0.0f)};
        sample.wavelength = numbers(400, 700);
        const SensorRay ray = start_ray(camera.sensor, sample);
        for (int l = 0; l < kWidth; ++l) {
          ++all;
          if (!(ray.valid.bits() >> l & 1)) continue;
          ++valid;
          const optics::Vector origin{ray.origin.x.lane(l) * mm, ray.origin.y.lane(l) * mm,
                                      ray.origin.z.lane(l) * mm};
          const optics::Vector direction{ray.direction.x.lane(l), ray.direction.y.lane(l),
                                         ray.direction.z.lane(l)};
          const double nm = camera.sensor.disperses ? sample.wavelength.lane(l) : 589.3;
          const auto back =
              camera.lens->to_film({origin + direction * 1.0, optics::unit(direction * -1)}, nm);
          if (!back) continue;  // at the rim of an aperture, where rounding decides
          const optics::Vector at = optics::at_plane(*back, 0),
                               from =
                                   film_at(camera.sensor, sample.raster.x.lane(l), sample.raster.y.lane(l));
          // Single precision through fourteen surfaces; a pixel is 0.12 mm wide.
          ASSERT_NEAR(at.x, from.x, 1e-3);
          ASSERT_NEAR(at.y, from.y, 1e-3);
        }
      }
      EXPECT_GT(valid, 0.8 * all);
    }
  }
}

/// The mean weight of rays from a place of the film, and the part of them that is lost.
struct Light {
  double mean = 0, deviation = 0, lost = 0;
};
Light light_at(const SensorRecord& sensor, double x, double y) {
  constexpr int kSamples = 1 << 16;
  RandomLanes numbers(3);
  double sum = 0, squares = 0;
  int lost = 0;
  for (int i = 0; i < kSamples; i += kWidth) {
    const SensorRay ray = start_ray(
        sensor,
        {{Float(static_cast<float>(x)), Float(static_cast<float>(y))}, {numbers(), numbers()}, Float(0.0f)});
    for (int l = 0; l < kWidth; ++l) {
      const bool valid = (ray.valid.bits() >> l & 1) != 0;
      const double weight = valid ? ray.weight.lane(l) : 0;
      sum += weight, squares += weight * weight, lost += valid ? 0 : 1;
    }
  }
  const double mean = sum / kSamples;
  return {mean, std::sqrt((squares / kSamples - mean * mean) / kSamples),
          static_cast<double>(lost) / kSamples};
}

TEST(LensSystemSensor, WeightsAreTheIrradianceOfTheFilm) {
  for (const char* const use : {"f_number: 1.4", "focus_distance: 1 f_number: 4"}) {
    const LensOnFilm camera = camera_of(absl::StrCat(kDoubleGauss, use)),
                     plain = camera_of(absl::StrCat(kDoubleGauss, use, " brightness: IRRADIANCE"));
    const double axial = optics::axial_irradiance(*camera.lens);
    for (const double part : {0.0, 0.3, 0.6, 0.98}) {
      const double x = 180 + 180 * part, y = 120 - 120 * part;
      const optics::Vector film = film_at(camera.sensor, x, y);
      const auto field = optics::field_point(*camera.lens, std::hypot(film.x, film.y), {});
      ASSERT_TRUE(field);
      const Light light = light_at(camera.sensor, x, y), irradiance = light_at(plain.sensor, x, y);
      // Outlines of the pupil are polygons.
      const double tolerance = 5 * light.deviation + 1e-3 * field->illumination;
      EXPECT_NEAR(light.mean, field->illumination, tolerance) << use << part;
      EXPECT_NEAR(irradiance.mean, field->illumination * axial, tolerance * axial) << use << part;
      EXPECT_LT(light.lost, 0.1) << use << part;
    }
  }
}

TEST(LensSystemSensor, ClosedBladesLetLessThrough) {
  const LensOnFilm round = camera_of(absl::StrCat(kDoubleGauss, "f_number: 4 brightness: IRRADIANCE")),
                   polygon =
                       camera_of(absl::StrCat(kDoubleGauss, "f_number: 4 brightness: IRRADIANCE blades: 6"));
  // A hexagon's part of its circle; the weights vary by cos^4, less than 2 % here.
  const double part = 3 * std::sqrt(3.0) / (2 * std::numbers::pi);
  EXPECT_NEAR(light_at(polygon.sensor, 180, 120).mean / light_at(round.sensor, 180, 120).mean, part,
              0.01 * part);
  // Cells of a grid are wider than rings.
  EXPECT_LT(light_at(polygon.sensor, 350, 10).lost, 0.13);
}

/// A disk out of focus before a sky of radiance 1.
TEST(LensSystemSensor, PicturesOfAThinSingletAreThoseOfAThinLens) {
  const auto content = build_kernel_scene(R"(
      camera { orthographic {} }
      film { width: 16 height: 16 }
      materials { name: 'black' diffuse { reflectance { constant { rgb {} } } } }
      shapes { disk { radius: 0.009 } material: 'black'
               world_from_object { elements: [1,0,0,0.004, 0,1,0,0.0015, 0,0,1,0.5, 0,0,0,1] } }
      lights { infinite { radiance { rgb { r: 1 g: 1 b: 1 } } } })",
                                          16);
  ASSERT_NE(content, nullptr);
  v1::Camera message;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(R"(lens {
      lens { surfaces { thickness_mm: 0.2 diameter_mm: 4 stop: true }
             surfaces { radius_mm: 50 thickness_mm: 0.5 diameter_mm: 6 index: 1.5 }
             surfaces { thickness_mm: 100 diameter_mm: 6 } }
      film_diagonal_mm: 8 focus_distance: 2.5 })",
                                                            &message));
  const auto sensor =
      build_sensor(message, {16, 16}, render_space_about({0, 0, 0}), *wire::find_algorithm(""));
  ASSERT_TRUE(sensor.ok()) << sensor.status();
  std::vector<optics::Fault> faults;
  const auto lens = wire::lens_system_of(message.lens(), faults);
  // The thin lens stands where the stop is, which is before the lens: its own image.
  const double front = lens->front() / 1000;
  SensorRecord thin = *sensor;
  thin.kind = SensorKind::kThinLens;
  thin.render_from_sensor.m[11] = static_cast<float>(front);
  thin.lens_radius = 0.002f, thin.focal_distance = static_cast<float>(2.5 - front);
  constexpr std::uint32_t kSamples = 1024;
  double statistic = 0, brightness = 0;
  int pixels = 0;
  SceneTables tables = content->tables;
  tables.sensor = *sensor;
  const wire::TileResult real = render_tile<Wavefront>(*content, tables, kSamples);
  tables.sensor = thin;
  tables.sampler.seed += 1;
  const wire::TileResult ideal = render_tile<Wavefront>(*content, tables, kSamples);
  for (std::size_t i = 0; i < 256; ++i) {
    const std::size_t column = i % 16, row = i / 16;
    const double x = (static_cast<double>(column) + 0.5) * sensor->scale_x + sensor->offset_x,
                 y = (static_cast<double>(row) + 0.5) * sensor->scale_y + sensor->offset_y;
    const double cosine = 1 / std::sqrt(1 + x * x + y * y);
    const double a = MeanRadiance(real, kSamples).of_pixel(0, i),
                 b = MeanRadiance(ideal, kSamples).of_pixel(0, i) * std::pow(cosine, 4);
    // Samples are 0 or about 1; 0.2 % is aberration, and the film's distance from the principal plane.
    const double p = std::clamp((a + b) / 2, 0.0, 1.0);
    const double variance = 2 * p * (1 - p) / kSamples + std::pow(0.002, 2);
    statistic += (a - b) * (a - b) / variance;
    brightness += (a - b) / 256;
    ++pixels;
  }
  // Stratified samples vary less than independent ones: the sum of squares is at most as large as theirs,
  // whose mean is the number of pixels and whose deviation is the root of twice that.
  EXPECT_LT(statistic, pixels + 4 * std::sqrt(2.0 * pixels));
  EXPECT_NEAR(brightness, 0, 2e-3);
  // The disk is there, and blurred: some pixels are dark, some grey.
  int dark = 0, grey = 0;
  for (std::size_t i = 0; i < 256; ++i) {
    const double a = MeanRadiance(real, kSamples).of_pixel(0, i);
    dark += a < 0.02 ? 1 : 0, grey += a > 0.1 && a < 0.9 ? 1 : 0;
  }
  EXPECT_GT(dark, 10);
  EXPECT_GT(grey, 10);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
