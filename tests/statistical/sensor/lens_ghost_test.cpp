// Ghosts of lens systems in kernels: their rays against those of the optics library, and the light that they
// bring against its sums, from the film and from the scene.
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "optics/ghosts.h"
#include "optics/image_quality.h"
#include "optics/pupil.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/view/lens.h"
#include "render/scene/view/sensor.h"
#include "render/sensor/lens_entry.h"
#include "render/sensor/model/lens_ghosts.h"
#include "statistical/sensor/lens_on_film.h"
#include "support/kernel/random_lanes.h"
#include "wire/algorithm.h"
#include "wire/lens_message.h"

namespace tessera::render::TESSERA_ISA::ghost_tests {
namespace {

constexpr FilmSize kFilm{36, 24};
constexpr double kSodium = 589.3;

/// A Cooke triplet of which some surfaces are coated; the front one is an asphere.
const char* const kTriplet = R"(lens {
    surfaces { radius_mm: 37.4    thickness_mm: 5.9   diameter_mm: 29.4 index: 1.61272 aspheric: [1e-7]
               coating { index: 1.38 thickness_nm: 100 } }
    surfaces { radius_mm: -341.48 thickness_mm: 12.93 diameter_mm: 29.4 }
    surfaces { radius_mm: -42.65  thickness_mm: 2.5   diameter_mm: 21.6 index: 1.64769 }
    surfaces { radius_mm: 36.4    thickness_mm: 2     diameter_mm: 21.6 coating { index: 1.38 thickness_nm: 110 } }
    surfaces {                    thickness_mm: 9.85  diameter_mm: 20.6 stop: true }
    surfaces { radius_mm: 204.52  thickness_mm: 5.9   diameter_mm: 23.2 index: 1.61272 }
    surfaces { radius_mm: -37.05  thickness_mm: 77.4  diameter_mm: 23.2 coating { index: 1.38 thickness_nm: 120 } }
  } f_number: 4 focus_distance: 3 ghosts: true )";
const char* const kSinglet = R"(lens {
    surfaces { thickness_mm: 2 diameter_mm: 10 stop: true }
    surfaces { radius_mm: 60 thickness_mm: 7 diameter_mm: 20 index: 1.52 }
    surfaces { radius_mm: -90 thickness_mm: 60 diameter_mm: 20 } } ghosts: true )";

LensOnFilm camera_of(const std::string& lens, bool takes_light = false, bool spectral = false) {
  return lens_on_film(lens, kFilm, {.takes_light = takes_light, .spectral = spectral});
}
Vec3 wide(const optics::Vector& v) {
  return {Float(static_cast<float>(v.x)), Float(static_cast<float>(v.y)), Float(static_cast<float>(v.z))};
}
optics::Vector lane_of(Vec3 v, int lane) { return {v.x.lane(lane), v.y.lane(lane), v.z.lane(lane)}; }

