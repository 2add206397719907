// Scenes at a frame, and what image files tell of camera and frame.
#include "import/tessera_scene/animation.h"

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "command/jobs/job_settings.h"
#include "command/report/camera_facts.h"
#include "command/report/file_facts.h"

namespace tessera::client::animations {
namespace {

using testing::HasSubstr;

v1::Scene scene_of(const std::string& text) {
  v1::Scene scene;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &scene)) << text;
  return scene;
}

constexpr const char* kTurn =
    "objects { name: 'o' } instances { object: 'o' } animation { shutter: 0.5 tracks { instance: 0 "
    "keys { frame: 0 world_from_target { elements: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] } } "
    "keys { frame: 10 world_from_target { elements: [0,-2,0,4, 2,0,0,0, 0,0,2,-8, 0,0,0,1] } } } }";

TEST(Animation, TurnsStretchesAndTranslationsAreInterpolatedApart) {
  v1::Scene scene = scene_of(kTurn);
  ASSERT_TRUE(pose_at_frame(5, scene).ok());
  EXPECT_FALSE(scene.has_animation());
  // Half of a quarter turn, 1.5 times as large, halfway.
  const double s = 1.5 * std::sqrt(0.5);
  const double wanted[16] = {s, -s, 0, 2, s, s, 0, 0, 0, 0, 1.5, -4, 0, 0, 0, 1};
  for (int i = 0; i < 16; ++i)
    EXPECT_NEAR(scene.instances(0).world_from_instance().elements(i), wanted[i], 1e-12) << i;
  // The shutter closes half a frame later.
  const double angle = std::numbers::pi / 2 * 0.55, size = 1.55;
  EXPECT_NEAR(scene.instances(0).world_from_instance_end().elements(0), size * std::cos(angle), 1e-12);
}

TEST(Animation, BeforeTheFirstKeyAndAfterTheLastThingsStand) {
  for (const auto& [frame, x] : {std::pair{-3.0, 0.0}, {0.0, 0.0}, {10.0, 4.0}, {99.0, 4.0}}) {
    v1::Scene scene = scene_of(kTurn);
    ASSERT_TRUE(pose_at_frame(frame, scene).ok());
    EXPECT_EQ(scene.instances(0).world_from_instance().elements(3), x);
    EXPECT_EQ(scene.instances(0).world_from_instance_end().elements_size() > 0, frame == 0);
  }
}

TEST(Animation, KeysWhileTheShutterIsOpenAreKept) {
  const auto at_frame = [](double frame, const std::string& position) {
    v1::Scene scene = scene_of(
        "objects { name: 'o' } instances { object: 'o' } animation { shutter: 0.5 " + position +
        " tracks { instance: 0 keys { frame: 1 } keys { frame: 1.125 world_from_target { elements: [1,0,0,2, "
        "0,1,0,0, 0,0,1,0, 0,0,0,1] } } keys { frame: 2 } } }");
    EXPECT_TRUE(pose_at_frame(frame, scene).ok());
    return scene.instances(0);
  };
  const v1::Instance start = at_frame(1, "");
  EXPECT_FALSE(start.has_world_from_instance_end());
  ASSERT_EQ(start.motion_size(), 2);
  EXPECT_DOUBLE_EQ(start.motion(0).time(), 0.25);
  EXPECT_EQ(start.motion(0).place().elements(3), 2);
  EXPECT_EQ(start.motion(1).time(), 1);
  EXPECT_NEAR(start.motion(1).place().elements(3), 2 * 0.5 / 0.875, 1e-12);
  // Open from .875 to 1.375: it stands until 1.
  const v1::Instance center = at_frame(1.125, "shutter_position: CENTER");
  EXPECT_EQ(center.world_from_instance().elements(3), 0);
  ASSERT_EQ(center.motion_size(), 3);
  EXPECT_DOUBLE_EQ(center.motion(0).time(), 0.25);
  EXPECT_EQ(center.motion(0).place().elements(3), 0);
  EXPECT_DOUBLE_EQ(center.motion(1).time(), 0.5);
  // Open until the frame.
  const v1::Instance end = at_frame(1, "shutter_position: END");
  EXPECT_EQ(end.motion_size(), 0);
  EXPECT_FALSE(end.has_world_from_instance_end());
}

