#include "command/jobs/job_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "unit/client/job_scene.h"
#include "wire/algorithm.h"
#include "wire/digest.h"
#include "wire/job_check.h"
#include "wire/limits.h"

namespace tessera::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(JobSettings, EverythingHasADefault) {
  const ImportedScene scene = scene_of(640, 480);
  const auto job = prepare_job({}, scene, "kitchen");
  ASSERT_TRUE(job.ok()) << job.status();
  const v1::JobSpec& spec = (*job)->spec;
  EXPECT_EQ(spec.farm().name(), "kitchen");
  EXPECT_EQ(spec.view().width(), 640U);
  EXPECT_EQ(spec.view().height(), 480U);
  EXPECT_EQ(spec.cut().crop().x1(), 640U);
  EXPECT_EQ(spec.cut().crop().y1(), 480U);
  EXPECT_EQ(spec.cut().tile_size(), 128U) << "paths are shared across edges";
  EXPECT_EQ(spec.content().algorithms().integrator(), "path");
  EXPECT_EQ(spec.view().sampler(), v1::SAMPLER_SOBOL);
  EXPECT_EQ(spec.samples().spp(), 16U);
  EXPECT_EQ(spec.view().max_depth(), 5U);
}

TEST(JobSettings, SamplesInZOrderDependOnTheirNumber) {
  JobSettings request;
  request.settings.set_sampler(v1::SAMPLER_Z_SOBOL);
  for (const auto& [spp, bits] : {std::pair{1u, 0u}, {2u, 1u}, {10u, 4u}, {16u, 4u}, {17u, 5u}}) {
    request.settings.set_spp(spp);
    const auto job = prepare_job(request, scene_of(64, 48), "");
    ASSERT_TRUE(job.ok()) << job.status();
    EXPECT_EQ((*job)->spec.view().sample_bits(), bits) << spp;
    v1::JobSpec wrong = (*job)->spec;
    wrong.mutable_view()->set_sample_bits(bits + 1);
    EXPECT_THAT(wire::check_settings(wrong).message(), HasSubstr("view.sample_bits is"));
    wrong.mutable_view()->set_sampler(v1::SAMPLER_SOBOL);
    EXPECT_EQ(wire::check_settings(wrong).code(), absl::StatusCode::kInvalidArgument);
  }
}

TEST(JobSettings, ABiasedPictureIsWarnedOf) {
  const ImportedScene scene = scene_of(64, 48);
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms()) {
    JobSettings request;
    request.settings.set_integrator(algorithm.name);
    const auto job = prepare_job(request, scene, "");
    ASSERT_TRUE(job.ok()) << job.status();
    if (algorithm.bias == wire::Bias::kBiased) {
      EXPECT_THAT((*job)->warnings, ElementsAre(HasSubstr("' is biased")));
    } else {
      EXPECT_THAT((*job)->warnings, IsEmpty());
    }
  }
}

TEST(JobSettings, ScenesDeeperThanPathsCanBeAreRenderedToThatDepth) {
  ImportedScene scene = scene_of(64, 48);
  scene.scene.mutable_settings()->set_max_depth(1'000'000);
  const auto job = prepare_job({}, scene, "");
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_EQ((*job)->spec.view().max_depth(), wire::kMaxDepth);
}

