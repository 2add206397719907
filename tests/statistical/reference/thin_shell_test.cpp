// Lamps and skies, fog, and thin sheets around it: each part alone against a closed form or quadrature, over
// several seeds whose deviations are combined; and lamps with vertex normals, as Mitsuba has them, against
// quadrature.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"
#include "wire/mesh_blob.h"

namespace tessera::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kEta = 1.33, kSigma = 1.5, kAlbedo = 0.8, kRadius = 0.9;

/// Integral over [low, high] by the midpoint rule.
double integrate(double low, double high, int steps, const std::function<double(double)>& f) {
  double sum = 0;
  for (int i = 0; i < steps; ++i) sum += f(low + (i + 0.5) / steps * (high - low));
  return sum * (high - low) / steps;
}

/// Reflectance for unpolarized light met under this cosine, from the thinner side [Fresnel].
double fresnel(double cosine) {
  const double refracted = std::sqrt(1 - (1 - cosine * cosine) / (kEta * kEta));
  const double parallel = (kEta * cosine - refracted) / (kEta * cosine + refracted);
  const double perpendicular = (cosine - kEta * refracted) / (cosine + kEta * refracted);
  return (parallel * parallel + perpendicular * perpendicular) / 2;
}

/// Through both sides of a thin sheet, all orders of reflection between them: T^2 (1 + r^2 + r^4 + ...).
double through_sheet(double cosine) {
  const double r = fresnel(cosine);
  return (1 - r) * (1 - r) / (1 - r * r);
}

struct Setting {
  std::string scene;
  std::uint32_t max_depth = 0;
  std::string integrator = "volpath";
  std::string settings = {};
  TestBlobs blobs = {};
};

/// Renders with eight seeds. The sum of their deviations in units of its own error is normally distributed:
/// beyond 4 once in 16,000. `largest_error`, relative, keeps the test from passing for noise.
void expect_mean(const Setting& setting, double expected, double largest_error) {
  SCOPED_TRACE(absl::StrCat(setting.integrator, ", depth ", setting.max_depth, ", ", setting.settings));
  constexpr int kSeeds = 8;
  double sum = 0, variance = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    PictureRequest request;
    request.scene = setting.scene;
    request.integrator = setting.integrator;
    request.max_depth = setting.max_depth;
    request.spp = 512;
    request.blobs = setting.blobs;
    // The picture's random numbers follow from its settings.
    request.settings = absl::StrCat(setting.settings, " seed: ", 100 + seed);
    const Picture picture = measure_picture(request);
    ASSERT_FALSE(picture.values.empty());
    sum += picture.whole(0).mean - expected;
    variance += picture.whole(0).error * picture.whole(0).error;
  }
  const double mean = sum / kSeeds, error = std::sqrt(variance) / kSeeds;
  EXPECT_LT(error, largest_error * expected);
  // Roundings of single precision, where there is no noise at all.
  EXPECT_LT(std::abs(mean), 4 * error + 2e-6 * expected)
      << "off by " << 100 * mean / expected << " %, " << mean / error << " standard errors";
}

// The shell is in the middle of the scene, like everything.
constexpr const char* kShell =
    R"( materials { name: 'sheet' thin_dielectric { eta { constant: 1.33 } passes_straight: true } }
  shapes { sphere { radius: 0.9 } material: 'sheet' )";
constexpr const char* kFog =
    "media { name: 'fog' extinction { constant { constant: 1.5 } } albedo { constant { constant: 0.8 } } } ";
// Sees nothing but rays through the middle.
constexpr const char* kMiddle = " camera { perspective { fov_degrees: 40 } ";
// The square of side 2 about the middle, from above.
constexpr const char* kFromAbove =
    " camera { orthographic { } world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,4, 0,0,0,1] } } ";

TEST(ThinShell, LetsTheSkyInByWhatBothSidesLeave) {
  expect_mean({absl::StrCat(kShell, "} ", kSky, kMiddle, "}")}, through_sheet(1), 1e-3);
}

TEST(ThinShell, DimsTheSkyBehindFog) {
  const std::string scene =
      absl::StrCat(kFog, kShell, "interior_medium: 'fog' } ", kSky, kMiddle, "medium: 'fog' }");
  expect_mean({scene}, through_sheet(1) * std::exp(-kSigma * kRadius), 2e-3);
}

