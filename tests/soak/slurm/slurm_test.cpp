// deploy/slurm on a real Slurm: pictures have the same bits, whatever is killed, preempted or requeued.
#include "soak/slurm/slurm_cluster.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <thread>

#include "absl/strings/str_cat.h"
#include "integration/farm_under_test.h"
#include "support/needs.h"

namespace tessera::cluster {
namespace {

using integration::Arguments;
using integration::operator+;
using std::chrono::seconds;

// A few seconds on four threads of one machine. Neighbours that share light would render the borders of such
// small tiles four times over.
const Arguments kScene{"scenes/first-light/scene.textproto"};
const Arguments kOptions{"--resolution", "320x180", "--spp", "512", "--tile", "16", "--path-sharing", "off"};
constexpr seconds kPatience{120};

class Slurm : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (SlurmCluster::missing().empty()) cluster_ = std::make_unique<SlurmCluster>();
  }
  static void TearDownTestSuite() { cluster_.reset(); }
  void SetUp() override {
    if (cluster_ == nullptr)
      GTEST_SKIP() << test::needs("Slurm (slurm-wlm, munge): " + SlurmCluster::missing());
  }

  std::filesystem::path path(const std::string& name) const { return directory_.path() / name; }
  std::string log() const {
    std::ifstream in(path("log"));
    return {std::istreambuf_iterator<char>(in), {}};
  }
  bool logged(const std::string& text) const { return log().find(text) != std::string::npos; }

  /// sbatch of a script of deploy/slurm, its output in the file `log`; `programs` is where Tessera's are.
  std::string submit(std::vector<std::string> options, const std::string& script, Arguments arguments,
                     const std::filesystem::path& programs =
                         std::filesystem::path(integration::tessera_program()).parent_path()) const {
    options.insert(options.end(),
                   {absl::StrCat("--output=", path("log").string()), "deploy/slurm/" + script});
    options.insert(options.end(), arguments.begin(), arguments.end());
    return cluster_->submit(std::move(options),
                            {absl::StrCat("PATH=", programs.string(), ":", std::getenv("PATH")),
                             "TMPDIR=" + path("disk").string()});
  }
  std::string submit_picture() const {
    return submit({}, "render.sbatch", kScene + Arguments{path("out.exr").string()} + kOptions);
  }

  /// False when it does not within kPatience.
  bool wait_until(const std::function<bool()>& so) const {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (!so()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds{50});
    }
    return true;
  }
  /// Waits until there are results in the coordinator's state; false when the job ends without.
  bool wait_for_results(const std::string& job) const {
    bool found = false;
    return wait_until([&] {
             std::error_code error;
             for (std::filesystem::recursive_directory_iterator
                      file(path("out.exr.state/data/results"), error),
                  end;
                  file != end && !error; file.increment(error)) {
               // Beside each job's results stands a log of it, JOB.log.
               found |= file->is_regular_file(error) && file->path().extension().empty() &&
                        file->file_size(error) > 0;
             }
             return found || cluster_->is_over(job);
           }) &&
           found;
  }

  /// Processes of this test, by its directory on their command lines.
  std::vector<std::string> processes(const std::string& program) const {
    const support::Finished found =
        support::run_program({"/usr/bin/pgrep", "-f", program + " .*" + path("").string()}, kPatience);
    std::vector<std::string> ids;
    for (std::size_t at = 0, end; (end = found.out.find('\n', at)) != std::string::npos; at = end + 1) {
      ids.push_back(found.out.substr(at, end - at));
    }
    return ids;
  }

  void expect_picture(const std::string& job) {
    const std::optional<JobEnd> end = cluster_->wait_for_end(job, kPatience);
    ASSERT_TRUE(end) << log();
    EXPECT_EQ(end->state, "COMPLETED") << log();
    EXPECT_EQ(end->exit_code, 0) << log();
    EXPECT_EQ(integration::pixel_sha256(path("out.exr")), integration::expected_hash(kScene + kOptions));
    EXPECT_TRUE(processes("tessera").empty()) << "still running";
  }

  static inline std::unique_ptr<SlurmCluster> cluster_;
  support::TempDir directory_;
};

TEST_F(Slurm, RendersAPictureOnTwoNodes) {
  const std::string job = submit_picture();
  expect_picture(job);
  EXPECT_TRUE(std::filesystem::exists(path("out.exr.state/tls/server/certificate.pem"))) << "encrypted";
}

