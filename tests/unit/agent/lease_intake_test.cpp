#include "agent/lease_intake.h"

#include <gtest/gtest.h>

namespace tessera::agent {
namespace {

class LeaseIntakeTest : public ::testing::Test {
 protected:
  /// The coordinator grants units of `count` jobs, of which `first` is the first, with their specs.
  void answer_with_jobs(std::size_t first, std::size_t count) {
    v1::LeaseRequest request;
    const LeaseIntake::Ask ask = intake_.ask(request);
    v1::LeaseResponse response;
    for (std::size_t i = first; i < first + count; ++i) {
      const std::string job = "job " + std::to_string(i);
      response.add_leases()->mutable_token()->set_job_id(job);
      (*response.mutable_specs())[job];
    }
    intake_.answered(ask, &response);
  }

  std::set<std::string> known() {
    v1::LeaseRequest request;
    intake_.answered(intake_.ask(request), nullptr);
    return {request.known_job_ids().begin(), request.known_job_ids().end()};
  }

  LeaseTable leases_{base::machine_clock()};
  std::vector<std::string> forgotten_;
  LeaseIntake intake_{leases_,
                      {.scene_digests = [] { return std::vector<std::string>{}; },
                       .forget_job = [this](const std::string& job) { forgotten_.push_back(job); }},
                      "coordinator:1",
                      1000};
};

TEST_F(LeaseIntakeTest, AJobWhoseSpecIsForgottenIsForgottenWhole) {
  // The coordinator tells of known jobs alone that they are over, so nothing of the others may be kept.
  answer_with_jobs(0, LeaseIntake::kKnownJobs);
  EXPECT_TRUE(forgotten_.empty());
  EXPECT_EQ(known().size(), LeaseIntake::kKnownJobs);
  answer_with_jobs(LeaseIntake::kKnownJobs, 2);
  EXPECT_EQ(forgotten_, (std::vector<std::string>{"job 0", "job 1"}));
  EXPECT_EQ(known().size(), LeaseIntake::kKnownJobs);
  EXPECT_FALSE(known().contains("job 0"));
}

TEST_F(LeaseIntakeTest, AJobThatIsOverIsForgotten) {
  answer_with_jobs(0, 2);
  v1::LeaseRequest request;
  const LeaseIntake::Ask ask = intake_.ask(request);
  v1::LeaseResponse response;
  response.add_over_job_ids("job 1");
  intake_.answered(ask, &response);
  EXPECT_EQ(forgotten_, std::vector<std::string>{"job 1"});
  EXPECT_EQ(known(), std::set<std::string>{"job 0"});
}

}  // namespace
}  // namespace tessera::agent