TEST(JobSettings, WhatTheSceneAsksForHoldsUnlessOverridden) {
  ImportedScene scene = scene_of(640, 480);
  scene.scene.mutable_settings()->set_spp(100);
  scene.scene.mutable_settings()->set_max_depth(0);
  scene.scene.mutable_settings()->set_seed(7);
  scene.scene.mutable_settings()->set_sampler(v1::SAMPLER_INDEPENDENT);
  const auto held = prepare_job({}, scene, "");
  ASSERT_TRUE(held.ok());
  EXPECT_EQ((*held)->spec.samples().spp(), 100U);
  EXPECT_EQ((*held)->spec.view().max_depth(), 0U) << "0 is asked for, too";
  EXPECT_EQ((*held)->spec.view().seed(), 7U);
  EXPECT_EQ((*held)->spec.view().sampler(), v1::SAMPLER_INDEPENDENT);

  JobSettings request;
  request.settings.set_spp(3);
  request.settings.set_max_depth(9);
  request.settings.set_seed(0);
  request.settings.set_sampler(v1::SAMPLER_SOBOL);
  request.resolution = Resolution{64, 32};
  const auto overridden = prepare_job(request, scene, "");
  ASSERT_TRUE(overridden.ok());
  EXPECT_EQ((*overridden)->spec.samples().spp(), 3U);
  EXPECT_EQ((*overridden)->spec.view().max_depth(), 9U);
  EXPECT_EQ((*overridden)->spec.view().seed(), 0U);
  EXPECT_EQ((*overridden)->spec.view().sampler(), v1::SAMPLER_SOBOL);
  EXPECT_EQ((*overridden)->spec.view().width(), 64U);
  EXPECT_EQ((*overridden)->spec.cut().crop().y1(), 32U);
}

TEST(JobSettings, IntersectionIsChosenByRequestSceneOrProbe) {
  ImportedScene scene = scene_of(8, 8);
  const auto chosen = [&](const JobSettings& request) {
    return (*prepare_job(request, scene, ""))->spec.content().algorithms().intersection();
  };
  EXPECT_EQ(chosen({}), v1::INTERSECTION_AUTO);
  scene.scene.mutable_settings()->set_intersection(v1::INTERSECTION_ROBUST);
  EXPECT_EQ(chosen({}), v1::INTERSECTION_ROBUST);
  JobSettings request;
  request.settings.set_intersection(v1::INTERSECTION_FAST);
  EXPECT_EQ(chosen(request), v1::INTERSECTION_FAST);
  request.settings.set_intersection(v1::INTERSECTION_AUTO);
  EXPECT_EQ(chosen(request), v1::INTERSECTION_AUTO) << "over what the scene says";
  scene.scene.mutable_settings()->set_intersection(static_cast<v1::Intersection>(9));
  EXPECT_THAT(std::string{prepare_job({}, scene, "").status().message()},
              HasSubstr("intersection is number 9"));
}

TEST(JobSettings, NamesEveryBlobAndTheSceneByItsDigest) {
  ImportedScene scene = scene_of(8, 8);
  SceneBlob mesh;
  mesh.bytes = "mesh";
  mesh.ref.set_digest(wire::sha256_hex(mesh.bytes));
  scene.blobs.push_back(mesh);
  const auto job = prepare_job({}, scene, "");
  ASSERT_TRUE(job.ok());
  ASSERT_EQ((*job)->spec.farm().blobs_size(), 2);
  EXPECT_EQ((*job)->spec.farm().blobs(1).digest(), mesh.ref.digest());
  EXPECT_EQ((*job)->spec.farm().blobs(0).digest(), (*job)->spec.content().scene());
  EXPECT_EQ((*job)->spec.content().scene(), wire::sha256_hex(scene.scene.SerializeAsString()));
  EXPECT_EQ((*job)->blobs.size(), 2U);
}

TEST(JobSettings, ACropMustLieWithinTheFilm) {
  const ImportedScene scene = scene_of(100, 50);
  JobSettings request;
  request.crop = *parse_crop("0,0,100,51");
  EXPECT_EQ(prepare_job(request, scene, "").status().code(), absl::StatusCode::kOutOfRange);
  request.crop = *parse_crop("99,49,100,50");
  EXPECT_TRUE(prepare_job(request, scene, "").ok());
}