TEST_F(Slurm, AWorkerThatIsKilledIsStartedAgain) {
  const std::string job = submit_picture();
  ASSERT_TRUE(wait_for_results(job)) << log();
  const std::vector<std::string> workers = processes("tessera-worker");
  ASSERT_FALSE(workers.empty());
  ASSERT_EQ(::kill(std::stoi(workers.front()), SIGKILL), 0);
  expect_picture(job);
  EXPECT_TRUE(logged("(try 1 of 5)"));
}

TEST_F(Slurm, ACoordinatorThatIsKilledIsStartedAgain) {
  const std::string job = submit_picture();
  ASSERT_TRUE(wait_for_results(job)) << log();
  const std::vector<std::string> coordinators = processes("tessera-server");
  ASSERT_EQ(coordinators.size(), 1U);
  ASSERT_EQ(::kill(std::stoi(coordinators.front()), SIGKILL), 0);
  expect_picture(job);
  EXPECT_TRUE(logged("it is started again"));
}

TEST_F(Slurm, ARequeuedJobGoesOn) {
  const std::string job = submit_picture();
  ASSERT_TRUE(wait_for_results(job)) << log();
  cluster_->run({"scontrol", "requeue", job});
  ASSERT_TRUE(wait_until([&] { return cluster_->state_of(job) == "PENDING"; }));
  EXPECT_FALSE(std::filesystem::exists(path("out.exr"))) << "requeued too late for this test";
  expect_picture(job);
  EXPECT_TRUE(logged("are taken over")) << log();
}

/// Slurm sends SIGTERM to the script a minute before the time limit.
TEST_F(Slurm, AfterTheTimeLimitTheSameCommandGoesOn) {
  const std::string job = submit_picture();
  ASSERT_TRUE(wait_for_results(job)) << log();
  cluster_->run({"scancel", "--batch", "--signal=TERM", job});
  const std::optional<JobEnd> end = cluster_->wait_for_end(job, kPatience);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 143);
  EXPECT_FALSE(std::filesystem::exists(path("out.exr"))) << "stopped too late for this test";
  EXPECT_TRUE(processes("tessera").empty()) << "still running";
  expect_picture(submit_picture());
  EXPECT_TRUE(logged("are taken over")) << log();
}

TEST_F(Slurm, WithoutAWorkerTheJobFailsAndSaysSo) {
  std::filesystem::create_directory(path("bin"));
  for (const std::string& program : {integration::tessera_program(), integration::server_program()}) {
    std::filesystem::create_symlink(program, path("bin") / std::filesystem::path(program).filename());
  }
  std::ofstream(path("bin/tessera-worker")) << "#!/bin/sh\necho this machine cannot >&2\nexit 70\n";
  std::filesystem::permissions(path("bin/tessera-worker"), std::filesystem::perms::owner_all);
  const std::string job =
      submit({}, "render.sbatch", kScene + Arguments{path("out.exr").string()} + kOptions, path("bin"));
  const std::optional<JobEnd> end = cluster_->wait_for_end(job, kPatience);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->state, "FAILED");
  EXPECT_EQ(end->exit_code, 1);
  EXPECT_TRUE(logged("no worker is left")) << log();
  EXPECT_TRUE(logged("this machine cannot"));
}

TEST_F(Slurm, PreemptedWorkersAreRequeuedAndTakePartAgain) {
  integration::FarmUnderTest farm;
  const std::string workers = submit({"--array=1-2", "--exclusive"}, "worker.sbatch", {farm.address()});
  const std::string job = farm.submit_detached(kScene + kOptions + Arguments{"--quiet"});
  farm.watch_until(job, [](const v1::JobStatus& status) { return status.units_done() > 0; });
  const std::string intruder = cluster_->submit(
      {"--partition=high", "--nodes=2", "--exclusive", "--output=/dev/null", "--wrap=sleep 1"}, {});
  ASSERT_TRUE(wait_until([&] { return cluster_->state_of(workers + "_1") == "PENDING"; })) << log();
  EXPECT_LT(farm.client().job(job, {})->status().units_done(),
            farm.client().job(job, {})->status().units_total())
      << "preempted too late for this test";
  EXPECT_EQ(farm.fetch_hash(job), integration::expected_hash(kScene + kOptions));
  EXPECT_EQ(cluster_->wait_for_end(intruder, kPatience)->state, "COMPLETED");
  cluster_->run({"scancel", workers});
}

}  // namespace
}  // namespace tessera::cluster
