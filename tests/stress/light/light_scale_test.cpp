// Irradiance under lights of every kind and of any size, and under a sun in a picture of the sky: rendered
// with everything on (light and BSDF sampling), against formulas and quadrature in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "support/long_form.h"
#include "support/picture/scene_file.h"
#include "wire/mesh_blob.h"

namespace tessera::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// A square of side 2 at z = 0, facing down.
std::string square_below() {
  wire::MeshData mesh;
  mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  mesh.indices = {0, 2, 1, 0, 3, 2};
  return wire::encode_mesh(mesh);
}

std::string number(double x) { return absl::StrCat(x); }

/// A shape or light placed `height` above the floor and stretched by `size`.
std::string placed(double size, double height) {
  return "{ elements: [" + number(size) + ",0,0,0, 0," + number(size) + ",0,0, 0,0," + number(size) + "," +
         number(height) + ", 0,0,0,1] }";
}

/// Mean of what a small patch of a white floor below the light reflects, times pi: the irradiance. In units
/// of `scale`, the floor is a disk of radius 2 and the camera looks at its middle from 0.6 away.
double irradiance(const std::string& lights, double scale, const TestBlobs& blobs = {}) {
  const double at[] = {0.5 * scale, 0.3 * scale};
  const double l = std::hypot(0.5, 0.3);
  // Columns of the camera's matrix: x right, y up, z towards the middle of the floor.
  const std::string scene = absl::StrCat(
      "materials { name: 'white' diffuse { reflectance { constant { constant: 1 } } } }",
      "shapes { name: 'floor' disk { radius: ", 2 * scale, " } material: 'white' } ", lights,
      "camera { perspective { fov_degrees: 0.01 } world_from_camera { elements: [", "0,", -0.3 / l, ",",
      -0.5 / l, ",", at[0], ", 1,0,0,0, 0,", 0.5 / l, ",", -0.3 / l, ",", at[1], ", 0,0,0,1] } }",
      "film { width: 8 height: 8 } settings { integrator: 'path' sampler: SAMPLER_SOBOL max_depth: 1 spp: "
      "4096 }");
  const auto file = load_scene_text(scene, {}, render::supported_isas().front(), blobs);
  EXPECT_TRUE(file.ok()) << file.status() << scene;
  if (!file.ok()) return NAN;
  render::RenderStats stats;
  const auto tile = file->scene->render_tile({0, 0, 8, 8, 0, 4096}, {}, stats);
  EXPECT_TRUE(tile.ok()) << tile.status();
  EXPECT_EQ(stats.dropped_samples, 0u);
  if (!tile.ok()) return NAN;
  double sum = 0;
  for (std::size_t i = 0; i < 64; ++i) sum += tile->values[i] / 4096.0;
  return sum / 64 * kPi;
}

/// An emitter of radiance 1, as seen from outside, and size `s`, 1 above the floor, all in units of `scale`.
struct Emitter {
  const char* name;
  std::function<std::string(double s, double scale)> scene;
  std::function<double(double s)> irradiance;
  double largest;  // limit of float: a sphere of 10^6 is known to 0.06, and it hangs 1 above the floor
};

constexpr char kGlow[] = " area_light { radiance { constant: 1 } } } ";

