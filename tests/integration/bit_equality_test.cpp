// The same bits whoever renders: in process, and on any number of workers with any threads and tiles.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <set>

#include "integration/farm_under_test.h"
#include "support/needs.h"
#include "support/picture/unpacked_corpus.h"

namespace tessera::integration {
namespace {

namespace fs = std::filesystem;
// The AOVs have channels of every kind. The crop cuts tiles.
const Arguments kView{
    "scenes/cornell-box/scene.pbrt",        "--resolution", "72x72", "--crop", "3,5,70,72", "--aov",
    "variance,albedo,normal,depth,samples", "--quiet"};
const Arguments kLayers{"--aov", "variance,albedo,normal,depth,samples,bounce0..bounce2", "--layers",
                        "red=C<RD'LeftWall'>.*L,lit=LDE"};
// Ranges that are no power of two, so that the sum tree has a ragged edge.
const Arguments kCornellBox = kView + kLayers + Arguments{"--spp", "50"};

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
  for (const Arguments& variation : {Arguments{"--threads", "3"}, Arguments{"--tile", "8"},
                                     Arguments{"--tile", "16"}, Arguments{"--tile", "64"}}) {
    EXPECT_EQ(render_hash(kCornellBox + variation), expected) << variation[0] << ' ' << variation[1];
  }
}

/// The scene's filter is a tent: unless something else is asked for, samples go into several pixels.
TEST(BitEquality, SamplesOfOnePixelOrOfAllAroundWhateverTiles) {
  std::set<std::string> pictures;
  for (const char* reconstruction : {"sample", "scatter"}) {
    const Arguments job = kCornellBox + Arguments{"--reconstruction", reconstruction};
    const std::string expected = render_hash(job);
    pictures.insert(expected);
    EXPECT_EQ(render_hash(job + Arguments{"--threads", "3", "--tile", "11"}), expected) << reconstruction;
  }
  EXPECT_EQ(pictures.size(), 2u);
  EXPECT_TRUE(pictures.contains(render_hash(kCornellBox)));
  // Wider filters reach beyond small tiles.
  const Arguments wide = kView + Arguments{"--spp", "10", "--filter", "lanczos"};
  const std::string expected = render_hash(wide);
  EXPECT_EQ(render_hash(wide + Arguments{"--threads", "3", "--tile", "3"}), expected);
}

/// Neighbours that share light are the same whatever tiles they lie in, whose borders may part them.
TEST(BitEquality, PixelsThatShareLightWhateverTiles) {
  std::set<std::string> pictures;
  for (const char* reconstruction : {"sample", "scatter"}) {
    for (const char* sharing : {"off", "4", "8", "16"}) {
      const Arguments job =
          kView + Arguments{"--spp", "10", "--reconstruction", reconstruction, "--path-sharing", sharing};
      const std::string expected = render_hash(job);
      pictures.insert(expected);
      EXPECT_EQ(render_hash(job + Arguments{"--threads", "3", "--tile", "11"}), expected)
          << reconstruction << ' ' << sharing;
    }
  }
  EXPECT_EQ(pictures.size(), 8u);
  EXPECT_TRUE(pictures.contains(render_hash(kView + Arguments{"--spp", "10"})));
  const Arguments noise = kView + Arguments{"--spp", "64", "--noise", "0.2"};
  const std::string expected = render_hash(noise);
  EXPECT_EQ(render_hash(noise + Arguments{"--threads", "3", "--tile", "24"}), expected);
}

TEST(BitEquality, OneTwoAndThreeWorkersWhateverTiles) {
  FarmUnderTest farm;
  const std::string expected = render_hash(kCornellBox);
  for (const int threads : {2, 1, 3}) {
    farm.add_worker(threads);
    for (const char* tile : {"8", "16", "64"}) {
      EXPECT_EQ(submit_hash(farm, kCornellBox + Arguments{"--tile", tile}), expected)
          << "with tiles of " << tile;
    }
  }
}

TEST(BitEquality, ObjectsWithinObjectsOnTwoWorkers) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(2);
  for (const char* nesting : {"auto", "kept"}) {
    const Arguments forest{"scenes/forest/scene.textproto",
                           "--resolution",
                           "40x20",
                           "--spp",
                           "4",
                           "--aov",
                           "normal,id",
                           "--nesting",
                           nesting,
                           "--quiet"};
    const std::string expected = render_hash(forest + Arguments{"--threads", "1"});
    EXPECT_EQ(submit_hash(farm, forest + Arguments{"--tile", "8"}), expected) << nesting;
  }
}

