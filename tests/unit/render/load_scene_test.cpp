// Whole small scenes: closed-form radiance, and scenes that must be refused by name.
#include "render/scene/load_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <string>

#include "absl/strings/str_cat.h"
#include "support/picture/scene_file.h"
#include "wire/algorithm.h"

namespace tessera::test {
namespace {

using testing::HasSubstr;

constexpr const char* kCameraAndFilm = R"(
  camera { perspective { fov_degrees: 20 }
    world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } }
  film { width: 16 height: 16 }
)";

struct Mean {
  double rgb[3];
  double standard_error[3];
};

/// Mean over all pixels of a 16 x 16 picture of the scene.
Mean render_mean(const std::string& scene, std::uint32_t spp, std::uint32_t max_depth,
                 const std::string& isa) {
  test::SceneJob job;
  job.settings.set_spp(spp);
  job.settings.set_max_depth(max_depth);
  const auto file = load_scene_text(absl::StrCat(scene, kCameraAndFilm), job, isa);
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return {};
  render::RenderStats stats;
  const auto tile = file->scene->render_tile({0, 0, 16, 16, 0, spp}, {}, stats);
  EXPECT_TRUE(tile.ok()) << tile.status();
  EXPECT_EQ(stats.dropped_samples, 0u);
  Mean mean{};
  for (int c = 0; c < 3; ++c) {
    double sum = 0, sum2 = 0;
    for (int i = 0; i < 256; ++i) {
      const double x = double{tile->values[static_cast<std::size_t>(c * 256 + i)]} / spp;
      sum += x;
      sum2 += x * x;
    }
    mean.rgb[c] = sum / 256;
    mean.standard_error[c] = std::sqrt(std::max(0.0, sum2 / 256 - mean.rgb[c] * mean.rgb[c]) / 255);
  }
  return mean;
}

std::string furnace(const std::string& material) {
  // The sphere fills the view; everything around it has radiance 1.
  return absl::StrCat("lights { infinite { radiance { constant: 1 } } } materials { name: 'm' ", material,
                      " } shapes { sphere { radius: 1.5 } material: 'm' } ");
}

struct FurnaceCase {
  const char* name;
  const char* material;
  double expected;   // radiance of the sphere
  double tolerance;  // beyond the noise, relative
};

class Furnace : public testing::TestWithParam<FurnaceCase> {};

