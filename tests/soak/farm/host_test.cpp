// Hosts that fail: full and read-only disks, too little memory, units that kill their worker.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::Not;

const Arguments kHostJob = in_many_units("160", "64", "8");

/// A shell's limits for a program; what the kernel would kill it for is an error instead.
Arguments limited(const std::string& limit) {
  return {"/bin/bash", "-c", "trap '' XFSZ; ulimit " + limit + "; exec \"$@\"", "limited"};
}

v1::JobStatus end_of(FarmUnderTest& farm, const std::string& job_id) {
  return farm.watch_until(job_id, [](const v1::JobStatus&) { return false; });
}

std::string notes_of(const v1::JobStatus& status) {
  std::string notes;
  for (const std::string& note : status.notes()) notes += note + '\n';
  return notes;
}

TEST(Host, AFullDiskEndsTheCoordinatorByNameAndNothingIsLost) {
  const support::TempDir settings;
  const std::string limit = (settings.path() / "limit").string();
  // In KiB: the journal has room, the results of the whole job have not.
  std::ofstream{limit} << "150\n";
  FarmUnderTest farm{limited("-f $(cat " + limit + ")")};
  farm.add_worker(2);
  const std::string job_id = farm.submit_detached(kHostJob);
  const std::optional<support::ExitStatus> ended = farm.coordinator().wait(kPatience);
  ASSERT_TRUE(ended) << "it goes on without a disk";
  EXPECT_EQ(ended->code, 5) << ended->signal;
  EXPECT_THAT(farm.coordinator().err(), HasSubstr("nothing more is acknowledged"));
  const std::uint64_t before = [&] {
    std::ofstream{limit} << "unlimited\n";
    farm.restart_coordinator();
    const auto job = farm.client().job(job_id, {});
    EXPECT_TRUE(job.ok()) << job.status();
    return job.ok() ? job->status().units_done() : 0;
  }();
  EXPECT_GT(before, 0U) << "what was acknowledged is there";
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kHostJob))
      << farm.coordinator().err() << farm.worker(0).err();
}

TEST(Host, AFullDiskOfAClientIsNamedAndTheImageFetchedLater) {
  FarmUnderTest farm;
  farm.add_worker(2);
  const std::string job_id = farm.submit_detached(kHostJob);
  const std::filesystem::path image = farm.directory() / "image.exr";
  const support::Finished full = support::run_program(
      limited("-f 4") + farm.on_farm({tessera_program(), "fetch", job_id, "-o", image.string(), "--quiet"}),
      kPatience);
  EXPECT_GT(full.status.code, 0) << full.status.signal;
  EXPECT_THAT(full.err, HasSubstr("image.exr"));
  EXPECT_FALSE(std::filesystem::exists(image));
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kHostJob));
}

TEST(Host, OneWhoseCacheIsFullIsTakenOutAndSaysWhy) {
  FarmUnderTest farm;
  farm.add_worker(WorkerSetup{.name = "full", .wrapper = limited("-f 0")});
  const std::string job_id = farm.submit_detached(kHostJob);
  ASSERT_TRUE(farm.worker(0).wait_for_err("the disk is full", kPatience)) << farm.worker(0).err();
  farm.add_worker(1);
  const v1::JobStatus end = end_of(farm, job_id);
  // Before there was another host, three of its failures may have set a unit aside.
  if (end.state() != v1::DONE) {
    EXPECT_THAT(end.error(), HasSubstr("the disk is full"));
    farm.kill_worker(0);
    EXPECT_EQ(farm.fetch_hash(farm.submit_detached(kHostJob)), expected_hash(kHostJob));
    return;
  }
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kHostJob));
}

TEST(Host, AReadOnlyCacheIsNamedAndOthersDoTheWork) {
  const support::TempDir directory;
  const std::string cache = (directory.path() / "cache").string();
  std::filesystem::create_directories(cache + "/partial");
  const Arguments read_only{
      "/usr/bin/unshare",
      "-m",
      "/bin/bash",
      "-c",
      "mount --bind " + cache + " " + cache + " && mount -o remount,bind,ro " + cache + " && exec \"$@\"",
      "read-only"};
  if (support::run_program(read_only + Arguments{"/bin/true"}, kPatience).status.code != 0) {
    GTEST_SKIP() << "this user cannot mount";
  }
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(WorkerSetup{.name = "read-only", .cache = cache, .wrapper = read_only});
  const std::string job_id = farm.submit_detached(kHostJob);
  const v1::JobStatus end = end_of(farm, job_id);
  EXPECT_EQ(end.state(), v1::DONE) << end.error();
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kHostJob));
  ASSERT_TRUE(farm.worker(1).wait_for_err("Read-only file system", kPatience)) << farm.worker(1).err();
  EXPECT_THAT(notes_of(end), HasSubstr("host read-only was taken out"));
}