TEST(Animation, MirroredThingsTurnLikeOthers) {
  v1::Scene scene = scene_of(
      "objects { name: 'o' } instances { object: 'o' } animation { tracks { instance: 0 "
      "keys { frame: 0 world_from_target { elements: [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] } } "
      "keys { frame: 2 world_from_target { elements: [0,-1,0,0, -1,0,0,0, 0,0,1,0, 0,0,0,1] } } } }");
  ASSERT_TRUE(pose_at_frame(1, scene).ok());
  const auto& m = scene.instances(0).world_from_instance().elements();
  const double determinant = m[0] * m[5] - m[1] * m[4];
  EXPECT_NEAR(determinant, -1, 1e-12);
  EXPECT_NEAR(m[0], -std::sqrt(0.5), 1e-12);
}

TEST(Animation, ACameraThatGoesAloneKeepsTheOriginOfItsFirstKey) {
  v1::Scene scene = scene_of(
      "animation { tracks { camera: true keys { frame: 1 world_from_target { elements: [1,0,0,7, 0,1,0,8, "
      "0,0,1,9, 0,0,0,1] } } keys { frame: 3 } } }");
  ASSERT_TRUE(pose_at_frame(2, scene).ok());
  EXPECT_EQ(scene.camera().world_from_camera().elements(3), 3.5);
  EXPECT_EQ(scene.render_origin().y(), 8);
}

TEST(Animation, WhatIsWrongIsNamed) {
  const auto fault = [](const std::string& animation) {
    v1::Scene scene = scene_of("animation { " + animation + " }");
    const absl::Status status = pose_at_frame(1, scene);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << animation;
    return std::string(status.message());
  };
  EXPECT_THAT(fault("tracks {}"), HasSubstr("track 0: it moves neither"));
  EXPECT_THAT(fault("tracks { instance: 0 keys {} }"), HasSubstr("no instance 0"));
  EXPECT_THAT(fault("tracks { camera: true }"), HasSubstr("no keys"));
  EXPECT_THAT(fault("tracks { camera: true keys { frame: 1 } keys { frame: 1 } }"), HasSubstr("ascend"));
  EXPECT_THAT(fault("tracks { camera: true keys { frame: nan } }"), HasSubstr("ascend"));
  EXPECT_THAT(fault("tracks { camera: true keys { world_from_target { elements: "
                    "[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1] } } }"),
              HasSubstr("singular"));
  EXPECT_THAT(fault("tracks { camera: true keys { world_from_target { elements: 1 } } }"),
              HasSubstr("no matrix"));
  EXPECT_THAT(fault("shutter: 1.5"), HasSubstr("shutter"));
  EXPECT_THAT(fault("frames_per_second: -1"), HasSubstr("frames_per_second"));
}

/// The point (row vector) times the matrix, divided by its last coordinate.
std::array<double, 3> mapped(const RowMatrix& m, double x, double y, double z) {
  double out[4];
  for (std::size_t k = 0; k < 4; ++k)
    out[k] = x * static_cast<double>(m.m[k]) + y * static_cast<double>(m.m[4 + k]) +
             z * static_cast<double>(m.m[8 + k]) + static_cast<double>(m.m[12 + k]);
  return {out[0] / out[3], out[1] / out[3], out[2] / out[3]};
}

TEST(CameraFacts, PointsGoWhereTheyAreSeen) {
  // At (10, 0, 0), towards +x: right is -z.
  const v1::Scene scene = scene_of(
      "camera { perspective { fov_degrees: 90 } world_from_camera { elements: [0,0,1,10, 0,1,0,0, -1,0,0,0, "
      "0,0,0,1] } }");
  Image image;
  image.display = {0, 0, 200, 100};
  add_camera_facts(scene.camera(), image);
  const auto& camera = std::get<RowMatrix>(image.metadata.at("worldToCamera"));
  const auto& ndc = std::get<RowMatrix>(image.metadata.at("worldToNDC"));
  EXPECT_NEAR(mapped(camera, 15, 2, -3)[0], 3, 1e-6);
  EXPECT_NEAR(mapped(camera, 15, 2, -3)[1], 2, 1e-6);
  EXPECT_NEAR(mapped(camera, 15, 2, -3)[2], 5, 1e-6);
  // The shorter side shows [-1, 1] at a distance of 1, the longer [-2, 2].
  EXPECT_NEAR(mapped(ndc, 15, 0, 0)[0], 0.5, 1e-6);
  EXPECT_NEAR(mapped(ndc, 15, 5, -10)[0], 1, 1e-6);
  EXPECT_NEAR(mapped(ndc, 15, 5, -10)[1], 0, 1e-6);
  EXPECT_NEAR(mapped(ndc, 12, -2, 4)[0], 0, 1e-6);
  EXPECT_NEAR(mapped(ndc, 12, -2, 4)[1], 1, 1e-6);
}