/// Every bounce, both ways, ray by ray.
TEST(LensGhosts, RaysAreThoseOfTheOpticsLibrary) {
  for (const char* const lens : {kTriplet, kSinglet}) {
    const LensOnFilm camera = camera_of(lens, false, true);  // of wavelengths: parts are those of one
    const LensTable& table = *camera.sensor.lens;
    const double front = camera.lens->elements().front().z, last = camera.lens->back_distance();
    const float nm = 520;
    const LensColours colours = colours_of(camera.sensor, Float(nm));
    const std::vector<optics::Bounce> bounces = camera.lens->bounces(kSodium);
    ASSERT_EQ(bounces.size(), table.ghosts.bounces.size());
    RandomLanes numbers(4);
    int found = 0;
    for (std::size_t i = 0; i < bounces.size(); ++i) {
      const Int near_film(table.ghosts.bounces[i].near_film), near_scene(table.ghosts.bounces[i].near_scene);
      for (const LensWay way : {LensWay::kToScene, LensWay::kToFilm}) {
        for (int k = 0; k < 20; ++k) {
          const bool to_scene = way == LensWay::kToScene;
          const float z = static_cast<float>(to_scene ? last : front);
          const Vec3 from{numbers(-15, 15), numbers(-10, 10), Float(to_scene ? 0.0f : z + 40)},
              at{numbers(-9, 9), numbers(-9, 9), Float(z)};
          LensRay ray{from, normalize(at - from), Mask::all()};
          const LensRay start = ray;
          if (!to_scene) ray.origin = mirrored(ray.origin), ray.direction = mirrored(ray.direction);
          LensLight light;
          follow_bounce(table, way, colours, near_film, near_scene, ray, light);
          if (!to_scene) ray.origin = mirrored(ray.origin), ray.direction = mirrored(ray.direction);
          for (int l = 0; l < kWidth; ++l) {
            const optics::Ray in{lane_of(start.origin, l), optics::unit(lane_of(start.direction, l))};
            const auto out = to_scene ? camera.lens->reflected_to_scene(in, bounces[i], nm)
                                      : camera.lens->reflected_to_film(in, bounces[i], nm);
            if (!out || !(ray.alive.bits() >> l & 1)) continue;  // at rims, rounding decides
            ++found;
            const optics::Vector o = lane_of(ray.origin, l), d = lane_of(ray.direction, l);
            // Single precision over three times the lens's surfaces.
            EXPECT_NEAR(o.x, out->ray.origin.x, 2e-3);
            EXPECT_NEAR(o.y, out->ray.origin.y, 2e-3);
            EXPECT_NEAR(o.z, out->ray.origin.z, 2e-3);
            EXPECT_NEAR(d.x, out->ray.direction.x, 1e-3);
            EXPECT_NEAR(d.y, out->ray.direction.y, 1e-3);
            EXPECT_NEAR(light.part.x.lane(l), out->part, 1e-2 * out->part + 1e-8);
          }
        }
      }
    }
    EXPECT_GT(found, 200 * static_cast<int>(bounces.size() > 1 ? 4 : 1));
  }
}

struct Mean {
  double value = 0, deviation = 0;
};
class MeanOf {
 public:
  void add(double x) { sum_ += x, squares_ += x * x, ++count_; }
  Mean mean() const {
    const double m = sum_ / count_;
    return {m, std::sqrt((squares_ / count_ - m * m) / count_)};
  }

 private:
  double sum_ = 0, squares_ = 0, count_ = 0;
};

/// Irradiance at a place of the film under a sky of radiance 1, by all bounces: a sum over the last surface,
/// whose points are a grid of rings.
double ghost_irradiance(const optics::LensSystem& lens, const optics::Vector& film) {
  const optics::Surface& last = lens.elements().back().surface;
  const double radius = last.diameter / 2;
  constexpr int kRings = 160, kTurns = 320;
  const std::vector<optics::Bounce> bounces = lens.bounces(kSodium);
  double sum = 0;
  for (int i = 0; i < kRings * kTurns; ++i) {
    const int ring = i / kTurns, turn = i % kTurns;
    const double r = radius * (ring + 0.5) / kRings, angle = 2 * std::numbers::pi * (turn + 0.5) / kTurns;
    const double area = r * (radius / kRings) * (2 * std::numbers::pi / kTurns);
    const double h = 1e-4,
                 slope = (optics::sag(last, r + h).value() - optics::sag(last, r - h).value()) / (2 * h);
    const optics::Vector at{r * std::cos(angle), r * std::sin(angle),
                            lens.back_distance() - optics::sag(last, r).value()};
    // The sag counts towards the film: z falls with it.
    const optics::Vector normal{slope * std::cos(angle), slope * std::sin(angle), 1};  // of length 1 / its z
    const optics::Vector way = at - film;
    const double distance = optics::length(way);
    const optics::Vector direction = optics::unit(way);
    const double facing = optics::dot(normal, direction);
    if (!(facing > 0)) continue;
    double part = 0;
    for (const optics::Bounce& bounce : bounces) {
      if (const auto out = lens.reflected_to_scene({film, direction}, bounce, kSodium)) part += out->part;
    }
    sum += part * area * facing * direction.z / (distance * distance);
  }
  return sum;
}

