// `--integrator auto`, from the command line to the image and the farm.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "image/exr.h"
#include "integration/farm_under_test.h"
#include "support/process/temp_dir.h"
#include "wire/algorithm.h"

namespace tessera::integration {
namespace {

using testing::AnyOf;
using testing::HasSubstr;

constexpr const char* kGlass = "scenes/glass-of-water/scene.textproto";
constexpr const char* kBox = "scenes/cornell-box/scene.pbrt";
/// Minutes of CPU time: a pilot of 3 % of them tells on any machine. For choices alone.
const Arguments kHugeJob{"--resolution", "128x96", "--spp", "16384"};
/// Some seconds of it: a pilot tells unless the machine is loaded. What it chooses when it does is tested by
/// costs that are told (tests/unit/client/auto_choice_test.cpp); here, that all that is said agrees.
const Arguments kLongJob{"--resolution", "128x96", "--spp", "512"};
/// A pilot of 3 % of this would tell nothing.
const Arguments kShortJob{"--resolution", "32x24", "--spp", "4"};

/// The words of the image's file.
std::string metadata(const std::filesystem::path& exr, const std::string& name) {
  const auto image = client::read_exr(exr.string());
  if (!image.ok() || !image->metadata.contains(name)) return "";
  const std::string* const text = std::get_if<std::string>(&image->metadata.at(name));
  return text == nullptr ? "" : *text;
}

std::string contents_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// `tessera render --integrator auto`: the integrator that was chosen. The image and the statistics are in
/// the folder.
std::string choose(const std::string& scene, const Arguments& job, const std::filesystem::path& folder,
                   std::string* messages = nullptr) {
  const std::string image = (folder / "auto.exr").string(), stats = (folder / "auto.json").string();
  const support::Finished done =
      tessera(Arguments{"render", scene, "--integrator", "auto", "-o", image, "--stats", stats} + job);
  EXPECT_EQ(done.status.code, 0) << done.err;
  if (messages != nullptr) *messages = done.err;
  return metadata(image, "tessera.integrator");
}

TEST(Auto, TellsWhyInTheImageAndTheStatistics) {
  const support::TempDir folder;
  std::string messages;
  const std::string chosen = choose(kGlass, kLongJob, folder.path(), &messages);
  const std::string told = metadata(folder.path() / "auto.exr", "tessera.auto");
  const std::string stats = contents_of(folder.path() / "auto.json");
  EXPECT_THAT(stats, HasSubstr("\"auto\""));
  EXPECT_THAT(messages, HasSubstr("integrator " + chosen + ", "));
  EXPECT_THAT(told, HasSubstr("integrator " + chosen));
  EXPECT_THAT(stats, HasSubstr("\"" + chosen + "\""));
  EXPECT_EQ(pixel_sha256(folder.path() / "auto.exr"),
            expected_hash(Arguments{kGlass, "--integrator", chosen} + kLongJob));
}

TEST(Auto, TakesPathsFromTheCameraWhereTheyAreEnough) {
  const support::TempDir folder;
  // bdpt and vcm cost five times as much for a third of the variance; light is close behind path.
  EXPECT_THAT(choose(kBox, kLongJob, folder.path()), AnyOf("path", "light"));
}

TEST(Auto, AShortJobIsRenderedAsUsual) {
  const support::TempDir folder;
  std::string messages;
  EXPECT_EQ(choose(kGlass, kShortJob, folder.path(), &messages), "path");
  EXPECT_THAT(messages, HasSubstr("too short for a pilot"));
  EXPECT_EQ(pixel_sha256(folder.path() / "auto.exr"),
            expected_hash(Arguments{kGlass, "--integrator", "path"} + kShortJob));
}

TEST(Auto, SettingsThatOneIntegratorHasLeaveTheOthersOut) {
  const support::TempDir folder;
  const Arguments noise{"--resolution", "32x24", "--spp", "64", "--noise", "0.5"};
  EXPECT_EQ(choose(kBox, noise, folder.path()), "path");
  const std::string told = metadata(folder.path() / "auto.exr", "tessera.auto");
  EXPECT_THAT(told, HasSubstr("no other goes with the settings"));
  EXPECT_THAT(told, HasSubstr("bdpt: integrator 'bdpt' takes the same samples everywhere"));
}

TEST(Auto, IsRefusedWhereNothingCanBeChosen) {
  const auto expect_refusal = [](const Arguments& arguments, const char* what) {
    const support::Finished done = tessera(arguments);
    EXPECT_EQ(done.status.code, 2) << done.err;
    EXPECT_THAT(done.err, HasSubstr(what));
  };
  expect_refusal({"render", kBox, "--integrator", "auto", "--set", "photon.radius=0.1", "-o", "/tmp/no.exr"},
                 "photon");
  expect_refusal({"bench", kBox, "--integrator", "auto", "--make-reference", "4"}, "has to be named");
  expect_refusal({"bench", kBox, "--compare", "integrator=path,auto", "--make-reference", "4"},
                 "has to be named");
}

TEST(Auto, ASceneMayAskForIt) {
  const support::TempDir folder;
  const std::string scene = (folder.path() / "scene.textproto").string();
  {
    std::ofstream file(scene);
    file << "settings { integrator: \"auto\" spp: 4 }\n"
            "camera { perspective { fov_degrees: 60 } }\n"
            "film { width: 16 height: 16 }\n";
  }
  EXPECT_EQ(choose(scene, {}, folder.path()), "path");
}

TEST(Auto, FindsCausticsFromBothEnds) {
  FarmUnderTest farm;  // without workers: nobody renders it
  const std::string job = farm.submit_detached(Arguments{kGlass, "--integrator", "auto"} + kHugeJob);
  const auto kept = farm.client().job(job, {});
  ASSERT_TRUE(kept.ok()) << kept.status();
  const std::string chosen = kept->spec().content().algorithms().integrator();
  EXPECT_THAT(chosen, AnyOf("bdpt", "vcm"));
  ASSERT_GE(kept->spec().farm().auto_choice().candidates_size(), 4);
  EXPECT_EQ(kept->spec().farm().auto_choice().candidates(0).integrator(), chosen);
  const support::Finished told = tessera(farm.on_farm({"job", job}));
  EXPECT_THAT(told.out, HasSubstr("chosen      integrator " + chosen + ", by a pilot of "));
}

TEST(Auto, AFarmRendersWhatTheClientHasChosen) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(1);
  const std::string job = farm.submit_detached(Arguments{kGlass, "--integrator", "auto"} + kLongJob);
  const auto kept = farm.client().job(job, {});
  ASSERT_TRUE(kept.ok()) << kept.status();
  const std::string chosen = kept->spec().content().algorithms().integrator();
  EXPECT_EQ(farm.fetch_hash(job), expected_hash(Arguments{kGlass, "--integrator", chosen} + kLongJob));

  // The choice is no part of what results are kept by.
  const std::string named = farm.submit_detached(Arguments{kGlass, "--integrator", chosen} + kLongJob);
  EXPECT_EQ(farm.watch_to_the_end(named).stats().samples(), 0u);
}

TEST(Auto, MoreSamplesAreTakenByTheSameIntegrator) {
  FarmUnderTest farm;
  farm.add_worker(2);
  const Arguments few{kGlass, "--resolution", "64x48", "--spp", "16"};
  const std::string first = farm.submit_detached(few + Arguments{"--integrator", "bdpt"});
  farm.watch_to_the_end(first);
  const std::string more = farm.submit_detached(
      {kGlass, "--resolution", "64x48", "--spp", "32", "--integrator", "auto", "--continue", first});
  const auto job = farm.client().job(more, {});
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_EQ(job->spec().content().algorithms().integrator(), "bdpt");
  EXPECT_THAT(job->spec().farm().auto_choice().reason(), HasSubstr("continued"));
  EXPECT_EQ(farm.watch_to_the_end(more).stats().samples(), 16u * 64 * 48);
}

}  // namespace
}  // namespace tessera::integration
