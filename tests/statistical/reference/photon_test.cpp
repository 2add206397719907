// Photon mapping: closed forms, path tracing in the limit of no radius, and how its error falls.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"
#include "support/long_form.h"
#include "support/picture/render_image.h"
#include "wire/mesh_blob.h"

namespace tessera::test::photons {  // apart from tests that are compiled with these
namespace {

// Seen from the inside, at (0, 0, 0).
constexpr const char* kInnerCamera = "camera { perspective { fov_degrees: 80 } }";

std::string photon_settings(double radius, int photons, const std::string& more = "") {
  return absl::StrCat("photon { radius: ", radius, " photons: ", photons, " ", more, " }");
}

// ---------------------------------------------------------------- closed forms

/// The inside of a ball that shines everywhere, and reflects a share of the light.
PictureRequest furnace(double reflectance, std::uint32_t max_depth) {
  PictureRequest request;
  request.scene = absl::StrCat(
      kInnerCamera, " materials { name: 'wall' diffuse { reflectance { constant { constant: ", reflectance,
      " } } } }",
      " shapes { sphere { radius: 1 } material: 'wall' area_light { radiance { constant: 1 } two_sided: true "
      "}",
      " world_from_object { elements: [1,0,0,0.3, 0,1,0,-0.2, 0,0,1,0.1, 0,0,0,1] } }");
  request.integrator = "photon";
  request.max_depth = max_depth;
  return request;
}

TEST(PhotonMapping, KeepsTheEnergyOfAFurnace) {
  // Every event adds a power of the reflectance. A ball of radius r about a point of a sphere cuts a cap of
  // area pi r^2 out of it, so that the estimate has no bias at any radius below where the cap leaves the slab
  // about the tangent plane: r / 2 = r^2 / (2 R) at r = R.
  PictureRequest request = furnace(0.7, 5);
  request.settings = photon_settings(0.4, 512, "light: PHOTON_LIGHT_ALL");
  double expected = 0;
  for (int events = 0; events <= 5; ++events) expected += std::pow(0.7, events);
  expect_value(measure_picture(request), expected, 2e-3);
}

TEST(PhotonMapping, KeepsTheEnergyWhenItKeepsAFewPhotons) {
  // Walls that take nothing, and 30 events a path: 3.9 million photons, of which the map has room for half.
  PictureRequest request = furnace(1, 30);
  request.settings = photon_settings(0.2, 1 << 17);
  const auto file =
      load_scene_text(absl::StrCat(request.scene,
                                   " film { width: 16 height: 16 } settings { integrator: 'photon' spp: 1"
                                   " max_depth: 30 ",
                                   request.settings, " }"),
                      {}, render::supported_isas().front());
  ASSERT_TRUE(file.ok()) << file.status();
  const client::Image image = render_image(*file);
  double sum = 0;
  for (const float value : image.find("G")->values) sum += double{value};
  // Estimates have some 10,000 photons each: 1 % of noise in 30 at a pixel, and they share most of their
  // photons only with neighbours, so that 256 of them have far less together.
  EXPECT_NEAR(sum / 256, 31, 0.3);
}

/// Radiance of a white floor, seen straight from above through one pixel's ray, under a light.
double floor_radiance(const std::string& light, std::uint32_t spp) {
  const auto file = load_scene_text(
      absl::StrCat("camera { orthographic {} screen_window: [-0.01, 0.01, -0.01, 0.01]"
                   " world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,0.5, 0,0,0,1] } }"
                   " film { width: 8 height: 8 }"
                   " settings { integrator: 'photon' max_depth: 1 spp: ",
                   spp, " ", photon_settings(0.15, 1 << 15, "light: PHOTON_LIGHT_ALL"), " }",
                   " materials { name: 'white' diffuse { reflectance { constant { constant: 1 } } } }"
                   " shapes { disk { radius: 2 } material: 'white' } ",
                   light),
      {}, render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return 0;
  double sum = 0;
  const client::Image image = render_image(*file);
  for (const float value : image.find("G")->values) sum += double{value};
  return sum / 64;
}

TEST(PhotonMapping, FindsTheIrradianceUnderALampAndADisk) {
  // A lamp of intensity 1 at height h = 1: E = I / h^2 below it, and at a distance x of it
  // h I / (h^2 + x^2)^(3/2), which over a disk of radius r has the mean 2 I / r^2 (1 - h / sqrt(h^2 + r^2)) =
  // 0.9834 for r = 0.15; later passes are nearer to 1. A disk of radius R = 0.5 and radiance 1 at height 1:
  // E = pi R^2 / (R^2 + h^2), flat within 1 % over the radius. Noise: 32768 photons in all directions leave
  // 90 in the disk of the first pass, 64 passes 5,000: 1.4 %; so 5 % are three and a half of these and the
  // blur.
  EXPECT_NEAR(floor_radiance("lights { point { position { z: 1 } intensity { constant: 1 } } }", 64),
              0.99 / std::numbers::pi, 0.05 / std::numbers::pi);
  // A disk shines on one side: its photons are on 2 pi, more of them below it.
  EXPECT_NEAR(floor_radiance("shapes { disk { radius: 0.5 } area_light { radiance { constant: 1 } }"
                             " world_from_object { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,1, 0,0,0,1] } }",
                             64),
              0.25 / 1.25, 0.05 * 0.2);
}

// ---------------------------------------------------------------- edges

/// The right one of two rooms, seen from above: a lamp is in the left one, and a wall between them, which
/// begins at a height.
PictureRequest dark_room(double wall_from, const std::string& integrator) {
  PictureRequest request;
  request.scene = absl::StrCat(
      "camera { orthographic {} screen_window: [-1, 1, -1, 1]"
      "         world_from_camera { elements: [1,0,0,1, 0,-1,0,0, 0,0,-1,1.45, 0,0,0,1] } }"
      " materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } }"
      " shapes { material: 'white' box { low: [-2, -1, 0] high: [2, 1, 1.5] } }"
      " shapes { material: 'white' box { low: [-0.01, -1.1, ",
      wall_from,
      "] high: [0.01, 1.1, 1.6] } }"
      " lights { point { position { x: -1 z: 1.2 } intensity { constant: 1 } } }");
  request.integrator = integrator;
  request.max_depth = 6;
  return request;
}

TEST(PhotonMapping, BringsNoLightThroughAWall) {
  PictureRequest request = dark_room(-0.1, "photon");
  request.settings = photon_settings(0.375, 1024);
  request.spp = 32;
  const Picture picture = measure_picture(request);
  ASSERT_FALSE(picture.values.empty());
  for (const Picture::Value& value : picture.values) EXPECT_EQ(value.mean, 0);
}

TEST(PhotonMapping, BringsHardlyMoreLightThroughASlitThanThereIs) {
  // The slit is 0.1 high, the radius 0.375 at first: with photons that count wherever they lie, it was 40 %.
  const Picture path = measure_picture(dark_room(0.1, "path"));
  PictureRequest request = dark_room(0.1, "photon");
  request.settings = photon_settings(0.375, 1024);
  request.spp = 64;
  const Picture photon = measure_picture(request);
  ASSERT_FALSE(path.values.empty() || photon.values.empty());
  for (int channel = 0; channel < 3; ++channel) {
    const Picture::Value &right = path.whole(channel), &own = photon.whole(channel);
    EXPECT_LT(std::hypot(right.error, own.error), 0.03 * right.mean);
    EXPECT_NEAR(own.mean, right.mean, 0.1 * right.mean + 6 * std::hypot(right.error, own.error));
  }
}

// ---------------------------------------------------------------- no radius

/// The picture for a radius of 0, from those of radii r, r / 2 and r / 4: what is in proportion to r (edges)
/// and to r^2 (curvature) drops out. Those of caustics are `caustics` times as large.
Picture without_radius(PictureRequest request, double radius, double caustics, int photons) {
  Picture pictures[3];
  for (int i = 0; i < 3; ++i, radius /= 2) {
    request.settings = photon_settings(radius, photons, absl::StrCat("caustic_radius: ", caustics * radius));
    pictures[i] = measure_picture(request);
  }
  Picture result;
  for (std::size_t v = 0; v < pictures[0].values.size(); ++v) {
    const auto& [whole, half, quarter] = pictures;
    const auto at = [&](const Picture& p) { return p.values[v]; };
    result.values.push_back({(at(whole).mean - 6 * at(half).mean + 8 * at(quarter).mean) / 3,
                             std::hypot(at(whole).error, 6 * at(half).error, 8 * at(quarter).error) / 3});
  }
  return result;
}

/// A square of side 2 in the plane z = 0, its normal down.
std::string square() {
  wire::MeshData mesh;
  mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  mesh.indices = {0, 2, 1, 0, 3, 2};
  return wire::encode_mesh(mesh);
}

struct Case {
  const char* name;
  std::string light;
  std::string material = "diffuse { reflectance { constant { rgb { r: 0.7 g: 0.6 b: 0.8 } } } }";
  std::string camera = "perspective { fov_degrees: 45 }";
  std::string motion = "";
  std::string eye = "-4, 0,0.8386,-0.5448,3";  // y and z of the camera's place, an axis between them
  std::string reference = "path";
  double error = 0.01;  // relative error of the whole picture
  double caustics = 1;  // their radius, as a part of the others'
};

constexpr const char* kLamp =
    R"( shapes { mesh { blob { digest: 'square' } } area_light { radiance { constant: 3 } }
    world_from_object { elements: [0.6,0,0,0.3, 0,0.6,0,-0.4, 0,0,1,2.5, 0,0,0,1] } } )";

/// A floor and a wall, and a ball on the floor.
std::string scene_of(const Case& c) {
  return absl::StrCat("camera { ", c.camera, R"( world_from_camera { elements: [1,0,0,0, 0,0.5448,0.8386,)",
                      c.eye, R"(, 0,0,0,1] } }
    materials { name: 'floor' diffuse { reflectance { constant { rgb { r: 0.6 g: 0.5 b: 0.4 } } } } }
    shapes { disk { radius: 3 } material: 'floor' }
    shapes { disk { radius: 3 } material: 'floor'
      world_from_object { elements: [0,0,1,-2, 0,1,0,0, -1,0,0,0, 0,0,0,1] } }
    materials { name: 'm' )",
                      c.material, " } shapes { sphere { radius: 0.6 } material: 'm' ", c.motion,
                      " world_from_object { elements: [1,0,0,-0.2, 0,1,0,0, 0,0,1,0.7, 0,0,0,1] } }",
                      c.light);
}

class PhotonLimit : public testing::TestWithParam<Case> {};

TEST_P(PhotonLimit, IsThePictureOfTheReference) {
  PictureRequest request;
  request.scene = scene_of(GetParam());
  request.blobs = {{"square", square()}};
  request.max_depth = 4;
  request.integrator = GetParam().reference;
  const Picture path = measure_picture(request);
  request.integrator = "photon";
  request.spp = long_form() ? 4096 : 512;
  const Picture photon = without_radius(request, 0.24, GetParam().caustics, 4096);
  ASSERT_FALSE(path.values.empty() || photon.values.empty());
  EXPECT_GT(path.whole(1).mean, 0.005);
  EXPECT_LT(photon.whole(1).error, GetParam().error * photon.whole(1).mean);
  // The rest of r^3: a ball of radius 0.6 fills half of the largest estimates' reach.
  expect_same(path, photon, 5e-3);
}

INSTANTIATE_TEST_SUITE_P(
    , PhotonLimit,
    testing::Values(
        Case{"Lamp", kLamp},
        // Few photons are bright here: what is known of the noise depends on the seed.
        Case{.name = "PointThroughGlass",
             .light =
                 "lights { point { position { x: 0.5 y: -1 z: 2.5 } intensity { rgb { r: 8 g: 6 b: 4 } } } }",
             .material =
                 "dielectric { eta { constant: 1.3 } roughness { u { constant: 0.4 } v { constant: 0.4 } } }",
             .error = 0.02},
        Case{.name = "SoftPointThroughGlass",
             .light = "lights { point { position { x: 0.5 y: -1 z: 2.5 } intensity { rgb { r: 8 g: 6 b: 4 } }"
                      " radius: 0.5 } }",
             .material =
                 "dielectric { eta { constant: 1.3 } roughness { u { constant: 0.4 } v { constant: 0.4 } } }",
             .error = 0.02},
        Case{.name = "LampThroughGlass",
             .light = kLamp,
             .material = "dielectric { eta { constant: 1.5 } }",
             .reference = "bdpt",
             .caustics = 0.5},
        Case{"SkyOnGlossyMetal", "lights { infinite { radiance { rgb { r: 0.5 g: 1 b: 1.5 } } } }",
             "conductor { reflectance { constant { constant: 0.8 } } roughness { u { constant: 0.2 } v { "
             "constant: 0.3 } } }"},
        Case{"DistantOnVarnish",
             "lights { distant { direction { x: 0.5 y: 0.3 z: -1 } irradiance { rgb { r: 2 g: 3 b: 1 } } } }",
             "coated_diffuse { reflectance { constant { constant: 0.6 } } eta { constant: 1.5 } roughness { "
             "u { constant: 0.1 } v { constant: 0.1 } } }"},
        // A window of two panes: light that comes straight through them is found from the lamp alone. Few
        // photons of a narrow lobe are noisy; without them some blocks would lack five sixths of their light.
        Case{.name = "DistantThroughAWindowOnMetal",
             .light = R"(lights { distant { direction { x: 0.5 y: 0.3 z: -1 } irradiance { constant: 2 } } }
                 materials { name: 'pane' dielectric { eta { constant: 1.5 } } }
                 shapes { disk { radius: 2 } material: 'pane'
                   world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,2.1, 0,0,0,1] } }
                 shapes { disk { radius: 2 } material: 'pane'
                   world_from_object { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,2, 0,0,0,1] } })",
             .material = "conductor { reflectance { constant { constant: 0.8 } } roughness { u { constant: "
                         "0.15 } v { constant: 0.15 } } }",
             .camera = "perspective { fov_degrees: 20 }",
             .reference = "bdpt",
             .error = 0.1},
        Case{"TransmissionAllAround", kLamp,
             "diffuse_transmission { reflectance { constant { constant: 0.3 } } transmittance { constant { "
             "constant: 0.5 } } }",
             "spherical { mapping: EQUIRECTANGULAR }", "", "-1.2, 0,0.8386,-0.5448,1.2"},
        Case{.name = "Motion",
             .light = kLamp,
             .motion = "world_from_object_end { elements: [1,0,0,0.5, 0,1,0,0, 0,0,1,0.7, 0,0,0,1] }"}),
    [](const testing::TestParamInfo<Case>& test) { return std::string(test.param.name); });