TEST(CameraFacts, LensesHaveOpenExrsNames) {
  const v1::Scene scene = scene_of(
      "camera { lens { lens { name: 'singlet' surfaces { stop: true diameter_mm: 20 thickness_mm: 1 }"
      "surfaces { radius_mm: 100 thickness_mm: 2 diameter_mm: 24 index: 1.5 }"
      "surfaces { radius_mm: -100 thickness_mm: 100 diameter_mm: 24 } } focus_distance: 5 } }");
  Image image;
  image.display = {0, 0, 200, 100};
  add_camera_facts(scene.camera(), image);
  // By the lensmaker's equation; the stop is before the lens, so that it is the entrance pupil.
  const double focal_length = 1 / (0.5 * (0.02 - 0.5 * 2 / (1.5 * 100 * 100)));
  EXPECT_NEAR(std::get<float>(image.metadata.at("effectiveFocalLength")), focal_length, 1e-3);
  EXPECT_NEAR(std::get<float>(image.metadata.at("aperture")), focal_length / 20, 1e-4);
  EXPECT_EQ(std::get<float>(image.metadata.at("focus")), 5);
  EXPECT_EQ(std::get<std::string>(image.metadata.at("lensModel")), "singlet");
}

TEST(CameraFacts, PixelsOfOneHaveTheLuminanceThatTheSceneSays) {
  const v1::Scene scene =
      scene_of("camera { perspective {} } film { exposure: 4 } units { cd_per_m2: 72983 }");
  Image image;
  add_luminance_facts(scene, "", scene.camera(), image);
  EXPECT_FLOAT_EQ(std::get<float>(image.metadata.at("whiteLuminance")), 72983 / 4.f);
  Image brighter;
  add_luminance_facts(scene, "+1", scene.camera(), brighter);
  EXPECT_FLOAT_EQ(std::get<float>(brighter.metadata.at("whiteLuminance")), 72983 / 8.f);
  Image unsaid;
  add_luminance_facts(scene_of("camera { perspective {} }"), "", scene.camera(), unsaid);
  EXPECT_TRUE(unsaid.metadata.empty());
}

TEST(CameraFacts, PhotographersSettingsHaveOpenExrsNames) {
  const v1::Scene scene = scene_of(
      "camera { pinhole { hole_mm: 0.5 film_distance_mm: 100 film_gauge: '4x5' } }"
      "film { photographic_exposure { shutter_seconds: 2 iso: 400 cd_per_m2: 10 } }");
  Image image;
  image.display = {0, 0, 120, 96};
  add_camera_facts(scene.camera(), image);
  add_exposure_facts(scene.film(), "", scene.camera(), image);
  const auto number = [&](const char* name) { return std::get<float>(image.metadata.at(name)); };
  EXPECT_EQ(number("pinholeFocalLength"), 100);
  // Half of 96 mm at 100 mm is the upper edge.
  EXPECT_NEAR(mapped(std::get<RowMatrix>(image.metadata.at("worldToNDC")), 0, .48, 1)[1], 0, 1e-6);
  EXPECT_EQ(number("aperture"), 200);
  EXPECT_EQ(number("expTime"), 2);
  EXPECT_EQ(number("isoSpeed"), 400);
  EXPECT_EQ(std::get<NumberPair>(image.metadata.at("sensorOverallDimensions")), (NumberPair{120, 96}));
  // A luminance of so many cd/m^2 is 1: its illuminance is pi sin^2 of it, and .018 of lux seconds times
  // speed.
  const double irradiance = std::numbers::pi * .0625 / (1e4 + .0625);
  EXPECT_NEAR(number("whiteLuminance"), 1 / (.018 * 400 * 2 * irradiance), 1e-3 / irradiance);
  EXPECT_FALSE(image.metadata.contains("tStop"));
  Image plain;
  add_exposure_facts(v1::Film(), "", scene.camera(), plain);
  EXPECT_TRUE(plain.metadata.empty());
  Image by_words;
  add_exposure_facts(v1::Film(), "t/4 1/50s", scene.camera(), by_words);
  EXPECT_EQ(std::get<float>(by_words.metadata.at("tStop")), 4);
  EXPECT_FALSE(by_words.metadata.contains("isoSpeed"));
}