TEST(LensGhosts, WeightsFromTheFilmAreTheIrradianceOfGhosts) {
  constexpr int kSamples = 1 << 18;
  for (const char* const lens : {kSinglet, kTriplet}) {
    // Bare surfaces reflect all colours alike; the triplet's are compared at one wavelength.
    const LensOnFilm camera = camera_of(absl::StrCat(lens, "brightness: IRRADIANCE"), false, true);
    const float part = camera.sensor.lens->ghosts.part;
    for (const double place : {0.5, 0.9}) {
      MeanOf ghosts, straight;
      RandomLanes numbers(8);
      const float x = static_cast<float>(36 * place), y = static_cast<float>(24 * place);
      for (int i = 0; i < kSamples; i += kWidth) {
        const Vec2 u{numbers(), numbers()};
        SensorSample sample{{Float(x), Float(y)}, u, Float(0.0f)};
        sample.wavelength = Float(static_cast<float>(kSodium));
        const SensorRay ray = start_ray(camera.sensor, sample);
        for (int l = 0; l < kWidth; ++l) {
          const bool is_ghost = u.x.lane(l) < part;
          ghosts.add(is_ghost ? ray.weight.lane(l) : 0);
          straight.add(is_ghost ? 0 : ray.weight.lane(l));
        }
      }
      const optics::Vector film = film_at(camera.sensor, x, y);
      const double expected = ghost_irradiance(*camera.lens, film);
      // The grid's rays end at rims: 0.5 %.
      EXPECT_NEAR(ghosts.mean().value, expected, 5 * ghosts.mean().deviation + 5e-3 * expected)
          << lens << place;
      EXPECT_LT(ghosts.mean().deviation, 0.05 * expected);
      const auto field = optics::field_point(*camera.lens, std::hypot(film.x, film.y), {});
      ASSERT_TRUE(field);
      // Along the axis the loss is that of the T-number; aslant it is a little more.
      const double bare = field->illumination * optics::axial_irradiance(*camera.lens),
                   through = optics::transmittance(*camera.lens, kSodium);
      EXPECT_NEAR(straight.mean().value / bare, through, 5 * straight.mean().deviation / bare + 0.012);
    }
  }
}