std::vector<Emitter> emitters() {
  return {
      {"sphere",
       [](double s, double scale) {
         return absl::StrCat("shapes { name: 'lamp' sphere { radius: 1 } world_from_object ",
                             placed(s * scale, (1 + s) * scale), kGlow);
       },
       // The nearest point is 1 above the floor.
       [](double s) { return kPi * std::pow(s / (1 + s), 2); }, 1e5},
      {"disk",
       [](double s, double scale) {
         return absl::StrCat(
             "shapes { name: 'lamp' disk { radius: 1 } reverse_orientation: true world_from_object ",
             placed(s * scale, scale), kGlow);
       },
       [](double s) { return kPi * s * s / (1 + s * s); }, 1e6},
      {"square",
       [](double s, double scale) {
         return absl::StrCat("shapes { name: 'lamp' mesh { blob { digest: 'square' } } world_from_object ",
                             placed(s * scale, scale), kGlow);
       },
       // Four times the form factor of a rectangle with a corner above the point [Howell, A Catalog of
       // Radiation Heat Transfer Configuration Factors, B-3].
       [](double s) { return 4 * s / std::sqrt(1 + s * s) * std::atan(s / std::sqrt(1 + s * s)); }, 1e6},
      {"tube",
       [](double s, double scale) {
         // About the vertical axis, from 1 to 1 + s, glowing inwards: a chimney.
         return absl::StrCat(
             "shapes { name: 'lamp' cylinder { radius: 1 z_min: 0 z_max: 1 } reverse_orientation: true "
             "world_from_object ",
             placed(s * scale, scale), kGlow);
       },
       // pi (sin^2 of the upper elevation - sin^2 of the lower one), without the difference.
       [](double s) {
         const double top = (1 + s) * (1 + s);
         return kPi * s * s * (top - 1) / ((1 + s * s) * (top + s * s));
       },
       1e6},
      {"soft point",
       [](double s, double scale) {
         const double r = s * scale;
         return absl::StrCat("lights { point { position { z: ", r + scale, " } radius: ", r,
                             " intensity { constant: ", kPi * r, " } } scale: ", r, " } ");
       },
       // That of the sphere.
       [](double s) { return kPi * std::pow(s / (1 + s), 2); }, 1e5},
  };
}

// 2^18 Sobol' samples of a bounded integrand: a part in 10^4 (the worst of the table in docs/numerics.md).
// The rest of the tenth of a per cent is for the renderer.
constexpr double kScaleTolerance = 1e-3;

TEST(LightScale, EmittersOfAnySizeInScenesOfAnySize) {
  const TestBlobs blobs = {{"square", square_below()}};
  const std::vector<double> scales =
      long_form() ? std::vector<double>{1e-6, 1e-3, 1, 1e3, 1e6} : std::vector<double>{1e-6, 1, 1e6};
  const std::vector<double> sizes = long_form()
                                        ? std::vector<double>{1e-3, 1e-2, 0.1, 1, 10, 100, 1e3, 1e4, 1e5, 1e6}
                                        : std::vector<double>{1e-3, 1, 1e3, 1e4, 1e5, 1e6};
  for (const Emitter& emitter : emitters()) {
    double worst = 0;
    for (const double scale : scales) {
      for (const double s : sizes) {
        if (s > emitter.largest) continue;
        const double expected = emitter.irradiance(s),
                     found = irradiance(emitter.scene(s, scale), scale, blobs);
        EXPECT_NEAR(found, expected, kScaleTolerance * expected)
            << emitter.name << " of size " << s << ", scene of size " << scale;
        worst = std::max(worst, std::abs(found / expected - 1));
      }
    }
    std::printf("%s: off by %.1e at most\n", emitter.name, worst);
  }
}

/// Farther than float's corners can tell: round lights, whose size is a number of its own.
TEST(LightScale, RoundLightsAMillionTimesFartherThanLarge) {
  const std::vector<Emitter> all = emitters();
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const std::size_t i : {0, 1, 4}) {
      const double s = 1e-6, expected = all[i].irradiance(s);
      EXPECT_NEAR(irradiance(all[i].scene(s, scale), scale), expected, kScaleTolerance * expected)
          << all[i].name << ", scene of size " << scale;
    }
  }
}

/// Lights without extent, straight above the floor: intensity over distance squared, at any distance.
TEST(LightScale, PointsSpotsAndProjectorsAtAnyDistance) {
  for (const double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
    const std::string up = absl::StrCat("z: ", scale);
    // Light space: z down.
    const std::string down =
        absl::StrCat("world_from_light { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,", scale, ", 0,0,0,1] }");
    const std::string lights[] = {
        absl::StrCat("lights { point { position { ", up, " } intensity { constant: 2 } } }"),
        absl::StrCat(
            "lights { spot { position { ", up,
            " } target { } intensity { constant: 2 } cone_angle_degrees: 30 cone_delta_degrees: 5 } }"),
        absl::StrCat("lights { projection { ", down, " fov_degrees: 40 intensity { constant: 2 } } }"),
        absl::StrCat("lights { goniometric { ", down, " intensity { constant: 2 } } }")};
    for (const std::string& light : lights) {
      const double expected = 2 / (scale * scale);
      EXPECT_NEAR(irradiance(light, scale), expected, 1e-5 * expected) << light;
    }
  }
}

