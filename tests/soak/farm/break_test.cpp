// `tessera render` that is interrupted, killed, or finds the disk full; and images of jobs that are not done.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "image/exr.h"
#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

Arguments job_of(const std::string& spp) {
  return {"scenes/cornell-box/scene.pbrt",
          "--resolution",
          "96x96",
          "--spp",
          spp,
          "--tile",
          "16",
          "--threads",
          "1",
          "--quiet"};
}

// 36 units of some ten milliseconds each, and of 2.6 kB.
const Arguments kBrokenJob = job_of("256");

std::string text_attribute(const fs::path& exr, const std::string& name) {
  const auto image = client::read_exr(exr.string());
  if (!image.ok() || !image->metadata.contains(name)) return "";
  const auto* const text = std::get_if<std::string>(&image->metadata.at(name));
  return text == nullptr ? "" : *text;
}

class Break : public testing::Test {
 protected:
  Arguments command(const Arguments& more = {}, const Arguments& job = kBrokenJob) const {
    return Arguments{tessera_program(), "render"} + job + Arguments{"-o", output().string()} + more;
  }
  fs::path output() const { return folder_.path() / "out.exr"; }
  fs::path checkpoint() const { return folder_.path() / "checkpoint"; }
  Arguments with_checkpoint() const { return {"--checkpoint", checkpoint().string()}; }

  /// Waits until the job of the checkpoint has results.
  void wait_for_results(std::uint64_t bytes) const {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < deadline) {
      std::uint64_t found = 0;
      std::error_code error;
      for (const auto& entry : fs::directory_iterator(checkpoint() / "results", error)) {
        if (entry.path().extension().empty()) found += entry.file_size(error);
      }
      if (found >= bytes) return;
      std::this_thread::sleep_for(milliseconds(20));
    }
    FAIL() << "no results come";
  }

  support::TempDir folder_;
};

TEST_F(Break, ASignalLeavesAPartialImageThatSaysSo) {
  for (const int signal : {SIGINT, SIGTERM}) {
    fs::remove_all(checkpoint());
    support::Process render(command(with_checkpoint()));
    wait_for_results(20'000);
    render.send_signal(signal);
    const auto ended = render.wait(kPatience);
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->code, 130) << render.err();
    EXPECT_THAT(render.err(), HasSubstr("the image is a partial one"));
    EXPECT_THAT(text_attribute(output(), "tessera.partial"), HasSubstr("units"));
    EXPECT_THAT(text_attribute(output(), "tessera.holes"), HasSubstr("empty"));
    fs::remove(output());
  }
}

TEST_F(Break, WithoutACheckpointToo) {
  const fs::path& image = output();
  support::Process render(command({}, job_of("65536")));
  // There is nothing to be seen of its results until it ends; it renders after a moment.
  std::this_thread::sleep_for(seconds(2));
  render.send_signal(SIGINT);
  const auto ended = render.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, 130) << render.err();
  // On a machine that had not yet begun, nothing is written, and that is said.
  EXPECT_NE(fs::exists(image), render.err().find("nothing was rendered") != std::string::npos)
      << render.err();
}