/// A small source far away: light that is sent into the lens, against rays of the optics library.
TEST(LensGhosts, LightThatIsSentInLandsWhereItDoesInTheOpticsLibrary) {
  for (const char* const lens : {kSinglet, kTriplet}) {
    const LensOnFilm camera = camera_of(absl::StrCat(lens, "brightness: IRRADIANCE"), true, true);
    const LensTable& table = *camera.sensor.lens;
    const optics::Vector towards = optics::unit({0.12, 0.05, 1});
    // Rays to the rim cross the plane of the vertex a little outside of it.
    const double half = camera.lens->elements().front().surface.diameter / 2 + 2,
                 front = camera.lens->front();
    // Light that lands in quarters of the film, and beyond it, from a plane across the way.
    constexpr std::size_t kParts = 5;
    const auto part_of = [&](double x, double y) -> std::size_t {
      if (!(x >= 0 && x < 36 && y >= 0 && y < 24)) return 4;
      return (x < 18 ? 0u : 1u) + (y < 12 ? 0u : 2u);
    };
    std::vector<MeanOf> found(kParts);
    constexpr int kSamples = 1 << 18;
    RandomLanes numbers(21);
    for (int i = 0; i < kSamples; i += kWidth) {
      const LensEntry entry = sample_lens_entry(camera.sensor, {numbers(), numbers()}, Float(0.0f));
      const LensLanding landing =
          send_into_lens(camera.sensor, entry, wide(towards), numbers(), Float(static_cast<float>(kSodium)),
                         Float(0.0f), Mask::all());
      for (int l = 0; l < kWidth; ++l) {
        const bool valid = (landing.valid.bits() >> l & 1) != 0;
        const std::size_t part = part_of(landing.raster.x.lane(l), landing.raster.y.lane(l));
        for (std::size_t k = 0; k < kParts; ++k)
          found[k].add(valid && k == part ? landing.value.lane(l) * table.ghosts.rays_of_lights : 0);
      }
    }
    std::vector<double> expected(kParts);
    constexpr int kSide = 400;
    const double cell = 2 * half / kSide;
    for (int i = 0; i < kSide * kSide; ++i) {
      const int column = i % kSide, row = i / kSide;
      const optics::Vector at{(column + 0.5) * cell - half, (row + 0.5) * cell - half, front};
      // Parallel rays through a plane at the vertex: their area across the way.
      const double area = cell * cell * towards.z;
      for (const optics::Bounce& bounce : camera.lens->bounces(kSodium)) {
        const auto out = camera.lens->reflected_to_film({at + towards * 30.0, towards * -1}, bounce, kSodium);
        if (!out) continue;
        const optics::Vector film = optics::at_plane(out->ray, 0);
        const double d = table.film_distance;
        const double x = (-film.x / d - camera.sensor.offset_x) / camera.sensor.scale_x,
                     y = (-film.y / d - camera.sensor.offset_y) / camera.sensor.scale_y;
        expected[part_of(x, y)] += out->part * area;
      }
    }
    const double pixel = pixel_area(camera.sensor) * table.film_distance * table.film_distance;
    double all = 0;
    for (const double light : expected) all += light / pixel;
    for (std::size_t k = 0; k < kParts; ++k) {
      const Mean mean = found[k].mean();
      EXPECT_NEAR(mean.value, expected[k] / pixel, 5 * mean.deviation + 5e-3 * all) << lens << k;
    }
    EXPECT_GT(all, 0);
  }
}

/// The density that weighs both ways against each other is the same from both ends.
TEST(LensGhosts, BothWaysAgreeOnTheirDensities) {
  const LensOnFilm camera = camera_of(kTriplet, true, true);
  RandomLanes numbers(13);
  const float part = camera.sensor.lens->ghosts.part;
  int found = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec2 raster{numbers(0, 36), numbers(0, 24)}, u{numbers(0, part), numbers()};
    SensorSample sample{raster, u, Float(0.0f)};
    sample.wavelength = Float(550.0f);
    const SensorRay ray = start_ray(camera.sensor, sample);
    if (none(ray.valid)) continue;
    const LensTable& lens = *camera.sensor.lens;
    LensEntry entry;
    entry.point = ray.origin;
    entry.in_lens = ray.origin * Float(1 / lens.units_per_mm);
    entry.in_normal = normal_on(lens, lens.surfaces.back(), {entry.in_lens.x, entry.in_lens.y});
    // The bounce that the ray took, as its number chooses it.
    const LensLanding landing =
        send_into_lens(camera.sensor, entry, ray.direction, u.y, Float(550.0f), Float(0.0f), ray.valid);
    const std::uint32_t both = (ray.valid & landing.valid).bits();
    for (int l = 0; l < kWidth; ++l) {
      if (!(both >> l & 1)) continue;
      ++found;
      EXPECT_NEAR(landing.raster.x.lane(l), raster.x.lane(l), 0.05);
      EXPECT_NEAR(landing.raster.y.lane(l), raster.y.lane(l), 0.05);
      EXPECT_NEAR(landing.pdf.lane(l) / ray.pdf.lane(l), 1, 0.02);
    }
  }
  EXPECT_GT(found, 1000);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::ghost_tests