// ---------------------------------------------------------------- convergence

/// A floor under a lamp near by, by photons alone: it is bright in one place, and its irradiance is known.
struct LitFloor {
  static constexpr int kSide = 16;
  static constexpr double kHeight = 0.4, kHalf = 0.5;  // height of the lamp, half the picture's side

  std::vector<double> render(double radius, int photons, std::uint32_t passes, std::uint64_t seed,
                             const char* map = "PHOTON_MAP_PROGRESSIVE") const {
    const auto file = load_scene_text(
        absl::StrCat(
            "camera { orthographic {} screen_window: [-", kHalf, ", ", kHalf, ", -", kHalf, ", ", kHalf,
            "] world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,0.3, 0,0,0,1] } }"
            " film { width: ",
            kSide, " height: ", kSide, " filter { kind: BOX radius_x: 1e-6 radius_y: 1e-6 } }",
            " settings { integrator: 'photon' max_depth: 1 sampler: SAMPLER_INDEPENDENT spp: ", passes,
            " seed: ", seed, " ",
            photon_settings(radius, photons, absl::StrCat("light: PHOTON_LIGHT_ALL map: ", map)), " }",
            " materials { name: 'white' diffuse { reflectance { constant { constant: 1 } } } }"
            " shapes { disk { radius: 5 } material: 'white' }"
            " lights { point { position { z: ",
            kHeight, " } intensity { constant: 1 } } }"),
        {}, render::supported_isas().front());
    EXPECT_TRUE(file.ok()) << file.status();
    if (!file.ok()) return {};
    const client::Image image = render_image(*file);
    const std::vector<float>& green = image.find("G")->values;
    return {green.begin(), green.end()};
  }

