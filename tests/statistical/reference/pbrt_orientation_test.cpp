// Which corner of a picture lands where, from a pbrt-v4 file to the film. What must be seen follows from
// pbrt-v4's sources; each test says how.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "image/png.h"
#include "support/picture/render_image.h"
#include "support/process/temp_dir.h"

namespace tessera::test::orientation {  // apart from tests that are compiled with these
namespace {

struct Colour {
  double r = 0, g = 0, b = 0;
};
constexpr Colour kRed{1, 0, 0}, kGreen{0, 1, 0}, kBlue{0, 0, 1}, kWhite{1, 1, 1}, kBlack{0, 0, 0};

class PbrtOrientation : public testing::Test {
 protected:
  /// A picture of 2 x 2 pixels: upper left, upper right, lower left, lower right.
  void write_picture(const std::string& name, const Colour (&pixels)[4]) {
    client::Image image;
    image.data = image.display = {0, 0, 2, 2};
    for (const char* channel : {"R", "G", "B"}) {
      std::vector<float>& values = image.add(channel).values;
      for (std::size_t i = 0; i < 4; ++i) {
        values[i] = static_cast<float>(channel[0] == 'R'   ? pixels[i].r
                                       : channel[0] == 'G' ? pixels[i].g
                                                           : pixels[i].b);
      }
    }
    const absl::Status written = client::write_png(image, (folder_.path() / name).string());
    ASSERT_TRUE(written.ok()) << written;
  }
  void write_corners() { write_picture("corners.png", {kRed, kGreen, kBlue, kWhite}); }

  /// 32 x 32 pixels of `scene`.
  void render(const std::string& scene, std::uint32_t spp = 16) {
    const std::string path = (folder_.path() / "scene.pbrt").string();
    std::ofstream(path)
        << R"(Film "rgb" "integer xresolution" 32 "integer yresolution" 32 PixelFilter "box" )" << scene;
    test::SceneJob job;
    job.settings.set_spp(spp);
    const auto file = load_scene_file(path, job, render::supported_isas().front(), 2);
    ASSERT_TRUE(file.ok()) << file.status();
    for (const std::string& warning : file->scene->warnings()) ADD_FAILURE() << warning;
    image_ = render_image(*file);
    ASSERT_FALSE(image_.channels.empty());
  }

  Colour pixel(std::size_t x, std::size_t y) const {
    const auto at = [&](const char* channel) { return double{image_.find(channel)->values[y * 32 + x]}; };
    return {at("R"), at("G"), at("B")};
  }
  /// The colour of a pixel, whatever its brightness; black is exact. Shades of the primaries are told apart
  /// at a tenth.
  void expect_hue(std::size_t x, std::size_t y, Colour expected) const {
    Colour seen = pixel(x, y);
    const double brightness = std::max({seen.r, seen.g, seen.b}),
                 most = std::max({expected.r, expected.g, expected.b});
    if (most > 0) {
      EXPECT_GT(brightness, 0) << x << ' ' << y;
    }
    const double scale = most > 0 && brightness > 0 ? 1 / brightness : 1;
    EXPECT_NEAR(seen.r * scale, expected.r, 0.1) << x << ' ' << y;
    EXPECT_NEAR(seen.g * scale, expected.g, 0.1) << x << ' ' << y;
    EXPECT_NEAR(seen.b * scale, expected.b, 0.1) << x << ' ' << y;
  }