TEST_P(Furnace, ShowsTheAlbedo) {
  for (const std::string& isa : render::supported_isas()) {
    const Mean mean = render_mean(furnace(GetParam().material), 64, 200, isa);
    for (int c = 0; c < 3; ++c) {
      // Five standard errors: one false alarm in 1.7 million.
      EXPECT_NEAR(mean.rgb[c], GetParam().expected, 5 * mean.standard_error[c] + GetParam().tolerance) << isa;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Materials, Furnace,
    testing::Values(
        // 1e-6 for rounding; Russian roulette ends paths of depth 200 without bias.
        FurnaceCase{"diffuse_white", "diffuse { reflectance { constant { constant: 1 } } }", 1, 1e-6},
        FurnaceCase{"diffuse_grey", "diffuse { reflectance { constant { constant: 0.3 } } }", 0.3, 1e-6},
        FurnaceCase{"glass", "dielectric { eta { constant: 1.5 } }", 1, 1e-5},
        FurnaceCase{"thin_glass", "thin_dielectric { eta { constant: 1.5 } }", 1, 1e-5},
        // Conductors given by reflectance are clamped to 0.9999.
        FurnaceCase{"mirror", "conductor { reflectance { constant { constant: 1 } } }", 0.9999, 1e-5},
        FurnaceCase{"transmission",
                    "diffuse_transmission { reflectance { constant { constant: 0.5 } } "
                    "transmittance { constant { constant: 0.5 } } }",
                    1, 1e-5},
        // 1e-3: quadrature of the coat's internal reflectance, magnified by the white base.
        FurnaceCase{"smooth_coat",
                    "coated_diffuse { reflectance { constant { constant: 1 } } eta { constant: 1.5 } }", 1,
                    1e-3}),
    [](const auto& instance) { return std::string(instance.param.name); });

TEST(DirectLight, SquareLampOverAFloorHasTheFormFactorsRadiance) {
  // A floor seen from above: a disk of radius 1 at distance h, coaxial, gives the point under its centre the
  // irradiance pi L / (1 + h^2) [Howell, configuration B-14]; the camera looks at that point through a narrow
  // angle.
  const char* scene = R"(
    materials { name: 'floor' diffuse { reflectance { constant { constant: 0.5 } } } }
    materials { name: 'black' diffuse { reflectance { constant { constant: 0 } } } }
    shapes { disk { radius: 100 } material: 'floor' }
    shapes { disk { radius: 1 inner_radius: 0 height: 2 } material: 'black' reverse_orientation: true
             area_light { radiance { constant: 3 } } }
    camera { perspective { fov_degrees: 0.2 }
             world_from_camera { elements: [1,0,0,1.8, 0,1,0,0, 0,0,-1,1.8, 0,0,0,1] } }
    film { width: 16 height: 16 }
  )";
  // The camera stands at (1.8, 0, 1.8) and looks straight down at (1.8, 0, 0), beside the axis.
  test::SceneJob job;
  job.settings.set_spp(256);
  job.settings.set_max_depth(1);
  const auto file = load_scene_text(scene, job, render::supported_isas().front());
  ASSERT_TRUE(file.ok()) << file.status();
  render::RenderStats stats;
  const auto tile = file->scene->render_tile({0, 0, 16, 16, 0, 256}, {}, stats);
  ASSERT_TRUE(tile.ok());
  double mean = 0, mean_of_squares = 0;
  for (std::size_t i = 0; i < 256; ++i) {
    const double pixel = double{tile->values[i]} / 256;
    mean += pixel / 256;
    mean_of_squares += pixel * pixel / 256;
  }
  const double standard_error = std::sqrt(std::max(0.0, mean_of_squares - mean * mean) / 255);
  // Off-axis point to a disk parallel to its plane [Howell, B-15]: F = (1 - (Z - 2 R^2) / sqrt(Z^2 - 4 R^2))
  // / 2 with H = h / a, R = r / a, Z = 1 + H^2 + R^2, for the disk's radius r at height h and the point's
  // distance a from the axis.
  const double a = 1.8, h = 2 / a, r = 1 / a, z = 1 + h * h + r * r;
  const double form_factor = 0.5 * (1 - (z - 2 * r * r) / std::sqrt(z * z - 4 * r * r));
  // The picture is 0.006 wide: what the light changes over that cancels but for its square, 3e-6, and
  // rounding is 1e-6. Five standard errors of the mean of the pixels, each stratified on its own, are below
  // 0.1 %.
  const double expected = 0.5 * 3 * form_factor;
  EXPECT_NEAR(mean, expected, 5 * standard_error + 1e-5 * expected);
  EXPECT_LT(5 * standard_error, 1e-3 * expected);
}

TEST(Shading, SortingPathsByMaterialDoesNotShow) {
  // Three kinds of materials. A whole tile has enough paths to be sorted; a single pixel with one sample
  // never has.
  const std::string scene = absl::StrCat(R"(
    lights { infinite { radiance { constant: 1 } } }
    materials { name: 'floor' diffuse { reflectance { constant { constant: 0.5 } } } }
    materials { name: 'coat' coated_diffuse { reflectance { constant { constant: 0.7 } }
      eta { constant: 1.5 } } }
    materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
    shapes { sphere { radius: 0.4 } material: 'glass' }
    shapes { sphere { radius: 0.3 } material: 'coat'
             world_from_object { elements: [1,0,0,0.5, 0,1,0,0.3, 0,0,1,0.4, 0,0,0,1] } }
    shapes { disk { radius: 3 } material: 'floor'
             world_from_object { elements: [1,0,0,0, 0,0,-1,-0.5, 0,1,0,0, 0,0,0,1] } }
  )",
                                         kCameraAndFilm);
  test::SceneJob job;
  job.settings.set_spp(1);
  job.settings.set_max_depth(8);
  for (const std::string& isa : render::supported_isas()) {
    const auto file = load_scene_text(scene, job, isa);
    ASSERT_TRUE(file.ok()) << file.status();
    render::RenderStats stats;
    const auto whole = file->scene->render_tile({0, 0, 16, 16, 0, 1}, {}, stats);
    ASSERT_TRUE(whole.ok());
    for (std::uint32_t i = 0; i < 256; ++i) {
      const std::uint32_t x = i % 16, y = i / 16;
      const auto pixel = file->scene->render_tile({x, y, x + 1, y + 1, 0, 1}, {}, stats);
      ASSERT_TRUE(pixel.ok());
      for (std::uint32_t c = 0; c < 3; ++c) {
        EXPECT_EQ(pixel->values[c], whole->values[c * 256 + i])
            << isa << ": pixel (" << x << ", " << y << ")";
      }
    }
  }
}

