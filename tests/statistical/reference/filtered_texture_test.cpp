// Pictures with filtered textures: means that do not depend on the filter, slopes of bumps in closed form,
// and one texture for all ways that light takes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"

namespace tessera::test::filtered_texture {
namespace {

constexpr int kSide = 256;

/// A grey image in the portable float format.
template <class Value>
std::string image_of(Value&& value) {
  std::string file = absl::StrCat("Pf\n", kSide, " ", kSide, "\n-1.0\n");
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const float v = value(x, y);
      file.append(reinterpret_cast<const char*>(&v), sizeof v);
    }
  }
  return file;
}

/// A floor seen straight from above, 2 x 2 of it, with what `texture` says of an image that spans 8 x 8.
std::string floor_with(const std::string& texture, const std::string& material, const std::string& light) {
  return absl::StrCat(
      "textures { name: 'image' image { image { digest: 'image' } ", texture,
      " mapping { source: PLANAR texture_from_world { elements: [0.125,0,0,0.5, 0,0.125,0,0.5, "
      "0,0,0.125,0, 0,0,0,1] } } } } materials { name: 'floor' ",
      material, " } shapes { disk { radius: 9 } material: 'floor' } ", light,
      " camera { orthographic { } world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,4, "
      "0,0,0,1] } } ");
}

TEST(FilteredTexture, KeepsTheMeanOfWhatIsFinerThanAPixel) {
  // Texels of 1/32, half of a pixel, with reflectance 0.2 or 0.8 in stripes.
  PictureRequest request;
  request.max_depth = 1;
  request.spp = 256;
  request.blobs = {{"image", image_of([](int x, int) { return x % 2 == 0 ? 0.2f : 0.8f; })}};
  for (const char* const filter : {"BILINEAR", "NEAREST", "TRILINEAR", "EWA"}) {
    for (const char* const footprint : {"0.125", "1"}) {
      request.scene =
          floor_with(absl::StrCat("filter: ", filter), "diffuse { reflectance { texture: 'image' } }",
                     "lights { distant { direction { z: -1 } irradiance { constant: 2 } } }");
      request.settings = absl::StrCat("texture_footprint: ", footprint);
      SCOPED_TRACE(absl::StrCat(filter, " ", footprint));
      expect_value(measure_picture(request), 2 * 0.5 / std::numbers::pi);
    }
  }
}

TEST(FilteredTexture, BumpsHaveTheSlopeOfWhatAPixelCovers) {
  // Heights that rise by 0.5 along x, with a ripple that is steeper by far from texel to texel.
  constexpr double kSlope = 0.5;
  PictureRequest request;
  request.max_depth = 1;
  request.spp = 64;
  request.blobs = {{"image", image_of([](int x, int) {
                      return static_cast<float>(8.0 * x / kSide * kSlope + 0.1 * (x % 2));
                    })}};
  request.scene =
      floor_with("wrap: CLAMP",
                 "diffuse { reflectance { constant { constant: 0.5 } } } displacement { texture: 'image' }",
                 "lights { distant { direction { z: -1 } irradiance { constant: 2 } } }");
  // Sixteen texels: the ripple is gone but for a 65536th.
  request.settings = "texture_footprint: 4";
  const double flat = 2 * 0.5 / std::numbers::pi;
  expect_value(measure_picture(request), flat / std::sqrt(1 + kSlope * kSlope), 2e-3);
  // A 50th of a texel: slopes of 0.5 + 3.2 and 0.5 - 3.2, half and half.
  request.settings = "texture_footprint: 0.01";
  const auto cosine = [](double slope) { return 1 / std::sqrt(1 + slope * slope); };
  expect_value(measure_picture(request), flat * 0.5 * (cosine(kSlope + 3.2) + cosine(kSlope - 3.2)), 2e-2);
}