  static double truth(int pixel) {
    const auto at = [](int i) { return kHalf * ((i + 0.5) / (kSide / 2) - 1); };
    const double x = at(pixel % kSide), y = at(pixel / kSide);
    return kHeight / std::pow(kHeight * kHeight + x * x + y * y, 1.5) / std::numbers::pi;
  }
};

TEST(PhotonConvergence, ErrorsFallAsTheoryHasIt) {
  // With r_i^2 = r_1^2 i^(-1/3), the variance of pass i goes with i^(1/3) and its bias with i^(-1/3) (to
  // second order in r), so that after N passes variance is V S_v(N), S_v = sum i^(1/3) / N^2 ~ N^(-2/3), and
  // bias B S_b(N), S_b = sum i^(-1/3) / N ~ N^(-1/3): the mean squared error falls as N^(-2/3) [Knaus &
  // Zwicker 2011].
  const LitFloor floor;
  const auto sum_of_powers = [](std::uint32_t n, double power) {
    double sum = 0;
    for (std::uint32_t i = 1; i <= n; ++i) sum += std::pow(i, power);
    return sum;
  };
  constexpr std::uint32_t kFew = 8, kMany = 512;
  const auto errors = [&](std::uint32_t passes, double radius, int photons) {
    struct {
      double variance = 0, bias2 = 0, mse = 0;
    } result;
    constexpr int kSeeds = 8;
    constexpr std::size_t kPixels = LitFloor::kSide * LitFloor::kSide;
    std::vector<double> sum(kPixels), squares(kPixels);
    for (int seed = 0; seed < kSeeds; ++seed) {
      const std::vector<double> values =
          floor.render(radius, photons, passes, static_cast<std::uint64_t>(seed));
      for (std::size_t p = 0; p < values.size(); ++p) {
        const double error = values[p] - LitFloor::truth(static_cast<int>(p));
        sum[p] += error;
        squares[p] += error * error;
      }
    }
    for (std::size_t p = 0; p < kPixels; ++p) {
      const double mean = sum[p] / kSeeds, mse = squares[p] / kSeeds;
      const double variance = (mse - mean * mean) * kSeeds / (kSeeds - 1);
      result.variance += variance / kPixels;
      result.bias2 += (mean * mean - variance / kSeeds) / kPixels;
      result.mse += mse / kPixels;
    }
    return result;
  };

  // Few photons, a small radius: noise alone. 256 pixels of 8 seeds, neighbours of which share photons in the
  // first passes, are worth some 500 degrees of freedom: 6 % of standard error, 9 % of the ratio; a quarter
  // is nearly three.
  const auto noisy_few = errors(kFew, 0.05, 512), noisy_many = errors(kMany, 0.05, 512);
  const auto spread = [&](std::uint32_t n) { return sum_of_powers(n, 1.0 / 3) / n / n; };
  EXPECT_NEAR(noisy_few.variance / noisy_many.variance / (spread(kFew) / spread(kMany)), 1, 0.25);
  EXPECT_LT(noisy_many.bias2, 0.1 * noisy_many.variance) << "it was to be noise that is measured";

  // Many photons, a large radius: bias. Terms of r^4 shrink the first passes': r / height is 0.5 there, and
  // the series of the lamp's irradiance has 15/8 (r/h)^4 after 3/2 (r/h)^2 (of the means over disks: 5/8
  // after 3/4), so that B is up to a fifth less in the first pass.
  const auto blurred_few = errors(kFew, 0.2, 1 << 15), blurred_many = errors(kMany, 0.2, 1 << 10);
  const auto blur = [&](std::uint32_t n) { return sum_of_powers(n, -1.0 / 3) / n; };
  EXPECT_NEAR(std::sqrt(blurred_few.bias2 / blurred_many.bias2) / (blur(kFew) / blur(kMany)), 1, 0.25);
  EXPECT_LT(blurred_few.variance, blurred_few.bias2) << "it was to be bias that is measured";

  // And both together, where they are about alike: the exponent of the mean squared error.
  const auto both_few = errors(kFew, 0.15, 1 << 11), both_many = errors(kMany, 0.15, 1 << 11);
  const double exponent = std::log(both_many.mse / both_few.mse) / std::log(double{kMany} / kFew);
  RecordProperty("exponent", absl::StrCat(exponent));
  EXPECT_NEAR(exponent, -2.0 / 3, 0.1);
}

TEST(PhotonConvergence, TheClassicMapKeepsItsError) {
  // All of its passes gather the same photons, and pixels look through their middles: each pass is the first,
  // whatever their number. Sums of 64 equal floats divided by 64 are off by 64 roundings at most.
  const LitFloor floor;
  const std::vector<double> one = floor.render(0.2, 1 << 14, 1, 1, "PHOTON_MAP_CLASSIC"),
                            many = floor.render(0.2, 1 << 14, 64, 1, "PHOTON_MAP_CLASSIC"),
                            progressive = floor.render(0.2, 1 << 14, 64, 1);
  double error = 0, progressive_error = 0;
  for (std::size_t p = 0; p < one.size(); ++p) {
    EXPECT_NEAR(many[p], one[p], 64 * 6e-8 * one[p]);
    error += std::abs(many[p] - LitFloor::truth(static_cast<int>(p)));
    progressive_error += std::abs(progressive[p] - LitFloor::truth(static_cast<int>(p)));
  }
  // By the sums of powers above, bias is 0.37 of the first pass's.
  EXPECT_LT(progressive_error, 0.6 * error);
}

}  // namespace
}  // namespace tessera::test::photons