absl::Status load(const std::string& scene) {
  return load_scene_text(absl::StrCat(scene, kCameraAndFilm), {}, render::supported_isas().front()).status();
}

TEST(LoadScene, RefusesByName) {
  EXPECT_THAT(std::string(load("shapes { sphere { radius: 1 } material: 'gold' name: 'ball' }").message()),
              HasSubstr("shape 0 (ball): material 'gold' does not exist"));
  EXPECT_THAT(std::string(load("shapes { sphere { radius: -1 } }").message()),
              HasSubstr("shape 0: its radius"));
  EXPECT_THAT(std::string(load("shapes { sphere { radius: nan } }").message()),
              HasSubstr("shapes[0].sphere.radius"));
  EXPECT_THAT(
      std::string(load("shapes { sphere { radius: 1 } world_from_object { elements: [1, 2] } }").message()),
      HasSubstr("2 elements instead of 16"));
  EXPECT_THAT(std::string(load("materials { name: 'a' mix { a: 'a' b: 'a' } }").message()),
              HasSubstr("material 'a': it mixes itself"));
  EXPECT_THAT(std::string(load("textures { name: 't' scale { value { texture: 't' } } }").message()),
              HasSubstr("refers to itself"));
  EXPECT_THAT(std::string(load("materials { name: 'a' dielectric { eta { constant: 0 } } }").message()),
              HasSubstr("material 'a': an index of refraction of 0"));
  EXPECT_THAT(std::string(load("lights { point { intensity { rgb { r: inf } } } }").message()),
              HasSubstr("lights[0].point.intensity.rgb.r"));
  EXPECT_THAT(std::string(load("instances { object: 'tree' }").message()),
              HasSubstr("object 'tree' does not exist"));
}

/// `count` textures that are made of the one before twice, and materials likewise; their middle makes a
/// sphere.
std::string doubled_textures(int count) {
  std::string scene = "textures { name: 't0' noise {} } shapes { sphere { radius: 1 } material: 'm' }";
  for (int i = 1; i <= count; ++i) {
    absl::StrAppend(&scene, "textures { name: 't", i, "' scale { value { texture: 't", i - 1,
                    "' } factor { texture: 't", i - 1, "' } } }");
  }
  return absl::StrCat(scene, "materials { name: 'm' diffuse { reflectance { texture: 't", count, "' } } }");
}

std::string nested_mixes(int count) {
  std::string scene = "materials { name: 'm0' diffuse {} }";
  for (int i = 1; i <= count; ++i) {
    absl::StrAppend(&scene, "materials { name: 'm", i, "' mix { a: 'm", i - 1, "' b: 'm0' } }");
  }
  return scene;
}

std::string nested_textures(int count) {
  std::string scene;
  for (int i = count; i > 0; --i) {
    absl::StrAppend(&scene, "textures { name: 't", i, "' scale { value { texture: 't", i - 1, "' } } }");
  }
  return absl::StrCat(scene, "textures { name: 't0' noise {} }");
}

