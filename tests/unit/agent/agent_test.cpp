// Units on their way through the agent.
#include <gmock/gmock.h>

#include "unit/agent/agent_fixture.h"

namespace tessera::agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(AgentTest, RendersEveryUnitOnceOnOneLoadedScene) {
  coordinator_.offer("job", spec_for_scene(), 0, 40);
  start(3);
  ASSERT_TRUE(coordinator_.wait_for_results(40));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_EQ(renderer_.loads, 1);
  EXPECT_EQ(renderer_.renders, 40);
  for (const auto& [index, request] : coordinator_.results()) {
    const auto result = wire::decode_tile_result(request.payload());
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->x0, 4 * index);
    EXPECT_EQ(result->values.front(), static_cast<float>(4 * index));
    EXPECT_EQ(request.stats().samples(), 16U);
    EXPECT_EQ(request.stats().warnings_size(), index == 0 ? 1 : 0);
  }
  EXPECT_EQ(agent_->report().units_rendered, 40U);
  EXPECT_TRUE(coordinator_.wait_for_deregistration());
}

TEST_F(AgentTest, AResultBringsTheNextUnits) {
  coordinator_.offer("job", spec_for_scene(), 0, 100);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_results(100));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_EQ(renderer_.renders, 100);
  // When the renderer has done what is queued before a result is answered, there is a call now and then.
  EXPECT_LT(coordinator_.granting_leases(), 50);
}

TEST_F(AgentTest, AHeartbeatThatIsDueSoonGoesWithAResult) {
  coordinator_.set_heartbeat_interval(std::chrono::milliseconds{200});
  coordinator_.revoke_with_result(0);
  renderer_.hanging_tiles = {0};
  const v1::JobSpec spec = spec_for_scene();
  coordinator_.offer("job", spec, 0, 1);
  start(2);
  wait_for_hanging(1);
  // Only the answer to a result's heartbeat stops the unit that hangs.
  for (std::uint32_t results = 0; !agent_->report().units_stopped;) {
    coordinator_.offer("job", spec, 1 + results, 1);
    ASSERT_TRUE(coordinator_.wait_for_results(++results));
  }
  EXPECT_TRUE(stop_and_join().ok());
  const std::map<std::uint32_t, v1::CompleteRequest> sent = coordinator_.results();
  EXPECT_FALSE(sent.contains(0));
  const auto beats = std::count_if(sent.begin(), sent.end(), [](const auto& entry) {
    const v1::CompleteRequest& request = entry.second;
    for (const v1::LeaseToken& token : request.beat().leases()) {
      EXPECT_NE(token.unit_index(), request.token().unit_index()) << "a unit that goes home is not held";
    }
    return request.has_beat();
  });
  EXPECT_GE(beats, 1);
}

TEST_F(AgentTest, AHeartbeatThatIsNotDueGoesWithNoResult) {
  coordinator_.set_heartbeat_interval(std::chrono::hours{1});
  coordinator_.offer("job", spec_for_scene(), 0, 20);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_heartbeat_with(0)) << "the one after the registration";
  ASSERT_TRUE(coordinator_.wait_for_results(20));
  EXPECT_TRUE(stop_and_join().ok());
  for (const auto& [unit, request] : coordinator_.results()) EXPECT_FALSE(request.has_beat()) << unit;
}

TEST_F(AgentTest, UnitsThatNobodyAskedForAreRenderedToo) {
  coordinator_.be_generous();
  coordinator_.offer("job", spec_for_scene(), 0, 40);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_results(40));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_EQ(renderer_.renders, 40);
}

TEST_F(AgentTest, KeepsAResultUntilItIsAcknowledged) {
  coordinator_.fail_completes(3);
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_results(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_EQ(renderer_.renders, 1);
  EXPECT_EQ(coordinator_.completes(), 4U);
}

TEST_F(AgentTest, AResultThatSufferedOnItsWayIsSentAgain) {
  coordinator_.fail_completes(1, grpc::StatusCode::INVALID_ARGUMENT);
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_results(1));
  EXPECT_EQ(coordinator_.completes(), 2U);
  EXPECT_TRUE(coordinator_.failures().empty());
}

TEST_F(AgentTest, AResultThatIsRefusedTwiceIsAFailureOfTheUnit) {
  coordinator_.fail_completes(2, grpc::StatusCode::INVALID_ARGUMENT);
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_failures(1));
  EXPECT_NE(coordinator_.failures()[0].message().find("on request"), std::string::npos);
  EXPECT_TRUE(coordinator_.results().empty());
}

TEST_F(AgentTest, ARevokedUnitStopsAndIsNotReported) {
  renderer_.hanging_tiles = {0};
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1);
  wait_for_hanging(1);
  coordinator_.revoke(0);
  coordinator_.offer("job", spec_for_scene(), 1, 1);
  ASSERT_TRUE(coordinator_.wait_for_results(1)) << "the only render thread did not come free";
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_FALSE(coordinator_.results().contains(0));
  EXPECT_TRUE(coordinator_.failures().empty());
}