TEST(FilteredTexture, IsTheSameForLightFromBothEnds) {
  // A coarse footprint, so that ways that saw different textures would differ: a ball in a corner of coloured
  // grain, lit by a lamp, with all ways that bdpt has against those of path, and light tracing.
  std::mt19937 random(5);
  PictureRequest request;
  request.max_depth = 3;
  request.spp = 256;
  request.settings = "texture_footprint: 2";
  request.blobs = {{"image", image_of([&](int, int) { return (random() & 1) != 0 ? 0.9f : 0.1f; })}};
  request.scene = floor_with(
      "filter: EWA", "diffuse { reflectance { texture: 'image' } }",
      "materials { name: 'lamp' diffuse { reflectance { constant { constant: 0 } } } } "
      "shapes { sphere { radius: 0.3 } material: 'lamp' area_light { radiance { constant: 5 } } "
      "world_from_object { elements: [1,0,0,2, 0,1,0,1, 0,0,1,2, 0,0,0,1] } } "
      "shapes { sphere { radius: 0.5 } material: 'floor' world_from_object { elements: [1,0,0,0.3, "
      "0,1,0,0, 0,0,1,0.2, 0,0,0,1] } }");
  const Picture path = measure_picture(request);
  request.integrator = "bdpt";
  expect_same(path, measure_picture(request));
  request.integrator = "light";
  expect_same(path, measure_picture(request));
}

/// Root of the mean square of what `texture_footprint: 1` with 16 samples differs by from what 1024 samples
/// of texels as they are see, relative to the standard deviation of the latter: of grain that is finer than
/// pixels that is the same number whatever the pixels cover.
double error_of_filter(const std::string& camera) {
  std::mt19937 random(11);
  const TestBlobs blobs = {{"image", image_of([&](int, int) { return (random() & 1) != 0 ? 0.9f : 0.1f; })}};
  const std::string scene = absl::StrCat(
      "film { width: 64 height: 64 filter { kind: BOX } } textures { name: 'image' image { image { digest: "
      "'image' } filter: EWA mapping { source: PLANAR texture_from_world { elements: [0.25,0,0,0.5, "
      "0,0.25,0,0.5, 0,0,0.25,0, 0,0,0,1] } } } } materials { name: 'floor' diffuse { reflectance { texture: "
      "'image' } } } shapes { disk { radius: 99 } material: 'floor' } lights { distant { direction { z: -1 } "
      "irradiance { constant: 1 } } } camera { ",
      camera, " world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,7, 0,0,0,1] } } ");
  const auto picture = [&](double footprint, std::uint32_t spp) {
    SceneJob job;
    job.settings.set_integrator("path");
    job.settings.set_max_depth(1);
    job.settings.set_spp(spp);
    job.settings.set_texture_footprint(footprint);
    const auto file = load_scene_text(scene, job, render::supported_isas().front(), blobs);
    EXPECT_TRUE(file.ok()) << file.status();
    return file.ok() ? render_image(*file).find("R")->values : std::vector<float>();
  };
  const std::vector<float> seen = picture(0.01, 1024), filtered = picture(1, 16);
  double sum = 0, squares = 0, errors = 0;
  for (std::size_t i = 0; i < std::min(seen.size(), filtered.size()); ++i) {
    const double x = seen[i], error = double{filtered[i]} - x;
    sum += x, squares += x * x, errors += error * error;
  }
  const auto count = static_cast<double>(seen.size());
  return std::sqrt(errors / (squares - sum * sum / count));
}

TEST(FilteredTexture, FollowsTheDistortionOfTheFilm) {
  const double plain = error_of_filter("perspective { fov_degrees: 60 }");
  EXPECT_LT(plain, 1);
  for (const char* const camera :
       {"perspective { fov_degrees: 60 } distortion { opencv { k1: 0.6 k2: 0.1 } }",
        "perspective { fov_degrees: 60 } distortion { opencv { k1: -0.3 k2: 0.07 } }"})
    EXPECT_LT(error_of_filter(camera), 1.1 * plain) << camera;
}

}  // namespace
}  // namespace tessera::test::filtered_texture