TEST(LoadScene, RefusesAFewLinesThatWouldTakeForever) {
  EXPECT_EQ(load(doubled_textures(10)), absl::OkStatus());
  EXPECT_THAT(std::string(load(doubled_textures(40)).message()),
              HasSubstr("texture 't12': it takes more than 4096"));
  EXPECT_EQ(load(nested_textures(60)), absl::OkStatus());
  EXPECT_THAT(std::string(load(nested_textures(20'000)).message()),
              HasSubstr("more than 64 textures within one"));
  EXPECT_EQ(load(nested_mixes(64)), absl::OkStatus());
  for (const int count : {65, 20'000}) {
    EXPECT_THAT(std::string(load(nested_mixes(count)).message()),
                HasSubstr("more than 64 mixes within one another"));
  }
}

TEST(LoadScene, AChannelOfAnImageIsOneThatThereIs) {
  // The wire lets any number through. It must not become an offset into memory.
  v1::Scene scene;
  v1::ImageTexture& image = *scene.add_textures()->mutable_image();
  image.set_channel(static_cast<v1::ImageTexture::Channel>(1 << 20));
  scene.mutable_camera()->mutable_perspective()->set_fov_degrees(40);
  v1::JobSpec job;
  job.mutable_view()->set_width(8);
  job.mutable_view()->set_height(8);
  job.mutable_samples()->set_spp(1);
  const auto no_blobs = [](const std::string&) { return absl::NotFoundError("none"); };
  const auto loaded =
      render::load_scene(scene, job, no_blobs, {.isa = render::supported_isas().front(), .threads = 1});
  EXPECT_THAT(std::string(loaded.status().message()), HasSubstr("its channel is unknown"));
}

/// Bytes of an array of numbers.
template <class T>
std::string bytes_of(std::initializer_list<T> values) {
  return {reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(T)};
}

TEST(LoadScene, WhatAlgorithmsCannotDoIsRefusedByName) {
  const TestBlobs blobs = {{"points", bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 2, 1, 0, 0, 3, 1})},
                           {"starts", bytes_of<std::uint32_t>({0})}};
  const auto refusal = [&](const std::string& integrator, const std::string& scene,
                           v1::PhotonMap map = v1::PHOTON_MAP_PROGRESSIVE) {
    test::SceneJob job;
    job.settings.set_integrator(integrator);
    job.settings.mutable_photon()->set_map(map);
    const auto file =
        load_scene_text(absl::StrCat(scene, kCameraAndFilm), job, render::supported_isas().front(), blobs);
    return std::string(file.status().message());
  };
  const std::string hair =
      "shapes { curves { points { digest: 'points' } starts { digest: 'starts' } kind: CYLINDER } }";
  const std::string mover =
      "shapes { sphere { radius: 1 } world_from_object_end { elements: [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1] "
      "} }";
  for (const wire::AlgorithmTraits& traits : wire::algorithms()) {
    if (traits.diffuse_only) continue;
    const std::string of_hair = refusal(traits.name, hair), of_mover = refusal(traits.name, mover);
    EXPECT_EQ(of_hair.find("cannot light flat curves") != std::string::npos, traits.starts_at_lights)
        << traits.name << ": " << of_hair;
    EXPECT_EQ(of_mover.find("stands still") == std::string::npos, traits.motion)
        << traits.name << ": " << of_mover;
  }
  EXPECT_THAT(refusal("photon", mover, v1::PHOTON_MAP_CLASSIC), HasSubstr("stands still"));
}

TEST(LoadScene, AnEmptySceneIsBlack) {
  for (const std::string& isa : render::supported_isas()) {
    for (const char* scene : {"", "media { name: 'air' } settings { integrator: 'volpath' }"}) {
      const Mean mean = render_mean(scene, 4, 5, isa);
      for (const double c : mean.rgb) EXPECT_EQ(c, 0);
    }
  }
}

}  // namespace
}  // namespace tessera::test
