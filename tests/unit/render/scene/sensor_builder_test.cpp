// Render space, the camera and the film alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "render/scene/view/aperture.h"
#include "render/scene/view/lens.h"
#include "render/scene/view/sensor.h"
#include "render/scene/view/view.h"
#include "render/sensor/hole_table.h"
#include "render/sensor/lens_table.h"
#include "unit/render/scene/builder_inputs.h"

namespace tessera::render {
namespace {

using testing::HasSubstr;

constexpr FilmSize kFilm{200, 100};

absl::StatusOr<SensorRecord> sensor_of(const std::string& camera,
                                       const wire::AlgorithmTraits& algorithm = kSurfacesAlone,
                                       FilmSize film = kFilm) {
  return build_sensor(message<v1::Camera>(camera), film, render_space_about({10, 20, 30}), algorithm);
}

std::string refusal(const std::string& camera, const wire::AlgorithmTraits& algorithm = kSurfacesAlone,
                    FilmSize film = kFilm) {
  return std::string(sensor_of(camera, algorithm, film).status().message());
}

TEST(RenderOrigin, IsTheScenesElseTheCamerasPlace) {
  const std::string camera =
      "camera { world_from_camera { elements: [1,0,0,4, 0,1,0,5, 0,0,1,6, 0,0,0,1] } }";
  const auto of_camera = render_origin(message<v1::Scene>(camera));
  const auto own = render_origin(message<v1::Scene>(camera + "render_origin { x: 7 }"));
  ASSERT_TRUE(of_camera.ok() && own.ok());
  EXPECT_EQ(of_camera->z, 6);
  EXPECT_EQ(own->x, 7);
  EXPECT_THAT(std::string(render_origin(message<v1::Scene>("render_origin { y: inf }")).status().message()),
              HasSubstr("render_origin is not finite"));
  EXPECT_THAT(std::string(render_origin(message<v1::Scene>("camera { world_from_camera { elements: 1 } }"))
                              .status()
                              .message()),
              HasSubstr("camera: a matrix has 1 elements instead of 16"));
}

TEST(BuildSensor, StandsRelativeToRenderSpaceAndSpansItsFieldOfView) {
  const auto camera = sensor_of(R"(perspective { fov_degrees: 90 lens_radius: 0.5 focal_distance: 3 }
                                   world_from_camera { elements: [1,0,0,11, 0,1,0,22, 0,0,1,33, 0,0,0,1] })");
  ASSERT_TRUE(camera.ok()) << camera.status();
  EXPECT_EQ(camera->render_from_sensor.m[3], 1);
  EXPECT_EQ(camera->render_from_sensor.m[7], 2);
  EXPECT_EQ(camera->render_from_sensor.m[11], 3);
  // tan(45 degrees) across the shorter side, twice that across the longer; a rounding of a float each.
  EXPECT_FLOAT_EQ(camera->scale_x, 4.0f / 200);
  EXPECT_FLOAT_EQ(camera->scale_y, -2.0f / 100);
  EXPECT_FLOAT_EQ(camera->offset_x, -2);
  EXPECT_FLOAT_EQ(camera->offset_y, 1);
  EXPECT_EQ(camera->kind, SensorKind::kThinLens);
  EXPECT_EQ(camera->lens_radius, 0.5f);
  EXPECT_TRUE(camera->steps.empty());
}

TEST(BuildSensor, LensesHaveTheirAperture) {
  for (const std::string camera : {"perspective { fov_degrees: 90 ", "orthographic { ", "panorama { "}) {
    const std::string lens = camera + "lens_radius: 0.5 focal_distance: 3 ";
    const auto round = sensor_of(lens + "aperture { } }");
    const auto bladed = sensor_of(lens + "aperture { blades: 6 blade_degrees: 70 ratio: 2 } }");
    const auto pinhole = sensor_of(camera + "aperture { blades: 6 } }");
    ASSERT_TRUE(round.ok() && bladed.ok() && pinhole.ok()) << bladed.status();
    EXPECT_EQ(round->lens, nullptr);
    EXPECT_EQ(pinhole->lens, nullptr);
    EXPECT_EQ(bladed->kind, round->kind);
    ASSERT_NE(bladed->lens, nullptr);
    const ApertureRecord& aperture = bladed->lens->aperture;
    EXPECT_EQ(aperture.corners, 6);
    EXPECT_FLOAT_EQ(aperture.first_corner, std::numbers::pi_v<float> / 18);  // 60 degrees less
    EXPECT_FLOAT_EQ(aperture.apothem, 0.8660254f);
    EXPECT_FLOAT_EQ(aperture.half_edge, 0.5f);
    EXPECT_EQ(aperture.width, 0.5f);
    for (const char* blades : {"0", "1", "2", "65", "4294967295"}) {
      EXPECT_THAT(refusal(lens + "aperture { blades: " + blades + " } }"),
                  HasSubstr(absl::StrCat("camera: an aperture has 3 to 64 blades, not ", blades)));
    }
    for (const char* ratio : {"0", "-1", "nan", "inf", "1e-9"})
      EXPECT_THAT(refusal(lens + "aperture { ratio: " + ratio + " } }"),
                  HasSubstr("ratio is from 0.001 to 1000"));
    // All at once.
    EXPECT_EQ(
        refusal(camera + "lens_radius: -1 aperture { blades: 2 blade_degrees: inf ratio: 0 } }"),
        "camera: a lens needs a finite radius and a focal distance above 0; an aperture has 3 to 64 "
        "blades, not 2; an aperture's blades are not turned by inf degrees; an aperture's ratio is from "
        "0.001 to 1000, not 0");
  }
}

TEST(BuildSensor, FisheyesSpanTheirFieldByTheirMapping) {
  const auto half_side_of = [](const std::string& mapping, double fov) {
    const auto camera = sensor_of(absl::StrCat("fisheye { mapping: ", mapping, " fov_degrees: ", fov, " }"));
    EXPECT_TRUE(camera.ok()) << camera.status();
    return camera.ok() ? double{camera->offset_y} : 0.0;
  };
  EXPECT_NEAR(half_side_of("EQUIDISTANT", 360), std::numbers::pi, 1e-6);
  EXPECT_NEAR(half_side_of("EQUISOLID", 180), std::numbers::sqrt2, 1e-6);
  EXPECT_NEAR(half_side_of("STEREOGRAPHIC", 180), 2, 1e-6);
  EXPECT_NEAR(half_side_of("ORTHOGRAPHIC", 60), 0.5, 1e-6);
  const auto with_circle = sensor_of("fisheye { fov_degrees: 180 circle_degrees: 90 }");
  ASSERT_TRUE(with_circle.ok());
  EXPECT_FLOAT_EQ(with_circle->circle_angle, std::numbers::pi_v<float> / 4);
  // No field at all, more than the mapping can show, and a circle that is none.
  EXPECT_THAT(refusal("fisheye {}"), HasSubstr("EQUIDISTANT cannot see a field of 0 degrees"));
  EXPECT_THAT(refusal("fisheye { fov_degrees: nan }"), HasSubstr("cannot see a field of nan degrees"));
  EXPECT_THAT(refusal("fisheye { mapping: ORTHOGRAPHIC fov_degrees: 181 }"),
              HasSubstr("ORTHOGRAPHIC cannot see a field of 181 degrees"));
  EXPECT_THAT(refusal("fisheye { mapping: STEREOGRAPHIC fov_degrees: 360 }"),
              HasSubstr("STEREOGRAPHIC cannot see a field of 360 degrees"));
  EXPECT_THAT(refusal("fisheye { fov_degrees: 90 circle_degrees: -1 }"), HasSubstr("a circle of -1 degrees"));
}

TEST(BuildSensor, PinholesAndLensesHaveAFilmOfTheirGauge) {
  // 2 : 1 on 96 x 120 mm, turned: 120 x 60 mm, seen from 60 mm.
  const auto hole = sensor_of("pinhole { hole_mm: 0.3 film_distance_mm: 60 film_gauge: '4x5' }");
  ASSERT_TRUE(hole.ok()) << hole.status();
  EXPECT_EQ(hole->kind, SensorKind::kHole);
  EXPECT_FLOAT_EQ(hole->offset_y, 30.0f / 60);
  EXPECT_FLOAT_EQ(hole->scale_x, 120.0f / 60 / 200);
  EXPECT_FALSE(hole->disperses);
  EXPECT_FLOAT_EQ(hole->hole->radius, 0.15e-3f);
  EXPECT_EQ(hole->hole->light.size(), static_cast<std::size_t>(kHoleNodes));
  const auto straight = sensor_of("pinhole { hole_mm: 0.3 film_distance_mm: 60 diffraction: STRAIGHT }");
  ASSERT_TRUE(straight.ok());
  EXPECT_TRUE(straight->hole->light.empty());
  const auto spectral = build_sensor(message<v1::Camera>("pinhole { hole_mm: 0.3 film_distance_mm: 60 }"),
                                     kFilm, render_space_about({0, 0, 0}), kSurfacesAlone, true);
  ASSERT_TRUE(spectral.ok());
  EXPECT_TRUE(spectral->disperses);
  const auto by_focal_length = sensor_of("perspective { focal_length_mm: 50 film_gauge: 'full-frame' }");
  ASSERT_TRUE(by_focal_length.ok());
  EXPECT_FLOAT_EQ(by_focal_length->offset_y, 9.0f / 50);
}

TEST(BuildSensor, TellsAllThatIsWrongWithAHole) {
  EXPECT_EQ(
      refusal(
          "pinhole { hole_mm: -1 film_distance_mm: 0 scene_distance: -2 wavelength_nm: 20 units_per_mm: nan "
          "film_gauge: '4x55' }")
          .substr(0, 8),
      "camera: ");
  for (const char* const fault :
       {"a hole of -1 mm is not possible", "a distance of the film of 0 mm is not possible",
        "at a distance of -2", "a wavelength of 20 nm is not in 300 to 1000 nm", "is not nan units",
        "did you mean '4x5'?"}) {
    EXPECT_THAT(refusal("pinhole { hole_mm: -1 film_distance_mm: 0 scene_distance: -2 wavelength_nm: 20 "
                        "units_per_mm: nan film_gauge: '4x55' }"),
                HasSubstr(fault));
  }
  EXPECT_THAT(refusal("pinhole { hole_mm: 60 film_distance_mm: 50 }"),
              HasSubstr("a hole of 60 mm is larger than its distance from the film, 50 mm"));
}

/// A singlet behind a stop in a long tube: no light reaches places that the tube hides.
TEST(DarkFilm, IsToldWithFigures) {
  const std::string lens =
      "lens { lens { surfaces { stop: true diameter_mm: 10 thickness_mm: 1 }"
      "surfaces { radius_mm: 100 thickness_mm: 2 diameter_mm: 24 index: 1.5 }"
      "surfaces { radius_mm: -100 thickness_mm: 60 diameter_mm: 24 }"
      "surfaces { thickness_mm: 40 diameter_mm: 24 } } film_diagonal_mm: ";
  const auto warning = [&](const std::string& diagonal) {
    const auto camera = message<v1::Camera>(lens + diagonal + " }");
    const auto sensor = build_sensor(camera, {300, 200}, render_space_about({0, 0, 0}), kSurfacesAlone);
    EXPECT_TRUE(sensor.ok()) << sensor.status();
    return sensor.ok() ? dark_film_warning(camera, *sensor) : "";
  };
  EXPECT_EQ(warning("20"), "");
  const std::string wide = warning("100");
  EXPECT_THAT(wide, HasSubstr("its corners are 50 mm from there"));
  // The last ray goes from the stop's edge to the tube's opposite one, and on, but for what the lens bends.
  double edge = 0;
  const std::size_t at = wide.find("beyond ");
  ASSERT_NE(at, std::string::npos) << wide;
  edge = std::stod(wide.substr(at + 7));
  EXPECT_GT(edge, 20);
  EXPECT_LT(edge, 34);
}

TEST(BuildSensor, CylindersSpanTheirFieldAcrossTheFilm) {
  const auto camera = sensor_of("cylindrical { fov_degrees: 360 }");
  ASSERT_TRUE(camera.ok()) << camera.status();
  EXPECT_FLOAT_EQ(camera->scale_x, 2 * std::numbers::pi_v<float> / 200);
  EXPECT_FLOAT_EQ(camera->scale_y, -camera->scale_x);
  EXPECT_FLOAT_EQ(camera->offset_y, std::numbers::pi_v<float> / 2);
  EXPECT_EQ(edges_of(*camera), RasterEdges::kRound);
  const auto half = sensor_of("cylindrical { fov_degrees: 180 }");
  ASSERT_TRUE(half.ok());
  EXPECT_EQ(edges_of(*half), RasterEdges::kOpen);
  EXPECT_THAT(refusal("cylindrical { fov_degrees: 361 }"), HasSubstr("361 degrees is not in (0, 360]"));
  EXPECT_THAT(refusal("cylindrical { fov_degrees: 90 } screen_window: [-1, 1, -1, 1]"),
              HasSubstr("those that see all around have no screen window"));
}

TEST(BuildSensor, HasStepsWhereItMoves) {
  const std::string still =
      "orthographic {} world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] }";
  const auto moving =
      sensor_of(still + "world_from_camera_end { elements: [1,0,0,5, 0,1,0,0, 0,0,1,0, 0,0,0,1] }");
  ASSERT_TRUE(moving.ok()) << moving.status();
  ASSERT_EQ(moving->steps.size(), 2u);  // a straight line
  EXPECT_EQ(moving->steps[0].m[3], -10);
  EXPECT_EQ(moving->steps[1].m[3], -5);
  const auto held =
      sensor_of(still + "world_from_camera_end { elements: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] }");
  ASSERT_TRUE(held.ok());
  EXPECT_TRUE(held->steps.empty());
}

TEST(BuildSensor, NamesWhatIsAtFault) {
  EXPECT_THAT(refusal(""), HasSubstr("camera: there is none"));
  EXPECT_THAT(refusal("perspective { fov_degrees: 180 }"), HasSubstr("180 degrees is not in (0, 180)"));
  EXPECT_THAT(refusal("perspective { fov_degrees: 40 lens_radius: 1 }"), HasSubstr("camera: a lens needs"));
  EXPECT_THAT(refusal("orthographic {} near_clip: 2 far_clip: 1"), HasSubstr("clipping distances"));
  EXPECT_THAT(refusal("orthographic {} screen_window: [0, 1, 2]"),
              HasSubstr("a screen window has four numbers"));
  EXPECT_THAT(refusal("orthographic {} world_from_camera { elements: [0,0,0,0, 0,0,0,0, 0,0,0,0, 0,0,0,1] }"),
              HasSubstr("camera: its transform is singular"));
  EXPECT_THAT(
      refusal("orthographic {} world_from_camera_end { elements: [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] }"),
      HasSubstr("camera: its motion turns it inside out"));
}

TEST(BuildSensor, HoldsTheAlgorithmToIt) {
  EXPECT_EQ(sensor_of("spherical {}").status(), absl::OkStatus());
  constexpr FilmSize kHuge{1 << 16, 1 << 15};
  EXPECT_EQ(sensor_of("orthographic {}", kSurfacesAlone, kHuge).status(), absl::OkStatus());
  EXPECT_THAT(refusal("orthographic {}", kFromLights, kHuge), HasSubstr("all pixels of the film at once"));
}

TEST(BuildFilter, HasTheUsualRadiusUnlessItIsGiven) {
  const auto usual = build_filter(message<v1::PixelFilter>("kind: MITCHELL"));
  const auto own = build_filter(message<v1::PixelFilter>("kind: MITCHELL radius_x: 3"));
  ASSERT_TRUE(usual.ok() && own.ok());
  EXPECT_EQ(usual->x.radius, 2);
  EXPECT_EQ(own->x.radius, 3);
  EXPECT_EQ(own->y.radius, 2);
  EXPECT_THAT(std::string(build_filter(message<v1::PixelFilter>("radius_x: 2000")).status().message()),
              HasSubstr("film: the pixel filter's parameters"));
}

TEST(SetView, LeavesTheCamerasMediumToTheContent) {
  SceneArrays arrays;
  SceneTables tables(arrays);
  tables.sensor.medium = 3;
  const auto job = message<v1::JobSpec>("view { width: 8 height: 4 seed: 5 max_depth: 2 }");
  const auto scene = message<v1::Scene>("camera { orthographic {} } film { exposure: 2 }");
  ASSERT_EQ(set_view(scene, job, read_settings(job), render_space_about({0, 0, 0}), {}, tables),
            absl::OkStatus());
  EXPECT_EQ(tables.sensor.medium, 3);
  EXPECT_EQ(tables.sensor.width, 8);
  EXPECT_EQ(tables.sensor.response.exposure, 2);
  EXPECT_EQ(tables.sampler.seed, 5u);
  EXPECT_EQ(tables.max_depth, 2);
  const auto photographed = message<v1::Scene>(
      "camera { orthographic {} } film { photographic_exposure { f_number: 8 shutter_seconds: 0.01 iso: 200 "
      "} }");
  ASSERT_EQ(set_view(photographed, job, read_settings(job), render_space_about({0, 0, 0}), {}, tables),
            absl::OkStatus());
  EXPECT_FLOAT_EQ(tables.sensor.response.exposure,
                  static_cast<float>(0.018 * 200 * 0.01 * std::numbers::pi / 4 / 64));
  const auto dark = message<v1::Scene>("camera { orthographic {} } film { exposure: nan }");
  EXPECT_THAT(
      std::string(
          set_view(dark, job, read_settings(job), render_space_about({0, 0, 0}), {}, tables).message()),
      HasSubstr("film: the exposure is not finite"));
}

TEST(BuildSensor, PlacesOfFocusAreInThePictureAndOfCamerasWithALens) {
  EXPECT_THAT(refusal("perspective { fov_degrees: 40 lens_radius: 1 } focus_point { x: 0.5 y: 1.5 }"),
              HasSubstr("focus_point 0.5, 1.5 is not in the picture"));
  EXPECT_THAT(refusal("spherical {} focus_point { x: 0.5 y: 0.5 }"),
              HasSubstr("has no lens that a focus_point"));
  // The distance comes later.
  EXPECT_TRUE(sensor_of("perspective { fov_degrees: 40 lens_radius: 1 } focus_point { x: 0.5 y: 0.5 }").ok());
}

TEST(BuildSensor, ApertureAndBarrelAreChecked) {
  const auto refused = [](const std::string& aperture) {
    return refusal(absl::StrCat("perspective { fov_degrees: 40 lens_radius: 1 focal_distance: 2 aperture { ",
                                aperture, " } }"));
  };
  EXPECT_THAT(refused("blades: 5 image { digest: 'a' }"),
              HasSubstr("blades and its image exclude each other"));
  EXPECT_THAT(refused("barrel_length: -1"), HasSubstr("a barrel is 0 to 1e6 radii of the lens long, not -1"));
  EXPECT_THAT(refused("barrel_length: 1 barrel_radius: 0"),
              HasSubstr("0.001 to 1e6 radii of the lens, not 0"));
  EXPECT_THAT(refusal("orthographic { lens_radius: 1 focal_distance: 2 aperture { barrel_length: 1 } }"),
              HasSubstr("orthographic cameras have no barrel"));
  EXPECT_THAT(refusal("panorama { lens_radius: 1 focal_distance: 2 aperture { barrel_length: 1 } }"),
              HasSubstr("panoramas have no barrel"));
}

TEST(BuildSensor, LensesOfPanoramasHaveTheirEyeInTheMiddle) {
  EXPECT_THAT(refusal("panorama { lens_radius: 0.1 focal_distance: 2 } viewpoint { x: 0.03 y: 0.1 }"),
              HasSubstr("a panorama with a lens has its eye in the middle, not at a viewpoint x of 0.03"));
  EXPECT_THAT(refusal("panorama { lens_radius: 0.1 }"), HasSubstr("focal distance above 0"));
  const auto risen = sensor_of("panorama { lens_radius: 0.1 focal_distance: 2 } viewpoint { y: 0.1 }");
  ASSERT_TRUE(risen.ok()) << risen.status();
  EXPECT_EQ(risen->kind, SensorKind::kPanoramaLens);
}

TEST(AperturePicture, LetsThroughWhatIsBright) {
  BlobsInMemory blobs;
  const std::vector<float> rows = {1, 0, 0.5f, 0};  // the lower row first, as PFM has it
  blobs.add("picture", "Pf\n2 2\n-1.0\n" + bytes_of(rows));
  blobs.add("black", "Pf\n1 1\n-1.0\n" + bytes_of(std::vector<float>{0}));
  blobs.add("text", "none");
  const auto picture =
      aperture_picture(message<v1::BlobRef>("digest: 'picture' path: 'a.pfm'"), blobs.source);
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_FLOAT_EQ(picture->transmission, 0.375f);
  // Rows from y = -1 on.
  const float* const density = picture->density.density.data();
  EXPECT_FLOAT_EQ(density[0] * picture->transmission, 1);
  EXPECT_FLOAT_EQ(density[1], 0);
  EXPECT_FLOAT_EQ(density[2] * picture->transmission, 0.5f);
  const auto fault = [&](const char* blob) {
    return std::string(aperture_picture(message<v1::BlobRef>(blob), blobs.source).status().message());
  };
  EXPECT_THAT(fault("digest: 'black' path: 'b.pfm'"), HasSubstr("aperture 'b.pfm' is black"));
  EXPECT_THAT(fault("digest: 'text' path: 'c.png'"), HasSubstr("c.png"));
  EXPECT_THAT(fault("digest: 'none' path: 'd.png'"), HasSubstr("aperture 'd.png'"));
}

}  // namespace
}  // namespace tessera::render