/// Ranges and results of a job that is done.
struct Cut {
  std::uint32_t units = 0, results = 0;
};

Cut cut_of(FarmUnderTest& farm, const std::string& job_id) {
  Cut cut;
  client::FarmClient::WatchHandlers handlers;
  handlers.result = [&](const v1::UnitResult& result) {
    cut.units += result.ranges();
    ++cut.results;
    return absl::OkStatus();
  };
  EXPECT_TRUE(farm.client().watch(job_id, handlers, {}).ok());
  return cut;
}

TEST(BitEquality, OneUnitAtATimeOrManyAsOneWhoeverIsKilled) {
  // Seven whole ranges of 64 samples and a ragged one, in each of 25 tiles.
  const Arguments job = kView + Arguments{"--spp", "500", "--tile", "16"};
  FarmUnderTest single{{}, {}, "127.0.0.1", {"--unit-seconds", "0"}};
  single.add_worker(2);
  const std::string alone = single.submit_detached(job);
  const std::string expected = single.fetch_hash(alone);
  const Cut units = cut_of(single, alone);
  EXPECT_EQ(units.results, 25 * 8U);
  EXPECT_EQ(units.units, 25 * 8U);

  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(1);
  const std::string job_id = farm.submit_detached(job);
  const auto done = [](std::uint32_t least) {
    return [least](const v1::JobStatus& status) { return status.units_done() >= least; };
  };
  farm.watch_until(job_id, done(30));
  farm.kill_worker(0);
  farm.watch_until(job_id, done(60));
  farm.kill_and_restart_coordinator();
  farm.restart_worker(0);
  EXPECT_EQ(farm.fetch_hash(job_id), expected);
  const Cut runs = cut_of(farm, job_id);
  EXPECT_EQ(runs.units, units.units);
  EXPECT_LT(runs.results, units.results);
  EXPECT_EQ(render_hash(job), expected) << "in process";
}

TEST(BitEquality, PassesOneAtATimeOrManyAsOne) {
  // 16 ranges of 16 passes over 128x128 pixels.
  const Arguments job{"scenes/cornell-box/scene.pbrt",
                      "--resolution",
                      "128x128",
                      "--integrator",
                      "light",
                      "--spp",
                      "256",
                      "--quiet"};
  FarmUnderTest single{{}, {}, "127.0.0.1", {"--unit-seconds", "0"}};
  single.add_worker(1);
  EXPECT_EQ(single.fetch_hash(single.submit_detached(job)), render_hash(job));
}

TEST(BitEquality, SamplesAsNoiseAsksInProcessAndOnTwoWorkersWhateverTiles) {
  // Its sky is quiet: blocks take different numbers of samples.
  const Arguments adaptive{
      "scenes/forest/scene.textproto", "--resolution", "72x72", "--crop",  "3,5,70,72", "--aov",
      "variance,albedo,samples",       "--spp",        "128",   "--noise", "0.06",      "--quiet"};
  const std::string expected = render_hash(adaptive);
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(2);
  for (const char* tile : {"8", "20", "64"}) {
    EXPECT_EQ(render_hash(adaptive + Arguments{"--threads", "3", "--tile", tile}), expected)
        << "tiles of " << tile;
    // The worker may be at anything.
    const std::string job = farm.submit_detached(adaptive + Arguments{"--tile", tile});
    farm.kill_worker(0);
    farm.restart_worker(0);
    EXPECT_EQ(farm.fetch_hash(job), expected) << "tiles of " << tile;
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

TEST(BitEquality, GhostsAndFocusInPassesInProcessAndOnTwoWorkers) {
  // Paths in passes, to which light that is sent into the lens is added; what is sharp is found by each
  // worker.
  const Arguments ghosts{"scenes/lenses/ghosts.textproto",
                         "--resolution",
                         "72x48",
                         "--crop",
                         "3,5,70,48",
                         "--spp",
                         "80",
                         "--aov",
                         "variance,samples",
                         "--quiet"};
  const std::string expected = render_hash(ghosts);
  EXPECT_EQ(render_hash(ghosts + Arguments{"--threads", "3"}), expected);
  EXPECT_NE(render_hash(ghosts + Arguments{"--set", "lens-ghosts=film"}), expected);
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(2);
  EXPECT_EQ(submit_hash(farm, ghosts), expected);
}

TEST(BitEquality, TextbookAlgorithmsInProcessAndOnTwoWorkersWhateverTiles) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(2);
  std::set<std::string> pictures;
  for (const char* algorithm : {"direct", "whitted", "raycast"}) {
    const Arguments job{"scenes/first-light/scene.textproto",
                        "--resolution",
                        "72x72",
                        "--integrator",
                        algorithm,
                        "--max-depth",
                        "8",
                        "--spp",
                        "8",
                        "--aov",
                        "id",
                        "--quiet"};
    const std::string expected = render_hash(job);
    pictures.insert(expected);
    for (const char* tile : {"8", "64"}) {
      EXPECT_EQ(render_hash(job + Arguments{"--threads", "3", "--tile", tile}), expected)
          << algorithm << ", tiles of " << tile;
    }
    EXPECT_EQ(submit_hash(farm, job + Arguments{"--tile", "24"}), expected) << algorithm;
  }
  EXPECT_EQ(pictures.size(), 3u) << "the scene has no glass";
}

TEST(BitEquality, LightOfWavelengthsInProcessAndOnTwoWorkersWhateverTiles) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(2);
  for (const char* sharing : {"off", "4"}) {
    const Arguments job{"scenes/metamers/scene.textproto",
                        "--resolution",
                        "72x36",
                        "--spp",
                        "16",
                        "--path-sharing",
                        sharing,
                        "--quiet"};
    const std::string expected = render_hash(job);
    EXPECT_NE(render_hash(job + Arguments{"--color", "rgb"}), expected);
    EXPECT_EQ(render_hash(job + Arguments{"--threads", "3", "--tile", "16"}), expected) << sharing;
    EXPECT_EQ(submit_hash(farm, job + Arguments{"--tile", "24"}), expected) << sharing;
  }
}