TEST_F(Break, ARenderGoesOnToTheSameBits) {
  {
    support::Process interrupted(command(with_checkpoint()));
    wait_for_results(20'000);
    interrupted.send_signal(SIGINT);
    ASSERT_TRUE(interrupted.wait(kPatience));
  }
  const auto of_file = [](const fs::directory_entry& entry) { return entry.path().extension().empty(); };
  {
    support::Process killed(command(with_checkpoint()));
    std::uint64_t bytes = 0;
    for (const auto& entry : fs::directory_iterator(checkpoint() / "results")) {
      if (of_file(entry)) bytes += entry.file_size();
    }
    wait_for_results(bytes + 20'000);
    killed.kill();
    ASSERT_TRUE(killed.wait(kPatience));
  }
  const fs::path stats = folder_.path() / "stats.json";
  const support::Finished done =
      support::run_program(command(with_checkpoint() + Arguments{"--stats", stats}), kPatience);
  ASSERT_EQ(done.status.code, 0) << done.err;
  EXPECT_EQ(pixel_sha256(output()), expected_hash(kBrokenJob));
  EXPECT_EQ(text_attribute(output(), "tessera.partial"), "");
  EXPECT_FALSE(fs::exists(checkpoint())) << "it is of no more use";
}

TEST_F(Break, NobodysFolderIsTakenForACheckpoint) {
  fs::create_directories(checkpoint());
  std::ofstream(checkpoint() / "thesis.tex") << "much work";
  const support::Finished refused = support::run_program(command(with_checkpoint()), kPatience);
  EXPECT_EQ(refused.status.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("no checkpoint of a render"));
  EXPECT_TRUE(fs::exists(checkpoint() / "thesis.tex"));
}

TEST_F(Break, WhereTheImageCannotBeWrittenItIsKeptElsewhere) {
  fs::create_symlink("/dev/full", output());  // a disk without room for a byte
  const fs::path home = folder_.path() / "home";
  const std::vector<std::string> environment{"XDG_STATE_HOME=" + home.string()};
  const support::Finished full = support::run_program(command(), kPatience, environment);
  EXPECT_EQ(full.status.code, 6) << full.err;
  EXPECT_THAT(full.err, HasSubstr("out.exr"));
  EXPECT_THAT(full.err, HasSubstr("the image is in " + (home / "tessera").string()));
  ASSERT_TRUE(fs::exists(home / "tessera"));
  for (const auto& entry : fs::directory_iterator(home / "tessera")) {
    EXPECT_EQ(pixel_sha256(entry.path()), expected_hash(kBrokenJob));
  }
}

TEST_F(Break, WithACheckpointTheSameCommandGoesOnWhenThereIsRoom) {
  fs::create_symlink("/dev/full", output());
  const support::Finished full = support::run_program(command(with_checkpoint()), kPatience);
  EXPECT_EQ(full.status.code, 6) << full.err;
  EXPECT_THAT(full.err, HasSubstr("the same command goes on with it"));
  fs::remove(output());
  const fs::path stats = folder_.path() / "stats.json";
  const support::Finished again =
      support::run_program(command(with_checkpoint() + Arguments{"--stats", stats.string()}), kPatience);
  EXPECT_EQ(again.status.code, 0) << again.err;
  EXPECT_EQ(pixel_sha256(output()), expected_hash(kBrokenJob));
  EXPECT_EQ(json_number(stats, "build_seconds"), 0) << "nothing is rendered, so that no scene is built";
}

TEST_F(Break, ACheckpointThatCannotGrowEndsTheRenderByName) {
  // No file may grow beyond 128 kB, which is enough for the tables to be made; the signal that comes with
  // that is ignored, so that the write fails.
  const Arguments limited =
      Arguments{"/bin/bash", "-c", "trap '' XFSZ; ulimit -f 128; exec \"$@\"", "limited"} +
      command(with_checkpoint());
  const support::Finished full = support::run_program(limited, kPatience);
  EXPECT_EQ(full.status.code, 6) << full.err;
  EXPECT_EQ(full.status.signal, 0) << "it hung, or died";
  EXPECT_THAT(full.err, HasSubstr("checkpoint"));
  const support::Finished again = support::run_program(command(with_checkpoint()), kPatience);
  EXPECT_EQ(again.status.code, 0) << again.err;
  EXPECT_EQ(pixel_sha256(output()), expected_hash(kBrokenJob));
}

/// Whether a file system of a given size can be had here.
class SmallDisk {
 public:
  SmallDisk(const fs::path& at, const std::string& size) : at_(at) {
    fs::create_directories(at);
    made_ = support::run_program({"/bin/mount", "-t", "tmpfs", "-o", "size=" + size, "tmpfs", at.string()},
                                 kPatience)
                .status.code == 0;
  }
  ~SmallDisk() {
    if (made_) support::run_program({"/bin/umount", "-l", at_.string()}, kPatience);
  }
  bool made() const { return made_; }

 private:
  fs::path at_;
  bool made_;
};

TEST_F(Break, AFullDiskIsSaidAndTheImageIsKeptElsewhere) {
  const SmallDisk disk(folder_.path() / "small", "64k");
  if (!disk.made()) GTEST_SKIP() << "needs root to mount a small disk";
  const fs::path image = folder_.path() / "small" / "out.exr", home = folder_.path() / "home";
  Arguments to_small = Arguments{"render"} + kBrokenJob + Arguments{"-o", image.string()};
  const std::vector<std::string> environment{"XDG_STATE_HOME=" + home.string()};
  const support::Finished full =
      support::run_program(Arguments{tessera_program()} + to_small, kPatience, environment);
  EXPECT_EQ(full.status.code, 6) << full.err;
  EXPECT_THAT(full.err, HasSubstr("the image is in " + (home / "tessera").string()));
  EXPECT_FALSE(fs::exists(image));
  ASSERT_TRUE(fs::exists(home / "tessera"));
  for (const auto& entry : fs::directory_iterator(home / "tessera")) {
    EXPECT_EQ(pixel_sha256(entry.path()), expected_hash(kBrokenJob));
  }
}

TEST_F(Break, AnImageOfWhatThereIs) {
  FarmUnderTest farm;
  farm.add_worker(1);
  const Arguments job{
      "scenes/cornell-box/scene.pbrt", "--resolution", "96x96", "--spp", "16384", "--tile", "16"};
  const std::string id = farm.submit_detached(job);
  farm.watch_until(id, [](const v1::JobStatus& status) { return status.units_done() >= 3; });
  const Arguments fetch{"fetch", id, "--partial", "-o", output().string(), "--quiet"};
  const support::Finished running = tessera(farm.on_farm(fetch));
  EXPECT_EQ(running.status.code, 6) << running.err;
  EXPECT_THAT(text_attribute(output(), "tessera.partial"), HasSubstr(" of "));
  fs::remove(output());

  ASSERT_EQ(tessera(farm.on_farm({"cancel", id})).status.code, 0);
  const support::Finished cancelled = tessera(farm.on_farm(fetch));
  EXPECT_EQ(cancelled.status.code, 5) << cancelled.err;
  EXPECT_THAT(text_attribute(output(), "tessera.partial"), HasSubstr(" of "));
}

}  // namespace
}  // namespace tessera::integration