TEST(ThinShell, PassingIsFreeAndReflectionIsOneEvent) {
  // Along a diameter, with fog that does not scatter: out at once, or after one reflection, or two.
  const std::string fog =
      "media { name: 'fog' extinction { constant { constant: 1.5 } } albedo { constant { constant: 0 } } } ";
  const std::string scene =
      absl::StrCat(fog, kShell, "interior_medium: 'fog' } ", kSky, kMiddle, "medium: 'fog' }");
  const double t = through_sheet(1), way = std::exp(-kSigma * kRadius),
               back = (1 - t) * std::exp(-2 * kSigma * kRadius);
  expect_mean({scene, 1}, t * way * (1 + back), 2e-3);
  expect_mean({scene, 2}, t * way * (1 + back + back * back), 2e-3);
}

TEST(ThinShell, LetsTheSkyScatterInTheFog) {
  const std::string scene =
      absl::StrCat(kFog, kShell, "interior_medium: 'fog' } ", kSky, kMiddle, "medium: 'fog' }");
  const double t = through_sheet(1), way = std::exp(-kSigma * kRadius);
  const double unscattered = t * way * (1 + (1 - t) * way * way);
  const double scattered = integrate(0, kRadius, 400, [](double s) {
    // The mean over directions of what comes in, the cosine `mu` being with the way that is seen along.
    return kSigma * kAlbedo * std::exp(-kSigma * s) / 2 * integrate(-1, 1, 400, [&](double mu) {
             const double out = -s * mu + std::sqrt(kRadius * kRadius - s * s * (1 - mu * mu));
             return through_sheet((out + s * mu) / kRadius) * std::exp(-kSigma * out);
           });
  });
  expect_mean({scene, 1}, unscattered + scattered, 2e-3);
}

TEST(ThinShell, LampInFog) {
  // A ball that shines in the middle, seen from afar: at most one event. A reflection inside the shell keeps
  // its distance from the middle, so it never leads to the ball.
  constexpr double kBulb = 0.2;
  const std::string scene = absl::StrCat(
      kFog, kShell,
      "interior_medium: 'fog' } materials { name: 'black' diffuse { reflectance { constant { constant: 0 } } "
      "} } ",
      "shapes { sphere { radius: 0.2 } material: 'black' area_light { radiance { constant: 1 } } } ",
      kFromAbove);
  const auto in_scattered = [&](double distance) {
    // From the cone that the ball fills; `near` is where a way of this cosine meets it.
    const double cos_rim = std::sqrt(1 - kBulb * kBulb / (distance * distance));
    return integrate(cos_rim, 1, 60, [&](double cosine) {
      const double along = distance * cosine;
      const double near =
          along - std::sqrt(std::max(0.0, kBulb * kBulb - distance * distance * (1 - cosine * cosine)));
      return std::exp(-kSigma * near) / 2;
    });
  };
  const double shown = integrate(0, kRadius, 600, [&](double b) {
    const double half = std::sqrt(kRadius * kRadius - b * b);
    const bool meets = b < kBulb;
    const double end = meets ? half - std::sqrt(kBulb * kBulb - b * b) : 2 * half;
    double radiance = meets ? std::exp(-kSigma * end) : 0;
    radiance += integrate(0, end, 300, [&](double s) {
      return kSigma * kAlbedo * std::exp(-kSigma * s) * in_scattered(std::hypot(half - s, b));
    });
    return 2 * kPi * b * through_sheet(half / kRadius) * radiance;
  });
  expect_mean({scene, 1}, shown / 4, 4e-3);
  expect_mean({scene, 1, "volpath", "direct_light: DIRECT_LIGHT_BSDF"}, shown / 4, 4e-3);
}

// ---------------------------------------------------------------- lamps with vertex normals

