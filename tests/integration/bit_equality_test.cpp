// The same bits whoever renders: in process, and on any number of workers with any threads and tiles.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

namespace fs = std::filesystem;
// The AOVs have channels of every kind. The crop cuts tiles.
const Arguments kView{"scenes/cornell-box/scene.pbrt",        "--resolution", "72x72", "--crop", "3,5,70,72", "--aov",
                      "variance,albedo,normal,depth,samples", "--quiet"};
// Ranges that are no power of two, so that the sum tree has a ragged edge.
const Arguments kCornellBox = kView + Arguments{"--spp", "50"};

std::string render_hash(const Arguments& arguments) {
  const support::TempDir directory;
  const std::string image = (directory.path() / "in-process.exr").string();
  const support::Finished done = tessera(Arguments{"render"} + arguments + Arguments{"-o", image});
  EXPECT_EQ(done.status.code, 0) << done.err;
  return pixel_sha256(image);
}

std::string submit_hash(const FarmUnderTest& farm, const Arguments& arguments) {
  const std::string image = (farm.directory() / "farm.exr").string();
  const support::Finished done =
      tessera(farm.on_farm(Arguments{"submit", "--fresh"} + arguments + Arguments{"-o", image}));
  EXPECT_EQ(done.status.code, 0) << done.err;
  return pixel_sha256(image);
}

TEST(BitEquality, InProcessWhateverThreadsAndTiles) {
  const std::string expected = render_hash(kCornellBox + Arguments{"--threads", "1"});
  for (const Arguments& variation :
       {Arguments{"--threads", "3"}, Arguments{"--tile", "8"}, Arguments{"--tile", "16"}, Arguments{"--tile", "64"}}) {
    EXPECT_EQ(render_hash(kCornellBox + variation), expected) << variation[0] << ' ' << variation[1];
  }
}

TEST(BitEquality, OneTwoAndThreeWorkersWhateverTiles) {
  FarmUnderTest farm;
  const std::string expected = render_hash(kCornellBox);
  for (const int threads : {2, 1, 3}) {
    farm.add_worker(threads);
    for (const char* tile : {"8", "16", "64"}) {
      EXPECT_EQ(submit_hash(farm, kCornellBox + Arguments{"--tile", tile}), expected) << "with tiles of " << tile;
    }
  }
}

TEST(BitEquality, SamplesAsNoiseAsksInProcessAndOnTwoWorkersWhateverTiles) {
  const Arguments adaptive = kView + Arguments{"--spp", "128", "--noise", "0.2"};
  const std::string expected = render_hash(adaptive);
  EXPECT_NE(render_hash(kView + Arguments{"--spp", "128"}), expected);
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(2);
  for (const char* tile : {"8", "24", "64"}) {
    EXPECT_EQ(render_hash(adaptive + Arguments{"--threads", "3", "--tile", tile}), expected) << "tiles of " << tile;
    EXPECT_EQ(submit_hash(farm, adaptive + Arguments{"--tile", tile}), expected) << "tiles of " << tile;
  }
}

TEST(BitEquality, LightTracingInPassesInProcessAndOnTwoWorkers) {
  // A pass of 72 x 72 paths: units of 32 passes at most, so three of 80.
  const Arguments light{"scenes/cornell-box/scene.pbrt",
                        "--resolution",
                        "72x72",
                        "--crop",
                        "3,5,70,72",
                        "--spp",
                        "80",
                        "--integrator",
                        "light",
                        "--aov",
                        "variance,samples",
                        "--quiet"};
  const std::string expected = render_hash(light);
  EXPECT_EQ(render_hash(light + Arguments{"--threads", "3"}), expected);
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(2);
  EXPECT_EQ(submit_hash(farm, light), expected);
}

TEST(BitEquality, OtherSeedsAndSamplersGiveOtherBits) {
  const std::string sobol = render_hash(kCornellBox + Arguments{"--sampler", "sobol"});
  EXPECT_NE(render_hash(kCornellBox + Arguments{"--sampler", "sobol", "--seed", "1"}), sobol);
  EXPECT_NE(render_hash(kCornellBox + Arguments{"--sampler", "independent"}), sobol);
}

TEST(BitEquality, ClassroomInProcessAndOnTwoWorkers) {
  const fs::path archive = "../shared/scenes/pbrt/classroom.tar.xz";
  if (!fs::exists(archive)) GTEST_SKIP() << archive << " is not there";
  FarmUnderTest farm;
  const support::Finished unpacked =
      support::run_program({"/bin/tar", "xJf", archive.string(), "-C", farm.directory().string()}, kPatience);
  ASSERT_EQ(unpacked.status.code, 0) << unpacked.err;
  const Arguments classroom{
      (farm.directory() / "classroom/scene.pbrt").string(), "--resolution", "96x54", "--spp", "8", "--quiet"};

  const std::string expected = render_hash(classroom);
  farm.add_worker(1);
  farm.add_worker(2);
  EXPECT_EQ(submit_hash(farm, classroom + Arguments{"--tile", "16"}), expected);
}

}  // namespace
}  // namespace tessera::integration