TEST_F(AgentTest, AUnitThatTakesTooLongIsReportedAndMayComeBack) {
  renderer_.hanging_tiles = {0};
  const v1::JobSpec spec = spec_for_scene();
  coordinator_.offer("job", spec, 0, 1);
  start(1, std::chrono::seconds{10}, /*unit_limit=*/std::chrono::milliseconds{20});
  ASSERT_TRUE(coordinator_.wait_for_failures(1));
  EXPECT_EQ(coordinator_.failures()[0].token().unit_index(), 0U);
  EXPECT_FALSE(coordinator_.failures()[0].scene_fault());
  EXPECT_THAT(coordinator_.failures()[0].message(), HasSubstr("longer than 1 s, the worker's --unit-limit"));
  coordinator_.offer("job", spec, 0, 1);
  ASSERT_TRUE(coordinator_.wait_for_failures(2));
  coordinator_.offer("job", spec, 1, 1);
  ASSERT_TRUE(coordinator_.wait_for_results(1)) << "the only render thread did not come free";
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_EQ(agent_->report().units_failed, 2U);
  EXPECT_EQ(agent_->report().units_stopped, 0U);
}

TEST_F(AgentTest, AUnitWithATimeLimitIsStillCalledBack) {
  renderer_.hanging_tiles = {0};
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1, std::chrono::seconds{10}, /*unit_limit=*/std::chrono::hours{1});
  wait_for_hanging(1);
  coordinator_.revoke(0);
  coordinator_.offer("job", spec_for_scene(), 1, 1);
  ASSERT_TRUE(coordinator_.wait_for_results(1)) << "the only render thread did not come free";
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_TRUE(coordinator_.failures().empty());
}

TEST_F(AgentTest, ABadSceneIsReportedAsTheScenesFault) {
  renderer_.load_error = absl::InvalidArgumentError("shape 3 (lamp): material 'x' does not exist");
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_failures(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_TRUE(coordinator_.failures()[0].scene_fault());
  EXPECT_THAT(coordinator_.failures()[0].message(), HasSubstr("material 'x'"));
  EXPECT_THAT(coordinator_.failures()[0].log(), testing::ElementsAre("the last of job"));
}

TEST_F(AgentTest, AnyOtherFailureIsNotTheScenesFault) {
  renderer_.load_error = absl::ResourceExhaustedError("out of memory");
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_failures(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_FALSE(coordinator_.failures()[0].scene_fault());
}

TEST_F(AgentTest, ASettingOfANewerVersionFailsTheUnitByName) {
  v1::JobSpec spec = spec_for_scene();
  spec.mutable_content()->mutable_algorithms()->set_traversal(static_cast<v1::Traversal>(9));
  coordinator_.offer("job", spec, 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_failures(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_TRUE(coordinator_.failures()[0].scene_fault()) << "no worker of this version can";
  EXPECT_THAT(coordinator_.failures()[0].message(), HasSubstr("traversal is number 9"));
}

TEST_F(AgentTest, AMissingBlobFailsTheUnit) {
  v1::JobSpec spec = spec_for_scene();
  spec.mutable_farm()->add_blobs()->set_digest(std::string(64, 'a'));
  coordinator_.offer("job", spec, 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_failures(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_FALSE(coordinator_.failures()[0].scene_fault());
  EXPECT_THAT(coordinator_.failures()[0].message(), HasSubstr("no such blob"));
}

TEST_F(AgentTest, WhatTheBuilderDoesNotAskForIsNotFetched) {
  v1::JobSpec spec = spec_for_scene();
  spec.mutable_farm()->add_blobs()->set_digest(std::string(64, 'a'));
  renderer_.needs_blobs = false;
  coordinator_.offer("job", spec, 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_results(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_TRUE(coordinator_.failures().empty());
}

TEST_F(AgentTest, ACorruptDownloadIsRepeatedFromTheStart) {
  coordinator_.offer("job", spec_for_scene(/*corrupt_downloads=*/1), 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_results(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_THAT(coordinator_.download_offsets(), ElementsAre(0, 0));
}

TEST_F(AgentTest, ABrokenDownloadGoesOnWhereItBroke) {
  coordinator_.offer("job", spec_for_scene(/*corrupt_downloads=*/0, /*break_after=*/1), 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_results(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_THAT(coordinator_.download_offsets(), ElementsAre(0, 1000));
}

TEST_F(AgentTest, ACachedSceneIsNotDownloadedAgain) {
  const v1::JobSpec spec = spec_for_scene();
  coordinator_.offer("first", spec, 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_results(1));
  EXPECT_TRUE(stop_and_join().ok());
  coordinator_.offer("second", spec, 1, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_results(2));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_EQ(renderer_.loads, 2);
  EXPECT_EQ(coordinator_.download_offsets().size(), 1U);
  EXPECT_EQ(agent_->report().downloaded_bytes, 0U);
}

}  // namespace
}  // namespace tessera::agent