TEST(FileFacts, TimeCodesCountFramesOfTheRate) {
  Image image;
  add_frame_facts(24 * 3661 + 13, {24, 1}, .5, image);
  EXPECT_EQ(std::get<float>(image.metadata.at("shutterAngle")), 180);
  EXPECT_EQ(std::get<TimeCode>(image.metadata.at("timeCode")).time_and_flags, 0x01010113u);
  Image fast;
  add_frame_facts(5, {120, 1}, 0, fast);
  EXPECT_FALSE(fast.metadata.contains("shutterAngle"));
  EXPECT_FALSE(fast.metadata.contains("timeCode"));
  EXPECT_EQ(std::get<Rational>(fast.metadata.at("framesPerSecond")), (Rational{120, 1}));
}

TEST(FileFacts, DatesAreLocalWithTheWayToUtc) {
  ::setenv("TZ", "XYZ-2", 1);  // two hours ahead of UTC
  ::tzset();
  Image image;
  add_file_facts("kitchen", 1700000000, image);  // 2023-11-14 22:13:20 UTC
  EXPECT_EQ(std::get<std::string>(image.metadata.at("capDate")), "2023:11:15 00:13:20");
  EXPECT_EQ(std::get<float>(image.metadata.at("utcOffset")), -7200);
  EXPECT_THAT(std::get<std::string>(image.metadata.at("comments")), HasSubstr("kitchen"));
  ::unsetenv("TZ");
  ::tzset();
}

TEST(JobSettings, OverscanShowsMoreOfTheSameCamera) {
  ImportedScene imported;
  imported.scene.mutable_film()->set_width(200);
  imported.scene.mutable_film()->set_height(100);
  imported.scene.mutable_camera()->mutable_perspective()->set_fov_degrees(60);
  JobSettings request;
  request.overscan = 10;
  const auto job = prepare_job(request, imported, "");
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_EQ((*job)->spec.view().width(), 220u);
  EXPECT_EQ((*job)->spec.view().height(), 120u);
  EXPECT_EQ((*job)->spec.farm().overscan(), 10u);
  v1::Scene sent;
  ASSERT_TRUE(sent.ParseFromString((*job)->scene.bytes));
  // Ten pixels of a hundredth of the shorter side, which is 2 units high.
  EXPECT_THAT(sent.camera().screen_window(), testing::ElementsAre(-2.2f, 2.2f, -1.2f, 1.2f));
  request.crop = v1::PixelRect{};
  EXPECT_EQ(prepare_job(request, imported, "").status().code(), absl::StatusCode::kOutOfRange);
}

TEST(JobSettings, CryptomatteTakesTheFiltersOwnSamples) {
  ImportedScene imported;
  imported.scene.mutable_film()->set_width(64);
  imported.scene.mutable_film()->set_height(64);
  imported.scene.mutable_film()->mutable_filter()->set_kind(v1::PixelFilter::TRIANGLE);
  JobSettings request;
  const auto usual = prepare_job(request, imported, "");
  ASSERT_TRUE(usual.ok()) << usual.status();
  EXPECT_EQ((*usual)->spec.view().reconstruction(), v1::RECONSTRUCTION_SCATTER);
  request.aovs = {v1::AOV_CRYPTO_OBJECT};
  const auto job = prepare_job(request, imported, "");
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_EQ((*job)->spec.view().reconstruction(), v1::RECONSTRUCTION_SAMPLE);
  request.settings.set_reconstruction(v1::RECONSTRUCTION_SCATTER);
  EXPECT_THAT(std::string(prepare_job(request, imported, "").status().message()), HasSubstr("Cryptomatte"));
}

}  // namespace
}  // namespace tessera::client::animations