TEST(JobSettings, AFilmWithoutPixelsIsTheScenesFault) {
  EXPECT_EQ(prepare_job({}, scene_of(0, 480), "").status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(JobSettings, AovsAreInOrderEachOnce) {
  JobSettings request;
  request.aovs = {v1::AOV_DEPTH, v1::AOV_VARIANCE, v1::AOV_DEPTH};
  const ImportedScene scene = scene_of(8, 8);
  const auto job = prepare_job(request, scene, "");
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_THAT((*job)->spec.view().aovs(), testing::ElementsAre(v1::AOV_VARIANCE, v1::AOV_DEPTH));
}

TEST(JobSettings, UnitsAreAPowerOfTwoOfSixteenThousandSamplesAtMost) {
  EXPECT_EQ(samples_per_unit(1024, 1, 4096), 16U);
  EXPECT_EQ(samples_per_unit(256, 1, 4096), 64U);
  EXPECT_EQ(samples_per_unit(1089, 1, 4096), 8U);
  EXPECT_EQ(samples_per_unit(1048576, 1, 4096), 1U);
  EXPECT_EQ(samples_per_unit(1024, 1, 16), 16U);
  EXPECT_EQ(samples_per_unit(256, 1, 17), 32U) << "one range may cover more than there is";
  EXPECT_EQ(samples_per_unit(8, 1, 1), 1U);
}

TEST(JobSettings, AJobHasAMillionUnitsAtMostWhereItCan) {
  constexpr std::uint64_t kTiles = 120 * 68;  // 3840x2160
  EXPECT_EQ(samples_per_unit(1024, kTiles, 1024), 16U);
  EXPECT_EQ(samples_per_unit(1024, kTiles, 4096), 32U);
  EXPECT_EQ(samples_per_unit(1024, kTiles, 65536), 512U);
  EXPECT_EQ(samples_per_unit(64, kTiles * 16 * 16, 16), 16U) << "a tile is a unit at least";
}

TEST(JobSettings, WithNoiseAUnitHasAllSamples) {
  const ImportedScene scene = scene_of(64, 64);
  JobSettings request;
  request.settings.set_spp(1000);
  request.settings.set_noise(0.05);
  const auto job = prepare_job(request, scene, "");
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_EQ((*job)->spec.cut().samples_per_unit(), 1024U);
  EXPECT_EQ((*job)->spec.samples().noise(), 0.05);
}

TEST(JobSettings, NoiseThatDoesNotGoWithTheRestIsRefused) {
  const ImportedScene scene = scene_of(64, 64);
  const auto refusal = [&](auto change) {
    JobSettings request;
    request.settings.set_spp(64);
    request.settings.set_noise(0.05);
    change(request);
    const auto job = prepare_job(request, scene, "");
    EXPECT_EQ(job.status().code(), absl::StatusCode::kOutOfRange);
    return std::string{job.status().message()};
  };
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.set_noise(2); }), HasSubstr("noise is 2"));
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.set_noise(-0.1); }), HasSubstr("noise is -0.1"));
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.set_noise(NAN); }), HasSubstr("noise is nan"));
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.set_spp(7); }), HasSubstr("8 or more"));
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.set_integrator("light"); }),
              HasSubstr("same samples everywhere"));
}

TEST(JobSettings, ParsesResolutions) {
  ASSERT_TRUE(parse_resolution("640x480").ok());
  EXPECT_EQ(parse_resolution("640x480")->width, 640U);
  EXPECT_EQ(parse_resolution("640x480")->height, 480U);
  EXPECT_TRUE(parse_resolution("100000x1").ok());
  EXPECT_TRUE(parse_resolution("65536x65536").ok());
  EXPECT_FALSE(parse_resolution("65537x65536").ok());
  for (const char* wrong :
       {"", "640", "640x", "x480", "640x480x", "640 x 480", "-1x5", "0x5", "5x0", "1000001x5", "1e3x5"}) {
    EXPECT_FALSE(parse_resolution(wrong).ok()) << wrong;
  }
}

TEST(JobSettings, ParsesCrops) {
  ASSERT_TRUE(parse_crop("1,2,3,4").ok());
  EXPECT_EQ(parse_crop("1,2,3,4")->y1(), 4U);
  for (const char* wrong :
       {"", "1,2,3", "1,2,3,4,5", "3,2,3,4", "1,4,3,4", "-1,2,3,4", "1;2;3;4", "1,2,3,99999999999"}) {
    EXPECT_FALSE(parse_crop(wrong).ok()) << wrong;
  }
}

}  // namespace
}  // namespace tessera::client
