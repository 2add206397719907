// Places, normals, motion and Cryptomatte of what camera rays meet first, against closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "image/image.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"
#include "wire/algorithm.h"
#include "wire/mesh_blob.h"
#include "wire/tile_result.h"

namespace tessera::test::first_hits {
namespace {

constexpr int kSide = 32;
constexpr double kPixel = 2.0 / kSide;  // the film shows [-1, 1]^2
constexpr std::uint32_t kSamples = 16;

std::string at(double x, double y, double z) {
  return absl::StrCat("{ elements: [1,0,0,", x, ", 0,1,0,", y, ", 0,0,1,", z, ", 0,0,0,1] }");
}

constexpr const char* kFilm =
    " film { width: 32 height: 32 filter { kind: BOX } } lights { infinite { radiance { constant: 1 } } } ";

client::Image render(const std::string& scene, std::vector<v1::AOV> aovs,
                     const std::string& integrator = "path", double noise = 0, const TestBlobs& blobs = {}) {
  SceneJob job;
  job.settings.set_integrator(integrator);
  job.settings.set_spp(kSamples);
  job.settings.set_max_depth(1);
  if (noise > 0) job.settings.set_noise(noise);
  std::ranges::sort(aovs);
  job.aovs = std::move(aovs);
  const auto file =
      load_scene_text(absl::StrCat(scene, kFilm), job, ::tessera::render::supported_isas().front(), blobs);
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? render_image(*file) : client::Image{};
}

float value(const client::Image& image, const std::string& channel, int x, int y) {
  const client::Channel* const found = image.find(channel);
  EXPECT_NE(found, nullptr) << channel;
  return found == nullptr ? NAN : found->values[static_cast<std::size_t>(y * kSide + x)];
}

/// The middle of a pixel, in camera space.
double middle_x(int x) { return -1 + (x + 0.5) * kPixel; }
double middle_y(int y) { return 1 - (y + 0.5) * kPixel; }

TEST(FirstHits, PlacesAreInWorldSpaceWhereverTheCameraStands) {
  // At (10, 20, 30), towards +x; a wall five units ahead.
  const std::string scene =
      "camera { orthographic {} world_from_camera { elements: [0,0,1,10, 0,1,0,20, -1,0,0,30, 0,0,0,1] } } "
      "shapes { disk { radius: 9 } world_from_object { elements: [0,0,1,15, 0,1,0,20, -1,0,0,30, 0,0,0,1] } "
      "}";
  const client::Image image = render(scene, {v1::AOV_POSITION, v1::AOV_CAMERA_NORMAL, v1::AOV_NORMAL});
  for (int y = 0; y < kSide; y += 5) {
    for (int x = 0; x < kSide; x += 5) {
      EXPECT_NEAR(value(image, "position.X", x, y), 15, 1e-4);
      // A mean over the pixel.
      EXPECT_NEAR(value(image, "position.Y", x, y), 20 + middle_y(y), kPixel / 2);
      EXPECT_NEAR(value(image, "position.Z", x, y), 30 - middle_x(x), kPixel / 2);
      EXPECT_NEAR(value(image, "normal.X", x, y), -1, 1e-5);
      EXPECT_NEAR(value(image, "camera-normal.Z", x, y), -1, 1e-5);
      EXPECT_NEAR(value(image, "camera-normal.X", x, y), 0, 1e-5);
    }
  }
}

TEST(FirstHits, NormalsOfASphereTurnTowardsTheCamera) {
  const client::Image image =
      render(absl::StrCat("camera { orthographic {} } shapes { sphere { radius: 0.9 } world_from_object ",
                          at(0, 0, 5), " }"),
             {v1::AOV_CAMERA_NORMAL});
  for (int i = 8; i < 24; i += 3) {
    const double x = middle_x(i), y = middle_y(20);
    // Within a pixel the normal turns by half a pixel over the radius, more where the sphere falls away: by
    // 1 / cos^2 at most, of 0.5 here.
    const double bound = kPixel / 2 / 0.9 / 0.5;
    EXPECT_NEAR(value(image, "camera-normal.X", i, 20), x / 0.9, bound);
    EXPECT_NEAR(value(image, "camera-normal.Y", i, 20), y / 0.9, bound);
    EXPECT_NEAR(value(image, "camera-normal.Z", i, 20), -std::sqrt(1 - (x * x + y * y) / 0.81), bound);
  }
}

TEST(FirstHits, TextureCoordinatesOfADiskAreItsPolarOnes) {
  const client::Image image =
      render(absl::StrCat("camera { orthographic {} } shapes { disk { radius: 2 } world_from_object ",
                          at(0, 0, 5), " }"),
             {v1::AOV_UV});
  // u is the angle, v the way in from the rim [pbrt-v4 Disk].
  const double x = middle_x(24), y = middle_y(8);
  EXPECT_NEAR(value(image, "uv.U", 24, 8), std::atan2(y, x) / (2 * std::numbers::pi),
              kPixel / std::hypot(x, y));
  EXPECT_NEAR(value(image, "uv.V", 24, 8), 1 - std::hypot(x, y) / 2, kPixel / 2);
}

TEST(FirstHits, MotionIsTheWayOverTheFilmWhileTheShutterIsOpen) {
  // A disk goes a quarter to the right and an eighth up, seen over the wall.
  const std::string shapes = absl::StrCat("shapes { disk { radius: 9 } world_from_object ", at(0, 0, 5), " }",
                                          "shapes { disk { radius: 0.5 } world_from_object ", at(0, 0, 3),
                                          " world_from_object_end ", at(0.25, 0.125, 3), " }");
  const client::Image still = render("camera { orthographic {} } " + shapes, {v1::AOV_MOTION});
  EXPECT_NEAR(value(still, "motion.U", 17, 15), 0.25 / kPixel, 1e-3);
  EXPECT_NEAR(value(still, "motion.V", 17, 15), -0.125 / kPixel, 1e-3);
  EXPECT_EQ(value(still, "motion.U", 1, 1), 0);
  // The camera goes the same way: the disk stands still on the film, and the wall goes back.
  const client::Image moved = render(
      absl::StrCat("camera { orthographic {} world_from_camera_end ", at(0.25, 0.125, 0), " } ", shapes),
      {v1::AOV_MOTION});
  EXPECT_NEAR(value(moved, "motion.U", 15, 15), 0, 1e-3);
  EXPECT_NEAR(value(moved, "motion.U", 1, 1), -0.25 / kPixel, 1e-3);
  EXPECT_NEAR(value(moved, "motion.V", 1, 1), 0.125 / kPixel, 1e-3);
}

TEST(FirstHits, MotionIsFromTheFirstKeyToTheLastWhateverTheShutterDoes) {
  // The disk goes far away in between, and the camera's rows are exposed one after the other.
  const std::string shapes = absl::StrCat("shapes { disk { radius: 9 } world_from_object ", at(0, 0, 5),
                                          " } ", "shapes { disk { radius: 0.5 } world_from_object ",
                                          at(0, 0, 3), " motion { time: 0.5 place ", at(0.2, -0.2, 3),
                                          " } motion { time: 1 place ", at(0.25, 0.125, 3), " } } ");
  const client::Image image =
      render("camera { orthographic {} shutter { rolling { direction: UP duration: 0.4 } } } " + shapes,
             {v1::AOV_MOTION});
  EXPECT_NEAR(value(image, "motion.U", 17, 15), 0.25 / kPixel, 1e-3);
  EXPECT_NEAR(value(image, "motion.V", 17, 15), -0.125 / kPixel, 1e-3);
  EXPECT_EQ(value(image, "motion.U", 1, 1), 0);
}

double coverage_of(const client::Image& image, const std::string& list, float identifier, std::size_t pixel) {
  double sum = 0;
  for (std::size_t entry = 0; entry < wire::kListEntries; ++entry) {
    const client::Channel *const id = image.find(absl::StrCat(list, ".id", entry)),
                                 *const weight = image.find(absl::StrCat(list, ".weight", entry));
    if (weight->values[pixel] != 0 && (identifier == 0 || id->values[pixel] == identifier))
      sum += weight->values[pixel];
  }
  return sum;
}

/// A square of side 1 in the plane z = 3 about (x, y).
std::string square(float x, float y) {
  wire::MeshData mesh;
  for (const float j : {-0.5f, 0.5f})
    for (const float i : {-0.5f, 0.5f}) mesh.positions.insert(mesh.positions.end(), {x + i, y + j, 3});
  mesh.indices = {0, 1, 3, 0, 3, 2};
  return wire::encode_mesh(mesh);
}

TEST(FirstHits, MotionAndMattesOfShapesThatDeformAreThoseOfTheirPoints) {
  // Strands along y, half a unit thick, do as a square does.
  const auto strand = [](float x, float y) {
    std::string bytes;
    for (int k = 0; k < 4; ++k) {
      const float point[4] = {x, y + static_cast<float>(k) / 3 - 0.5f, 3, 0.25f};
      bytes.append(reinterpret_cast<const char*>(point), sizeof point);
    }
    return bytes;
  };
  const TestBlobs blobs = {{"first", square(0, 0)},
                           {"last", square(0.25f, 0.125f)},
                           {"starts", std::string(sizeof(std::uint32_t), '\0')},
                           {"first points", strand(0, 0)},
                           {"last points", strand(0.25f, 0.125f)}};
  for (const char* const shape :
       {"mesh { blob { digest: 'first' } later_blobs { digest: 'last' } }",
        "curves { starts { digest: 'starts' } points { digest: 'first points' } later_points { digest: "
        "'last points' } }"}) {
    const client::Image image =
        render(absl::StrCat("camera { orthographic {} } shapes { disk { radius: 9 } world_from_object ",
                            at(0, 0, 5), " } shapes { ", shape, " }"),
               {v1::AOV_MOTION, v1::AOV_CRYPTO_OBJECT}, "path", 0, blobs);
    EXPECT_NEAR(value(image, "motion.U", 17, 15), 0.25 / kPixel, 1e-3);
    EXPECT_NEAR(value(image, "motion.V", 17, 15), -0.125 / kPixel, 1e-3);
    EXPECT_EQ(value(image, "motion.U", 1, 1), 0);
    // Its area on the film, at whatever time: 5 standard deviations of pixels at its edges.
    const double area = shape[0] == 'm' ? 1 : 0.5;
    double seen = 0;
    for (std::size_t i = 0; i < image.pixel_count(); ++i) seen += coverage_of(image, "crypto-object", 2, i);
    EXPECT_NEAR(seen * kPixel * kPixel, area,
                5 * kPixel * kPixel * 0.5 / std::sqrt(kSamples) * std::sqrt(4 / kPixel * (0.25 / kPixel)));
  }
}

TEST(FirstHits, MotionOfWhatComesCloserIsTheProjections) {
  // At one unit from the axis, from 4 to 2 units away: from 1/4 to 1/2 on the plane z = 1.
  const client::Image image =
      render(absl::StrCat("camera { perspective { fov_degrees: 90 } } shapes { sphere { radius: 0.1 } "
                          "world_from_object ",
                          at(1, 0, 4), " world_from_object_end ", at(1, 0, 2), " } ",
                          "shapes { disk { radius: 99 } world_from_object ", at(0, 0, 9), " }"),
             {v1::AOV_MOTION, v1::AOV_ID});
  float most = 0;
  for (int x = 18; x < 26; ++x) most = std::max(most, value(image, "motion.U", x, 15));
  EXPECT_GT(most, 0);
  // Pixels mix it with the wall, whose motion is 0: no more than its own, and that of its near side.
  EXPECT_LT(most, 0.25 / kPixel * 1.2);
}

const std::string kCoins =
    "camera { orthographic {} } materials { name: 'red' diffuse {} } materials { name: 'blue' diffuse {} } " +
    absl::StrCat("shapes { disk { radius: 9 } material: 'blue' world_from_object ", at(0, 0, 5), " } ") +
    absl::StrCat("shapes { disk { radius: 0.4 } material: 'red' world_from_object ", at(-0.5, 0.5, 3),
                 " } ") +
    "objects { name: 'coin' shapes { disk { radius: 0.3 } material: 'red' } } " +
    absl::StrCat("instances { object: 'coin' world_from_instance ", at(0.5, 0.5, 3), " } ") +
    absl::StrCat("instances { object: 'coin' world_from_instance ", at(0.5, -0.5, 3), " } ");

const std::vector<v1::AOV> kMattes = {v1::AOV_CRYPTO_OBJECT, v1::AOV_CRYPTO_MATERIAL, v1::AOV_CRYPTO_ASSET,
                                      v1::AOV_MATERIAL_ID};

void expect_coins(const client::Image& image) {
  const auto area_of = [&](const char* list, float identifier) {
    double sum = 0;
    for (std::size_t i = 0; i < image.pixel_count(); ++i) sum += coverage_of(image, list, identifier, i);
    return sum * kPixel * kPixel;
  };
  // Each of the some 2 pi r / pixel * 1.3 pixels at an edge is off by a binomial of kSamples, at most; 5
  // standard deviations.
  const auto bound = [](double radius) {
    return 5 * kPixel * kPixel * 0.5 / std::sqrt(kSamples) *
           std::sqrt(2 * std::numbers::pi * radius / kPixel * 1.3);
  };
  const double big = std::numbers::pi * 0.16, small = std::numbers::pi * 0.09;
  EXPECT_NEAR(area_of("crypto-object", 2), big, bound(0.4));
  EXPECT_NEAR(area_of("crypto-object", 3), 2 * small, 2 * bound(0.3));
  EXPECT_NEAR(area_of("crypto-material", 1), big + 2 * small, bound(0.4) + 2 * bound(0.3));
  EXPECT_NEAR(area_of("crypto-asset", -2), big, bound(0.4));
  EXPECT_NEAR(area_of("crypto-asset", 1), small, bound(0.3));
  EXPECT_NEAR(area_of("crypto-asset", 2), small, bound(0.3));
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    for (const char* list : {"crypto-object", "crypto-material", "crypto-asset"})
      EXPECT_NEAR(coverage_of(image, list, 0, i), 1, 1e-5) << list << " of pixel " << i;
  }
}

TEST(FirstHits, MattesCoverTheAreasOfTheirThingsWhateverTheAlgorithm) {
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms()) {
    if (!algorithm.first_hit_aovs || !algorithm.phases.empty()) continue;
    SCOPED_TRACE(algorithm.name);
    expect_coins(render(kCoins, kMattes, algorithm.name));
  }
}