/// From now on, the process gets so many bytes more, and then no more.
void allow_only(pid_t process, rlim_t bytes) {
  std::ifstream pages{"/proc/" + std::to_string(process) + "/statm"};
  rlim_t size = 0;
  pages >> size;
  const rlim_t limit = size * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + bytes;
  const rlimit both{.rlim_cur = limit, .rlim_max = limit};
  ASSERT_TRUE(size > 0 && ::prlimit(process, RLIMIT_AS, &both, nullptr) == 0);
}

TEST(Host, OneWithoutMemoryLeavesTheWorkToOthers) {
  // Tiles whose results need 15 MB each, and as much for each copy.
  const Arguments large{
      "scenes/cornell-box/scene.pbrt", "--resolution", "1024x1024", "--spp", "1", "--tile", "512", "--aov",
      "variance,albedo,normal,depth",  "--quiet"};
  FarmUnderTest farm;
  // Both are there from the start: a unit is tried thrice by one who is alone, and then set aside.
  farm.add_worker(1);
  support::Process& small = farm.add_worker(WorkerSetup{.name = "small"});
  for (std::size_t i = 0; i < 2; ++i) ASSERT_TRUE(farm.worker(i).wait_for_err("registered with", kPatience));
  allow_only(small.id(), 8 << 20);
  const std::string job_id = farm.submit_detached(large);
  const v1::JobStatus end = end_of(farm, job_id);
  EXPECT_EQ(end.state(), v1::DONE) << end.error();
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(large));
  EXPECT_THAT(small.err(), HasSubstr(" leased"));
  EXPECT_THAT(small.err(), Not(HasSubstr(" rendered")));
}

TEST(Host, AUnitThatKillsItsWorkersIsSetAsideMarkedAndRetried) {
  // Units of half a second, so that it is known who holds which: with noise, a unit takes all samples of its
  // tile.
  const Arguments slow{"scenes/cornell-box/scene.pbrt",
                       "--resolution",
                       "64x64",
                       "--spp",
                       "2048",
                       "--noise",
                       "0.0001",
                       "--tile",
                       "16",
                       "--quiet"};
  FarmUnderTest farm;
  for (int i = 0; i < 3; ++i) farm.add_worker(1);
  const std::string job_id = farm.submit_detached(slow);
  std::atomic<bool> over = false;
  int kills = 0;
  // Processes die with the thread that started them: workers are started by this one, and watched from
  // another.
  v1::JobStatus end;
  std::jthread watching([&](std::stop_token) {
    const auto status = farm.new_client()->watch(job_id, {}, {});
    EXPECT_TRUE(status.ok()) << status.status();
    if (status.ok()) end = *status;
    over = true;
  });
  const std::string poison = "unit 7 of job " + job_id + " leased";
  while (!over) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (farm.worker(i).err().find(poison) == std::string::npos) continue;
      farm.kill_worker(i);
      farm.restart_worker(i);
      ++kills;
    }
    std::this_thread::sleep_for(milliseconds{10});
  }
  watching.join();
  ASSERT_EQ(end.state(), v1::INCOMPLETE) << end.error();
  EXPECT_THAT(end.error(), HasSubstr("unit 7 failed"));
  ASSERT_EQ(end.set_aside_size(), 1);
  EXPECT_EQ(end.set_aside(0).unit().index(), 7U);
  // Three hosts must have lost it. One may lose it again while the others start.
  EXPECT_GE(kills, 3);
  EXPECT_LE(kills, 9);

  const std::filesystem::path image = farm.directory() / "hole.exr";
  const support::Finished holed = tessera(farm.on_farm({"fetch", job_id, "-o", image.string(), "--quiet"}));
  EXPECT_NE(holed.status.code, 0);
  EXPECT_THAT(holed.err, HasSubstr("tessera retry " + job_id));
  EXPECT_TRUE(std::filesystem::exists(image));
  EXPECT_NE(pixel_sha256(image), expected_hash(slow));
  EXPECT_EQ(tessera(farm.on_farm({"retry", job_id})).status.code, 0);
  EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(slow)) << "now that nothing kills";
}

TEST(Host, AUnitThatTakesTooLongIsSetAside) {
  FarmUnderTest farm;
  farm.add_worker({.options = {"--unit-limit", "2"}});
  // Adaptive, so that a unit has all samples of its tile: 512x512 pixels, some 15 s of work, beside 8x512, a
  // quarter of a second. The large one is tried three times.
  const std::filesystem::path image = farm.directory() / "holes.exr";
  const support::Finished done =
      tessera(farm.on_farm({"submit", "scenes/cornell-box/scene.pbrt", "--resolution", "520x512", "--noise",
                            "0.0001", "--spp", "64", "--tile", "512", "--quiet", "-o", image.string()}));
  EXPECT_EQ(done.status.code, 7) << done.err;
  EXPECT_NE(done.err.find("longer than 2 s, the worker's --unit-limit"), std::string::npos) << done.err;
  EXPECT_TRUE(std::filesystem::exists(image));
}

}  // namespace
}  // namespace tessera::integration