/// Rows from the top; the format has them from the bottom.
std::string pfm(int width, int height, const std::vector<float>& grey) {
  std::string bytes = absl::StrCat("PF\n", width, " ", height, "\n-1.0\n");
  for (int y = height - 1; y >= 0; --y) {
    for (int x = 0; x < width; ++x) {
      const float v = grey[static_cast<std::size_t>(y * width + x)], rgb[] = {v, v, v};
      bytes.append(reinterpret_cast<const char*>(rgb), sizeof(rgb));
    }
  }
  return bytes;
}

/// A sky of radiance 1 with a sun of 1e5 and half a degree across, in a map of four texels a degree. The map
/// is interpolated as the renderer does, after Mitsuba 3: columns have their centres at half-integers, the
/// first and last rows lie on the poles. Its integral over the upper half, times the cosine: exact along a
/// row, by eight midpoints from row to row.
TEST(LightScale, SunInASky) {
  constexpr int kWidth = 1440, kHeight = 720;
  for (const double elevation : {80.0, 45.0, 5.0}) {
    const double sun_theta = (90 - elevation) * kPi / 180, sun_phi = 1.234;
    const auto direction = [](double theta, double phi, double(&w)[3]) {
      w[0] = std::sin(theta) * std::cos(phi), w[1] = std::sin(theta) * std::sin(phi), w[2] = std::cos(theta);
    };
    double sun[3];
    direction(sun_theta, sun_phi, sun);
    std::vector<float> sky(kWidth * kHeight, 1.0f);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        double w[3];
        direction(kPi * y / (kHeight - 1), 2 * kPi * (x + 0.5) / kWidth, w);
        const double cosine = w[0] * sun[0] + w[1] * sun[1] + w[2] * sun[2];
        if (cosine > std::cos(0.25 * kPi / 180)) sky[static_cast<std::size_t>(y * kWidth + x)] = 1e5f;
      }
    }
    const auto texel = [&](int x, int y) {
      return double{
          sky[static_cast<std::size_t>(std::clamp(y, 0, kHeight - 1) * kWidth + (x + kWidth) % kWidth)]};
    };
    double expected = 0;
    constexpr int kSteps = 8;
    for (int y = 0; y < kHeight / 2 * kSteps; ++y) {
      const double theta = kPi * (y + 0.5) / kSteps / kHeight, v = theta / kPi * (kHeight - 1);
      const int row = static_cast<int>(std::floor(v));
      double line = 0;
      for (int x = 0; x < kWidth; ++x) {
        // Over a whole texel to the next one, the mean of both: linear in between.
        const double upper = (texel(x, row) + texel(x + 1, row)) / 2,
                     lower = (texel(x, row + 1) + texel(x + 1, row + 1)) / 2;
        line += upper + (lower - upper) * (v - row);
      }
      expected += line * std::sin(theta) * std::cos(theta) * (kPi / kHeight / kSteps) * (2 * kPi / kWidth);
    }
    // Up in the map is +y: turned to +z.
    const std::string light =
        "lights { infinite { image { digest: 'sky' path: 'sky.pfm' } mapping: LATITUDE_LONGITUDE radiance { "
        "constant: "
        "1 } "
        "world_from_light { elements: [1,0,0,0, 0,0,-1,0, 0,1,0,0, 0,0,0,1] } } }";
    const double found = irradiance(light, 1, {{"sky", pfm(kWidth, kHeight, sky)}});
    EXPECT_NEAR(found, expected, kScaleTolerance * expected) << "sun at " << elevation << " degrees";
    std::printf("sun at %.0f degrees: off by %.1e\n", elevation, found / expected - 1);
  }
}

}  // namespace
}  // namespace tessera::test