TEST(FirstHits, MattesCoverTheAreasOfWhatMovesFromKeyToKey) {
  // All that is over the film at every time has its area, wherever it goes.
  const std::string coins =
      "camera { orthographic {} shutter { trapezoid { opening: 0.4 } } } materials { name: 'red' diffuse {} "
      "} "
      "materials { name: 'blue' diffuse {} } " +
      absl::StrCat("shapes { disk { radius: 9 } material: 'blue' world_from_object ", at(0, 0, 5), " } ") +
      absl::StrCat("shapes { disk { radius: 0.4 } material: 'red' world_from_object ", at(-0.5, 0.5, 3),
                   " motion { time: 0.3 place ", at(-0.3, 0.4, 3), " turn { axis { z: 1 } degrees: 300 } } ",
                   " motion { time: 0.8 place ", at(-0.5, 0.3, 3), " } } ") +
      "objects { name: 'coin' shapes { disk { radius: 0.3 } material: 'red' } } " +
      absl::StrCat("instances { object: 'coin' world_from_instance ", at(0.5, 0.5, 3),
                   " motion { time: 1 place ", at(0.6, 0.6, 3), " } } ") +
      absl::StrCat("instances { object: 'coin' world_from_instance ", at(0.5, -0.5, 3),
                   " motion { time: 0.5 place ", at(0.4, -0.6, 3), " } } ");
  for (const char* const algorithm : {"path", "bdpt", "light", "vcm"}) {
    SCOPED_TRACE(algorithm);
    expect_coins(render(coins, kMattes, algorithm));
  }
}

TEST(FirstHits, MattesOfAdaptiveSamplesAddUpToo) { expect_coins(render(kCoins, kMattes, "path", 0.5)); }

TEST(FirstHits, NothingIsInNoMatte) {
  const client::Image image =
      render(absl::StrCat("camera { orthographic {} } shapes { sphere { radius: 0.5 } world_from_object ",
                          at(0, 0, 5), " }"),
             {v1::AOV_CRYPTO_OBJECT, v1::AOV_MATERIAL_ID});
  for (std::size_t i = 0; i < image.pixel_count(); ++i)
    EXPECT_NEAR(coverage_of(image, "crypto-object", 0, i), image.find("A")->values[i], 1e-5);
  EXPECT_EQ(value(image, "id.material", 0, 0), 0);
}

}  // namespace
}  // namespace tessera::test::first_hits
