// Workers of two arithmetic classes that are real: kernels of two instruction sets; or, where
// TESSERA_OTHER_BIN names the folder of another build's programs (another system's, entered by a script,
// another compiler's), those.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "image/exr.h"
#include "integration/farm_under_test.h"
#include "render/renderer.h"
#include "support/process/tcp_proxy.h"

namespace tessera::integration {
namespace {

using support::TcpProxy;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

// Depths and deviations show a difference where colours do not.
const Arguments kView{
    "scenes/cornell-box/scene.pbrt", "--resolution", "160x160", "--aov", "variance,depth", "--quiet"};

// Tiles of one unit each; kernels for AVX2 and AVX-512 round three in four of them differently.
constexpr int kTile = 4;
const Arguments kSmallTiles = kView + Arguments{"--spp", "8", "--tile", "4", "--fresh"};
constexpr unsigned kUnits = 40 * 40;

/// A wrapper that runs `program` in place of the one under test.
Arguments instead(const std::string& program) {
  return {"/bin/bash", "-c", "exec \"$0\" \"${@:2}\"", program};
}

/// The other build's program; empty when there is none.
std::string other_program(const std::string& name) {
  const char* const folder = std::getenv("TESSERA_OTHER_BIN");
  return folder == nullptr ? "" : std::string{folder} + "/" + name;
}

class TwoClasses : public testing::Test {
 protected:
  void SetUp() override {
    const std::vector<std::string> isas = render::supported_isas();
    ASSERT_FALSE(isas.empty());
    ours_.options = {"--tag", "ours", "--isa", isas.front()};
    theirs_.options = {"--tag", "theirs"};
    if (const std::string other = other_program("tessera-worker"); !other.empty()) {
      theirs_.wrapper = instead(other);
    } else if (isas.size() < 2) {
      GTEST_SKIP() << "kernels for " << isas.front() << " only, and TESSERA_OTHER_BIN names no other build";
    } else {
      theirs_.options.insert(theirs_.options.end(), {"--isa", isas.back()});
    }
  }

  /// Adds workers and waits until the coordinator knows them.
  static void add(FarmUnderTest& farm, const WorkerSetup& setup, int count) {
    for (int i = 0; i < count; ++i) {
      support::Process& worker = farm.add_worker(setup);
      if (!worker.wait_for_err("registered with", kPatience))
        throw std::runtime_error{"no worker:\n" + worker.err()};
    }
  }

  /// The class of the workers with this tag; the other worker's is another.
  static std::string class_of(FarmUnderTest& farm, const std::string& tag) {
    std::string found;
    for (const v1::WorkerStatus& worker : workers(farm)) {
      if (worker.tags(0) == tag) found = worker.arithmetic().classes(0);
    }
    return found;
  }

  static std::vector<v1::WorkerStatus> workers(FarmUnderTest& farm) {
    auto workers = farm.client().workers({});
    EXPECT_TRUE(workers.ok()) << workers.status();
    return workers.ok() ? *std::move(workers) : std::vector<v1::WorkerStatus>{};
  }

  static v1::JobStatus end_of(FarmUnderTest& farm, const std::string& job_id) {
    v1::JobStatus end = farm.watch_until(job_id, [](const v1::JobStatus&) { return false; });
    EXPECT_EQ(end.state(), v1::DONE) << end.error();
    return end;
  }

  static client::Image fetch(FarmUnderTest& farm, const std::string& job_id) {
    const std::string path = (farm.directory() / (job_id + ".exr")).string();
    const support::Finished done = tessera(farm.on_farm({"fetch", job_id, "-o", path, "--quiet"}));
    EXPECT_EQ(done.status.code, 0) << done.err;
    auto image = client::read_exr(path);
    EXPECT_TRUE(image.ok()) << image.status();
    return image.ok() ? *std::move(image) : client::Image{};
  }

  static void expect_nobody_in_quarantine(FarmUnderTest& farm) {
    for (const v1::WorkerStatus& worker : workers(farm)) EXPECT_EQ(worker.quarantine(), "") << worker.name();
    EXPECT_THAT(farm.coordinator().err(), Not(HasSubstr("different result")));
  }

  /// Renders the view with both classes and checks tile by tile that each did a part, and what it does alone.
  void expect_tiles_of_both(FarmUnderTest& farm);

