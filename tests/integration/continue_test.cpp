// More samples for a finished job, and the same job again.
#include <gtest/gtest.h>

#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

constexpr double kPixels = 72 * 56;

class Continue : public testing::Test {
 protected:
  void SetUp() override {
    farm_.add_worker(1);
    farm_.add_worker(1);
  }

  std::string submit(const std::string& spp, const Arguments& more = {}) {
    Arguments arguments{
        "scenes/cornell-box/scene.pbrt", "--resolution", "72x56", "--spp", spp, "--aov", "variance"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return farm_.submit_detached(arguments);
  }

  double samples_of(const std::string& job_id) {
    const auto job = farm_.client().job(job_id, {});
    EXPECT_TRUE(job.ok()) << job.status();
    return job.ok() ? static_cast<double>(job->status().stats().samples()) : 0;
  }

  FarmUnderTest farm_;
};

TEST_F(Continue, RendersTheMissingSamplesOnlyAndGivesTheSameBits) {
  const std::string rough = submit("16");
  farm_.fetch_hash(rough);
  EXPECT_EQ(samples_of(rough), 16 * kPixels);
  const std::string fine = submit("64", {"--continue", rough});
  const std::string hash = farm_.fetch_hash(fine);
  EXPECT_EQ(samples_of(fine), 48 * kPixels);
  const std::string at_once = submit("64", {"--fresh"});
  EXPECT_EQ(farm_.fetch_hash(at_once), hash);
  EXPECT_EQ(samples_of(at_once), 64 * kPixels);
}

TEST_F(Continue, TheSameJobAgainRendersNothingEvenAfterACrash) {
  const std::string first = submit("16");
  const std::string hash = farm_.fetch_hash(first);
  const std::string second = submit("16");
  EXPECT_EQ(farm_.fetch_hash(second), hash);
  EXPECT_EQ(samples_of(second), 0);
  farm_.kill_and_restart_coordinator();
  const std::string third = submit("16");
  for (const std::string& job : {second, third}) {
    EXPECT_EQ(farm_.fetch_hash(job), hash);
    EXPECT_EQ(samples_of(job), 0);
  }
}

TEST_F(Continue, WithNoiseTheSameJobRendersNothingAndAnotherCapIsRefusedByName) {
  const std::string first = submit("64", {"--noise", "0.2"});
  const std::string hash = farm_.fetch_hash(first);
  const std::string second = submit("64", {"--noise", "0.2", "--continue", first});
  EXPECT_EQ(farm_.fetch_hash(second), hash);
  EXPECT_EQ(samples_of(second), 0);
  const support::Finished other =
      tessera(farm_.on_farm({"submit", "scenes/cornell-box/scene.pbrt", "--resolution", "72x56", "--spp",
                             "128", "--aov", "variance", "--noise", "0.2", "--continue", first, "--detach"}));
  EXPECT_EQ(other.status.code, 4) << "the coordinator refuses";
  EXPECT_NE(other.err.find("samples.spp: 64 -> 128"), std::string::npos) << other.err;
}

TEST_F(Continue, AnotherSceneOrSettingIsRefusedByName) {
  const std::string first = submit("16");
  farm_.fetch_hash(first);
  const support::Finished other = tessera(
      farm_.on_farm({"submit", "scenes/cornell-box/scene.pbrt", "--resolution", "72x56", "--spp", "32",
                     "--aov", "variance", "--max-depth", "2", "--continue", first, "--detach"}));
  EXPECT_EQ(other.status.code, 4) << "the coordinator refuses";
  EXPECT_NE(other.err.find("view.max_depth: 63 -> 2"), std::string::npos) << other.err;
  const support::Finished nobody = tessera(farm_.on_farm(
      {"submit", "scenes/cornell-box/scene.pbrt", "--spp", "32", "--continue", "nothing", "--detach"}));
  EXPECT_EQ(nobody.status.code, 2);
  EXPECT_NE(nobody.err.find("there is no job nothing"), std::string::npos) << nobody.err;
}

}  // namespace
}  // namespace tessera::integration
