// An agent from its registration to its end.
#include <gmock/gmock.h>

#include "unit/agent/agent_fixture.h"

namespace tessera::agent {
namespace {

using ::testing::HasSubstr;

using AgentLife = AgentTest;

TEST_F(AgentLife, RegistersAgainWhenTheCoordinatorForgotItAndDeliversWhatItHeld) {
  renderer_.hanging_tiles = {0};
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1);
  wait_for_hanging(1);
  coordinator_.forget_workers();
  renderer_.gate_open = true;
  ASSERT_TRUE(coordinator_.wait_for_results(1));
  EXPECT_EQ(coordinator_.results().at(0).worker_id(), "w2");
  coordinator_.offer("job", spec_for_scene(), 1, 4);
  ASSERT_TRUE(coordinator_.wait_for_results(5));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_EQ(coordinator_.registrations(), 2);
  EXPECT_EQ(renderer_.renders, 5);
}

TEST_F(AgentLife, SaysWhatItHoldsBeforeItAsksANewCoordinator) {
  renderer_.hanging_tiles = {0};
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1);
  wait_for_hanging(1);
  // Long enough for a call that does not wait for it.
  coordinator_.hold_introductions(std::chrono::milliseconds{300});
  coordinator_.forget_workers();
  coordinator_.offer("job", spec_for_scene(), 1, 1);
  ASSERT_TRUE(coordinator_.wait_for_leased(2));
  EXPECT_EQ(coordinator_.early_leases(), 0);
  renderer_.gate_open = true;
  ASSERT_TRUE(coordinator_.wait_for_results(2));
  EXPECT_TRUE(stop_and_join().ok());
}

TEST_F(AgentLife, StoppingFinishesWhatWasBegunAndGivesTheRestBack) {
  renderer_.hanging_tiles = {0};
  coordinator_.offer("job", spec_for_scene(), 0, 2);
  start(1);
  wait_for_hanging(1);
  ASSERT_TRUE(coordinator_.wait_for_leased(2));
  ASSERT_TRUE(coordinator_.wait_for_heartbeat_with(2));
  runner_.request_stop();
  ASSERT_TRUE(coordinator_.wait_for_heartbeat_with(1)) << "the units not begun are still held";
  renderer_.gate_open = true;
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_TRUE(coordinator_.wait_for_deregistration());
  EXPECT_EQ(coordinator_.results().size(), 1U);
  EXPECT_TRUE(coordinator_.results().contains(0));
}

TEST_F(AgentLife, UnitsThatOutlastTheGracePeriodAreStopped) {
  renderer_.hanging_tiles = {0};
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1, std::chrono::milliseconds{20});
  wait_for_hanging(1);
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_TRUE(coordinator_.results().empty());
  EXPECT_TRUE(coordinator_.wait_for_deregistration());
}

TEST_F(AgentLife, DrainsWhenTheCoordinatorAsksForIt) {
  coordinator_.ask_to_drain();
  start(1);
  runner_.join();
  EXPECT_TRUE(status_.ok()) << status_;
  EXPECT_TRUE(coordinator_.wait_for_deregistration());
}

TEST_F(AgentLife, OneThatWasRegisteredOutlivesAnswersToDamagedCalls) {
  start(1);
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  ASSERT_TRUE(coordinator_.wait_for_results(1));
  coordinator_.misread(2);  // two calls of Lease
  coordinator_.offer("job", spec_for_scene(), 1, 1);
  ASSERT_TRUE(coordinator_.wait_for_results(2));
  coordinator_.forget_workers();
  coordinator_.misread(2);  // two calls of Lease or Register
  coordinator_.offer("job", spec_for_scene(), 2, 1);
  ASSERT_TRUE(coordinator_.wait_for_results(3));
  EXPECT_TRUE(stop_and_join().ok());
}

TEST_F(AgentLife, AnAddressThatIsNoCoordinatorsEndsTheRun) {
  coordinator_.misread(1);
  start(1);
  runner_.join();
  EXPECT_EQ(status_.code(), absl::StatusCode::kUnimplemented);
}

TEST_F(AgentLife, ARefusedRegistrationEndsTheRun) {
  coordinator_.refuse_registration("build 0.0.9 does not match 0.1.0");
  start(2);
  runner_.join();
  EXPECT_EQ(status_.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string{status_.message()}, HasSubstr("Register at the fake: build 0.0.9"));
}

}  // namespace
}  // namespace tessera::agent