  WorkerSetup ours_, theirs_;
};

/// Whether two images have the same bits in all channels of a tile.
bool equal_in_tile(const client::Image& a, const client::Image& b, int tile_x, int tile_y) {
  for (const client::Channel& channel : a.channels) {
    const client::Channel* const other = b.find(channel.name);
    if (other == nullptr) return false;
    for (int y = tile_y * kTile; y < (tile_y + 1) * kTile; ++y) {
      const std::size_t at = std::size_t(y) * std::size_t(a.data.width()) + std::size_t(tile_x) * kTile;
      if (std::memcmp(channel.values.data() + at, other->values.data() + at, kTile * sizeof(float)) != 0)
        return false;
    }
  }
  return true;
}

void TwoClasses::expect_tiles_of_both(FarmUnderTest& farm) {
  const auto same = [&](const std::string& tag) {
    return fetch(farm, farm.submit_detached(kSmallTiles + Arguments{"--bits", "same", "--require", tag}));
  };
  const client::Image ours = same("ours"), theirs = same("theirs");
  const std::string mixed_id = farm.submit_detached(kSmallTiles + Arguments{"--bits", "any"});
  const v1::JobStatus end = end_of(farm, mixed_id);
  EXPECT_EQ(end.units_total(), kUnits);
  EXPECT_THAT(end.arithmetic_classes(),
              UnorderedElementsAre(class_of(farm, "ours"), class_of(farm, "theirs")));
  EXPECT_THAT(end.left_out(), IsEmpty());
  EXPECT_THAT(end.notes(), IsEmpty());
  const client::Image mixed = fetch(farm, mixed_id);

  unsigned of_ours = 0, of_theirs = 0;
  for (int y = 0; y < ours.data.height() / kTile; ++y) {
    for (int x = 0; x < ours.data.width() / kTile; ++x) {
      const bool as_ours = equal_in_tile(mixed, ours, x, y), as_theirs = equal_in_tile(mixed, theirs, x, y);
      EXPECT_TRUE(as_ours || as_theirs) << "tile " << x << ", " << y << " is of neither class";
      if (as_ours && !as_theirs) ++of_ours;
      if (as_theirs && !as_ours) ++of_theirs;
    }
  }
  EXPECT_GT(of_ours, 0U);
  EXPECT_GT(of_theirs, 0U);
}

TEST_F(TwoClasses, SameBitsLeavesOneOutAndSaysSo) {
  FarmUnderTest farm;
  add(farm, theirs_, 1);
  add(farm, ours_, 2);
  const std::string ours = class_of(farm, "ours"), theirs = class_of(farm, "theirs");
  ASSERT_NE(ours, theirs);

  const Arguments view = kView + Arguments{"--spp", "256"};
  const std::string job_id = farm.submit_detached(view + Arguments{"--bits", "same"});
  farm.watch_until(job_id, [](const v1::JobStatus& status) { return status.units_done() > 0; });
  ASSERT_EQ(tessera(farm.on_farm({"pause", job_id})).status.code, 0);  // it must not end meanwhile
  for (const v1::WorkerStatus& worker : workers(farm)) {
    const auto& closed = worker.arithmetic().closed_jobs();
    EXPECT_EQ(std::vector<std::string>(closed.begin(), closed.end()),
              worker.tags(0) == "theirs" ? std::vector{job_id} : std::vector<std::string>{});
  }
  const support::Finished told = tessera(farm.on_farm({"job", job_id}));
  EXPECT_THAT(told.out, HasSubstr("1 worker (1 thread) of class " + theirs));
  EXPECT_THAT(told.out, HasSubstr(ours));
  EXPECT_THAT(tessera(farm.on_farm({"workers"})).out,
              HasSubstr("its arithmetic keeps it from jobs " + job_id));

  ASSERT_EQ(tessera(farm.on_farm({"resume", job_id})).status.code, 0);
  EXPECT_THAT(end_of(farm, job_id).arithmetic_classes(), ElementsAre(ours));
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(view + Arguments{"--isa", ours_.options.back()}));
  for (const v1::WorkerStatus& worker : workers(farm)) {
    if (worker.tags(0) == "theirs") {
      EXPECT_EQ(worker.units_done(), 0U);
    }
  }
}

TEST_F(TwoClasses, AnyBitsTakesTilesOfBothAndAuditsEachByItsOwn) {
  FarmUnderTest farm;
  add(farm, ours_, 2);
  add(farm, theirs_, 2);
  ASSERT_NE(class_of(farm, "ours"), class_of(farm, "theirs"));
  expect_tiles_of_both(farm);
  // One of a hundred of 4800 results is audited, by chance: none of them once in 10^20 runs.
  auto jobs = farm.client().jobs({});
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  unsigned audits = 0;
  for (const v1::JobStatus& job : *jobs) audits += job.audits();
  EXPECT_GT(audits, 0U);
  expect_nobody_in_quarantine(farm);
}

TEST_F(TwoClasses, ALateResultOfTheOtherIsNoFault) {
  FarmUnderTest farm;
  TcpProxy network{std::stoi(farm.address().substr(farm.address().rfind(':') + 1))};
  WorkerSetup cut_off = ours_;
  cut_off.server = network.address();
  add(farm, cut_off, 1);
  const std::string job_id = farm.submit_detached(kSmallTiles + Arguments{"--bits", "any"});
  // It holds units when its results do not come through any more.
  ASSERT_TRUE(farm.worker(0).wait_for_err("rendered", kPatience)) << farm.worker(0).err();
  network.set_fault(TcpProxy::Fault::kSilence);
  add(farm, theirs_, 1);
  end_of(farm, job_id);
  network.set_fault(TcpProxy::Fault::kNone);
  // Once it has rendered another job, all that it had is delivered.
  end_of(farm, farm.submit_detached(kSmallTiles + Arguments{"--bits", "any", "--require", "ours"}));
  EXPECT_THAT(farm.worker(0).err(), Not(HasSubstr("result not taken")));
  expect_nobody_in_quarantine(farm);
}

TEST_F(TwoClasses, TheCoordinatorOfTheOtherBuildServesBoth) {
  const std::string server = other_program("tessera-server");
  if (server.empty()) GTEST_SKIP() << "TESSERA_OTHER_BIN names no other build";
  FarmUnderTest farm{instead(server)};
  add(farm, ours_, 2);
  add(farm, theirs_, 2);
  expect_tiles_of_both(farm);
  expect_nobody_in_quarantine(farm);
}

}  // namespace
}  // namespace tessera::integration