 private:
  support::TempDir folder_;
  client::Image image_;
};

// At the origin, +x to the right, +y up, 45 degrees to the film's edges.
constexpr const char* kForward =
    R"(LookAt 0 0 0  0 0 1  0 1 0  Camera "perspective" "float fov" 90 WorldBegin )";
constexpr const char* kWall =
    R"(Shape "trianglemesh" "point3 P" [-9 -9 4  9 -9 4  9 9 4  -9 9 4] "integer indices" [0 1 2 0 2 3]
  "point2 uv" [0 0  1 0  1 1  0 1] )";

TEST_F(PbrtOrientation, ProjectionLight) {
  // pbrt flips y of light space, where rows of the image grow with y: from behind the light, the slide is
  // upright.
  write_corners();
  render(absl::StrCat(kForward, R"(LightSource "projection" "string filename" "corners.png" "float fov" 60 )",
                      kWall));
  // The slide reaches to tan 30 = 0.577 of the film's half, its quarters' middles to half of that: 4.6
  // pixels.
  expect_hue(11, 11, kRed);
  expect_hue(20, 11, kGreen);
  expect_hue(11, 20, kBlue);
  expect_hue(20, 20, kWhite);
  expect_hue(4, 16, kBlack);
  expect_hue(16, 27, kBlack);
}

TEST_F(PbrtOrientation, GoniometricLight) {
  // pbrt exchanges y and z of light space; its equal-area map has x along rows and y down the columns. So
  // columns tell the signs of x and rows those of z.
  write_picture("map.png", {{0.2, 0.2, 0.2}, {0.4, 0.4, 0.4}, {0.7, 0.7, 0.7}, {1, 1, 1}});
  // From above; +x to the right, +z up.
  render(R"(LookAt 0 3 0  0 2 0  0 0 1  Camera "perspective" "float fov" 60 WorldBegin
    LightSource "goniometric" "string filename" "map.png"
    Shape "trianglemesh" "point3 P" [-9 -2 -9  9 -2 -9  9 -2 9  -9 -2 9] "integer indices" [0 1 2 0 2 3] )");
  const double brightest = pixel(22, 9).g;
  EXPECT_GT(brightest, 0);
  // An 8-bit code near 0.2 is half a per cent of it.
  EXPECT_NEAR(pixel(9, 22).g / brightest, 0.2, 0.004);
  EXPECT_NEAR(pixel(22, 22).g / brightest, 0.4, 0.004);
  EXPECT_NEAR(pixel(9, 9).g / brightest, 0.7, 0.006);
}

TEST_F(PbrtOrientation, ImageOnAnAreaLight) {
  // pbrt looks the image up at (u, 1 - v), bilinearly.
  write_corners();
  render(absl::StrCat(
      kForward,
      R"(AreaLightSource "diffuse" "string filename" "corners.png" "bool twosided" true Scale 0.4 0.4 1 )",
      kWall));
  // The lamp is 3.6 of 4 wide to every side; its texels' middles are half way out.
  expect_hue(8, 8, kRed);
  expect_hue(23, 8, kGreen);
  expect_hue(8, 23, kBlue);
  expect_hue(23, 23, kWhite);
  const Colour middle = pixel(15, 8);  // half of red and half of green
  EXPECT_NEAR(middle.r, middle.g, 0.25 * middle.r);
}

/// The environment of these tests: the colour says the signs of x (columns) and y (rows) of a direction.
constexpr const char* kCornerSky = R"(LightSource "infinite" "string filename" "corners.png" )";

TEST_F(PbrtOrientation, InfiniteLight) {
  write_corners();
  render(absl::StrCat(kForward, kCornerSky));
  expect_hue(4, 4, kBlue);  // x < 0: the first column; y > 0: the second row
  expect_hue(27, 4, kWhite);
  expect_hue(4, 27, kRed);
  expect_hue(27, 27, kGreen);
}

TEST_F(PbrtOrientation, SphericalCameraOfEqualArea) {
  write_corners();
  render(absl::StrCat(R"(Camera "spherical" "string mapping" "equalarea" WorldBegin )", kCornerSky));
  // y and z of the map are exchanged: the middle is up.
  expect_hue(12, 16, kBlue);
  expect_hue(19, 16, kWhite);
  expect_hue(2, 2, kRed);
  expect_hue(29, 2, kGreen);
  expect_hue(2, 29, kRed);
  expect_hue(29, 29, kGreen);
}

TEST_F(PbrtOrientation, SphericalCameraOfEvenAngles) {
  write_corners();
  render(absl::StrCat(R"(Camera "spherical" "string mapping" "equirectangular" WorldBegin )", kCornerSky));
  // The azimuth grows to the right, from +x at the left edge over +z; up is up.
  expect_hue(2, 8, kWhite);
  expect_hue(16, 8, kBlue);
  expect_hue(2, 24, kGreen);
  expect_hue(16, 24, kRed);
}

TEST_F(PbrtOrientation, PortalOfAnInfiniteLight) {
  // Directions through the portal have a positive part along cross(p3 - p0, p1 - p0).
  write_corners();
  const auto sky = [](const char* portal) {
    return absl::StrCat(kForward,
                        R"(LightSource "infinite" "string filename" "corners.png" "point3 portal" [)", portal,
                        "] ");
  };
  render(sky("-1 -1 2  -1 1 2  1 1 2  1 -1 2"));
  expect_hue(12, 12, kBlue);
  expect_hue(19, 12, kWhite);
  expect_hue(12, 19, kRed);
  expect_hue(19, 19, kGreen);
  expect_hue(6, 16, kBlack);
  expect_hue(16, 25, kBlack);
  render(sky("-1 -1 2  1 -1 2  1 1 2  -1 1 2"));
  expect_hue(12, 12, kBlack);
}

TEST_F(PbrtOrientation, GridsOfMedia) {
  // Samples run along x, then y; a grid from p0 to p1. Seen along +z before a sky of 1, samples' middles lie
  // half way out.
  const std::string before =
      R"(Integrator "volpath" LookAt 0 0 -9  0 0 0  0 1 0  Camera "orthographic" "float screenwindow"
        [-1 1 -1 1]
    WorldBegin LightSource "infinite" "rgb L" [1 1 1] )";
  const std::string after = R"( MediumInterface "m" "" Material "interface" Shape "sphere" "float radius" 4)";
  // Pixels are half of one off the middles, so depths a thirtieth of the way to the next ones. Five standard
  // errors of 1024 samples that come through or not are 0.08.
  const auto expect_through = [&](std::size_t x, std::size_t y, Colour depth) {
    const Colour seen = pixel(x, y);
    EXPECT_NEAR(seen.r, std::exp(-depth.r), 0.1) << x << ' ' << y;
    EXPECT_NEAR(seen.g, std::exp(-depth.g), 0.1) << x << ' ' << y;
    EXPECT_NEAR(seen.b, std::exp(-depth.b), 0.1) << x << ' ' << y;
  };
  render(absl::StrCat(
             before,
             R"(MakeNamedMedium "m" "string type" "uniformgrid" "integer nx" 2 "integer ny" 2 "integer nz" 1
    "float density" [0 0.4 1.2 3] "point3 p0" [-1 -1 -1] "point3 p1" [1 1 1] "rgb sigma_a" [0.5 0.5 0.5]
      "rgb sigma_s" [0 0 0] )",
             after),
         1024);
  const auto grey = [](double depth) { return Colour{depth, depth, depth}; };
  expect_through(8, 23, grey(0));
  expect_through(23, 23, grey(0.4));
  expect_through(8, 8, grey(1.2));
  expect_through(23, 8, grey(3));

  render(
      absl::StrCat(before,
                   R"(MakeNamedMedium "m" "string type" "rgbgrid" "integer nx" 2 "integer ny" 1 "integer nz" 1
    "rgb sigma_a" [0 0.8 0  0.3 0 0] "rgb sigma_s" [0 0 0  0 0 0] "point3 p0" [-1 -1 -1] "point3 p1" [1 1 1]
      )",
                   after),
      1024);
  expect_through(8, 16, {0, 1.6, 0});
  expect_through(23, 16, {0.6, 0, 0});
}

}  // namespace
}  // namespace tessera::test::orientation