struct V {
  double x, y, z;
};
V operator-(V a, V b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double dot(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

constexpr double kPick = 0.5;
// Above the floor and beside what the camera sees, turned down; its normals lean by a third.
constexpr V kCorner = {1.3, -0.6, 1.2}, kSideA = {0, 1.2, 0}, kSideB = {0.9, 0, 0.4};
const V kLean = {-0.3, 0.25, -0.95};

TestBlobs leaning_lamp() {
  const auto f = [](double x) { return static_cast<float>(x); };
  wire::MeshData mesh;
  for (const V& p : {kCorner, V{kCorner.x + kSideA.x, kCorner.y + kSideA.y, kCorner.z + kSideA.z},
                     V{kCorner.x + kSideB.x, kCorner.y + kSideB.y, kCorner.z + kSideB.z}}) {
    for (const double x : {p.x, p.y, p.z}) mesh.positions.push_back(f(x));
    for (const double x : {kLean.x, kLean.y, kLean.z}) mesh.normals.push_back(f(x));
  }
  mesh.indices = {0, 1, 2};
  return {{"lamp", wire::encode_mesh(mesh)}};
}

/// The floor's mean radiance under the lamp, whose factor is given the cosines with both normals and the
/// ratio of the BSDF's density to the lamp's.
double floor_radiance(const std::function<double(double cos_s, double cos_g, double ratio)>& factor) {
  const V cross = {kSideA.y * kSideB.z - kSideA.z * kSideB.y, kSideA.z * kSideB.x - kSideA.x * kSideB.z,
                   kSideA.x * kSideB.y - kSideA.y * kSideB.x};
  const double twice = std::sqrt(dot(cross, cross)), area = twice / 2;
  V n = {cross.x / twice, cross.y / twice, cross.z / twice};
  const double lean = std::sqrt(dot(kLean, kLean));
  const V ns = {kLean.x / lean, kLean.y / lean, kLean.z / lean};
  if (dot(n, ns) < 0) n = {-n.x, -n.y, -n.z};
  constexpr int kFloor = 40, kBulb = 60;
  double sum = 0;
  for (int i = 0; i < kFloor * kFloor; ++i) {
    const V at = {-1 + 2 * (i % kFloor + 0.5) / kFloor, -1 + 2 * (i / kFloor + 0.5) / kFloor, 0};
    for (int j = 0; j < kBulb * kBulb; ++j) {
      // Cells of the parallelogram that are in the triangle; those on its edge count by half.
      const int a = j % kBulb, b = j / kBulb;
      if (a + b > kBulb - 1) continue;
      const double weight = a + b == kBulb - 1 ? 0.5 : 1;
      // The middle of a half cell is a third of a cell from its corner.
      const double in = a + b == kBulb - 1 ? 1.0 / 3 : 0.5;
      const double u = (a + in) / kBulb, v = (b + in) / kBulb;
      const V p = {kCorner.x + u * kSideA.x + v * kSideB.x, kCorner.y + u * kSideA.y + v * kSideB.y,
                   kCorner.z + u * kSideA.z + v * kSideB.z};
      const V way = p - at;
      const double d2 = dot(way, way), d = std::sqrt(d2);
      const double cos_floor = way.z / d, cos_g = -dot(n, way) / d, cos_s = -dot(ns, way) / d;
      if (cos_g <= 0) continue;
      const double ratio = cos_floor / kPi / (kPick * d2 / (area * std::max(cos_s, 1e-9)));
      sum += weight * cos_floor * cos_g / d2 * factor(cos_s, cos_g, ratio);
    }
  }
  return 0.5 / kPi * sum * twice / (kBulb * kBulb) / (kFloor * kFloor);
}

std::string floor_and_lamp(const std::string& more) {
  return absl::StrCat(
      "materials { name: 'matt' diffuse { reflectance { constant { constant: 0.5 } } } } shapes { disk { "
      "radius: 9 } "
      "material: 'matt' } "
      "materials { name: 'black' diffuse { reflectance { constant { constant: 0 } } } } "
      "shapes { mesh { blob { digest: 'lamp' } } material: 'black' area_light { radiance { constant: 1 } ",
      more, "} } ", kFromAbove);
}

TEST(VertexNormalsOfALamp, DoNotCountBeforeTheSceneSaysSo) {
  expect_mean({floor_and_lamp(""), 1, "path", "", leaning_lamp()},
              floor_radiance([](double, double, double) { return 1; }), 1e-3);
}

TEST(VertexNormalsOfALamp, CountAsInMitsuba) {
  // Mitsuba's two estimators together, each weighed by its own power heuristic: light samples
  // scaled by the wrong cosine, and rays that meet the lamp.
  const double expected = floor_radiance([](double cos_s, double cos_g, double ratio) {
    if (cos_s <= 0) return 0.0;
    const double weight = 1 / (1 + ratio * ratio);
    return weight * cos_s / cos_g + (1 - weight);
  });
  const std::string scene = floor_and_lamp("interpolated_normal_pick: 0.5 ");
  expect_mean({scene, 1, "path", "", leaning_lamp()}, expected, 1e-3);
  expect_mean({scene, 1, "path", "direct_light: DIRECT_LIGHT_BSDF", leaning_lamp()}, expected, 1e-2);
  expect_mean({scene, 1, "volpath", "", leaning_lamp()}, expected, 1e-3);
  // The difference is what the test is about.
  const double true_normals = floor_radiance([](double, double, double) { return 1; });
  EXPECT_GT(std::abs(expected / true_normals - 1), 0.02);
}

}  // namespace
}  // namespace tessera::test