TEST(BitEquality, BandsAndSensorsInProcessAndOnTwoWorkersWhateverTiles) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(2);
  const Arguments scene{"scenes/metamers/scene.textproto", "--resolution", "72x36", "--spp", "16", "--quiet"};
  const std::string plain = render_hash(scene);
  for (const char* integrator : {"path", "light", "bdpt", "vcm", "photon", "mlt", "guided"}) {
    const Arguments job =
        scene + Arguments{"--film",       "spectral:7:380-760", "--sensor", "nikon-d5100",
                          "--integrator", integrator,           "--set",    "white-balance=F2"};
    const std::string expected = render_hash(job);
    EXPECT_NE(expected, plain);
    EXPECT_EQ(render_hash(job + Arguments{"--threads", "3", "--tile", "16"}), expected) << integrator;
    EXPECT_EQ(submit_hash(farm, job + Arguments{"--tile", "24"}), expected) << integrator;
  }
}

TEST(BitEquality, DispersedLightOfAllIntegratorsInProcessAndOnTwoWorkers) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(2);
  for (const char* algorithm : {"path", "bdpt", "vcm", "photon", "mlt", "guided", "whitted"}) {
    SCOPED_TRACE(algorithm);
    const Arguments job{"scenes/prism/scene.textproto",
                        "--resolution",
                        "72x40",
                        "--integrator",
                        algorithm,
                        "--spp",
                        "4",
                        "--quiet"};
    const std::string expected = render_hash(job);
    EXPECT_EQ(render_hash(job + Arguments{"--threads", "3", "--tile", "16"}), expected);
    EXPECT_EQ(submit_hash(farm, job + Arguments{"--tile", "24"}), expected);
  }
}

TEST(BitEquality, OtherSeedsAndSamplersGiveOtherBits) {
  const std::string sobol = render_hash(kCornellBox + Arguments{"--sampler", "sobol"});
  EXPECT_NE(render_hash(kCornellBox + Arguments{"--sampler", "sobol", "--seed", "1"}), sobol);
  EXPECT_NE(render_hash(kCornellBox + Arguments{"--sampler", "independent"}), sobol);
}

TEST(BitEquality, ClassroomInProcessAndOnTwoWorkers) {
  const auto folder = test::find_corpus("pbrt/classroom");
  if (!folder) GTEST_SKIP() << test::needs("../shared/scenes/pbrt/classroom");
  FarmUnderTest farm;
  const Arguments classroom{
      (folder->path() / "scene.pbrt").string(), "--resolution", "96x54", "--spp", "8", "--quiet"};

  const std::string expected = render_hash(classroom);
  farm.add_worker(1);
  farm.add_worker(2);
  EXPECT_EQ(submit_hash(farm, classroom + Arguments{"--tile", "16"}), expected);
  // Among so many triangles some rays hit edges.
  const Arguments large{
      (folder->path() / "scene.pbrt").string(), "--resolution", "320x180", "--spp", "2", "--quiet"};
  EXPECT_EQ(render_hash(large + Arguments{"--tile", "13"}), render_hash(large));
}

}  // namespace
}  // namespace tessera::integration
