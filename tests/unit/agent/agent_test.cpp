// The agent against a coordinator that misbehaves, with a renderer that needs no scene.
#include "agent/agent.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <prometheus/collectable.h>
#include <prometheus/metric_family.h>

#include <atomic>
#include <map>
#include <set>
#include <thread>

#include "agent/metrics.h"
#include "support/temp_dir.h"
#include "tessera/v1/scene.pb.h"
#include "unit/agent/fake_coordinator.h"
#include "wire/tile_result.h"

namespace tessera::agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Behaviour of the fake scenes of one test, and counts of their calls.
struct FakeRenderer {
  std::atomic<int> loads{0};
  std::atomic<int> renders{0};
  std::set<std::uint32_t> hanging_tiles;  // x0 of tiles that never finish by themselves
  std::atomic<int> hanging{0};
  std::atomic<bool> gate_open{false};  // lets hanging tiles finish
  absl::Status load_error;
  bool needs_blobs = true;  // loading asks for all of the job
};

class FakeScene final : public render::RenderScene {
 public:
  explicit FakeScene(FakeRenderer& renderer) : renderer_(renderer) {}

  absl::StatusOr<wire::TileResult> render_tile(const render::TileRequest& tile, std::stop_token stop,
                                               render::RenderStats& stats) const override {
    if (renderer_.hanging_tiles.contains(tile.x0)) {
      ++renderer_.hanging;
      while (!renderer_.gate_open && !stop.stop_requested()) std::this_thread::yield();
      if (stop.stop_requested()) return absl::CancelledError("stopped");
    }
    ++renderer_.renders;
    wire::TileResult result{
        tile.x0, tile.y0, tile.x1, tile.y1, tile.sample_begin, tile.sample_end, *wire::channels_for_aovs({}),
        {},      {}};
    result.counts.assign(result.pixel_count(), tile.sample_end - tile.sample_begin);
    result.values.assign(result.pixel_count() * result.channels.size(), static_cast<float>(tile.x0));
    stats.samples += result.pixel_count();
    return result;
  }
  absl::StatusOr<std::shared_ptr<const render::Prepared>> prepare(
      std::span<const std::string_view>) const override {
    return nullptr;
  }
  absl::StatusOr<std::string> make_part(const render::PartRequest&, std::stop_token,
                                        render::RenderStats&) const override {
    return "";
  }
  absl::StatusOr<std::string> merge(std::uint32_t, std::span<const std::string_view>) const override {
    return "";
  }
  const std::vector<std::string>& material_names() const override { return warnings_; }
  Ceiling measure_ceiling(const render::TileRequest&) const override { return {}; }
  const std::vector<std::string>& warnings() const override { return warnings_; }
  std::size_t memory_bytes() const override { return 1; }

 private:
  FakeRenderer& renderer_;
  std::vector<std::string> warnings_{"fog is left out"};
};

/// Values of counters and gauges, and counts of histograms, by "name", or "name label".
std::map<std::string, double> values_of(const prometheus::Collectable& source) {
  std::map<std::string, double> values;
  for (const prometheus::MetricFamily& family : source.Collect()) {
    for (const prometheus::ClientMetric& metric : family.metric) {
      const std::string name =
          metric.label.empty() ? family.name : family.name + " " + metric.label.front().value;
      values[name] =
          metric.counter.value + metric.gauge.value + static_cast<double>(metric.histogram.sample_count);
    }
  }
  return values;
}

class AgentTest : public ::testing::Test {
 protected:
  v1::JobSpec spec_for_scene(int corrupt_downloads = 0, std::size_t break_after = 0) {
    v1::Scene scene;
    scene.set_name(std::string(5000, 'x'));  // several chunks of the fake's download
    v1::JobSpec spec;
    spec.mutable_scene()->set_digest(
        coordinator_.add_blob(scene.SerializeAsString(), corrupt_downloads, break_after));
    return spec;
  }

  void start(int threads, std::chrono::milliseconds grace = std::chrono::seconds{10},
             std::chrono::milliseconds unit_limit = {}) {
    AgentOptions options;
    options.name = "test";
    options.address = "the fake";
    options.threads = threads;
    options.isas = {"avx2"};
    options.cache_dir = cache_.path();
    options.grace = grace;
    options.unit_limit = unit_limit;
    options.load_scene =
        [this](const v1::Scene& scene, const v1::JobSpec& job, const render::BlobSource& blobs,
               const render::LoadOptions&) -> absl::StatusOr<std::unique_ptr<render::RenderScene>> {
      ++renderer_.loads;
      if (!renderer_.load_error.ok()) return renderer_.load_error;
      for (const v1::BlobRef& blob : job.blobs()) {
        if (!renderer_.needs_blobs) break;
        if (const auto bytes = blobs(blob.digest()); !bytes.ok()) return bytes.status();
      }
      EXPECT_EQ(scene.name().size(), 5000);
      return std::make_unique<FakeScene>(renderer_);
    };
    auto agent = Agent::create(coordinator_.channel(), std::move(options));
    ASSERT_TRUE(agent.ok()) << agent.status();
    agent_ = *std::move(agent);
    runner_ = std::jthread{[this](std::stop_token stop) { status_ = agent_->run(stop); }};
  }

  absl::Status stop_and_join() {
    runner_.request_stop();
    runner_.join();
    return status_;
  }

  /// Waits until `count` tiles hang; the test's own timeout is the limit.
  void wait_for_hanging(int count) {
    while (renderer_.hanging < count) std::this_thread::yield();
  }

  support::TempDir cache_;
  FakeRenderer renderer_;
  FakeCoordinator coordinator_;
  std::unique_ptr<Agent> agent_;
  absl::Status status_;
  std::jthread runner_;
};

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
  std::uint32_t results = 0;
  while (!agent_->report().units_stopped && results < 2000) {
    coordinator_.offer("job", spec, 1 + results, 1);
    ASSERT_TRUE(coordinator_.wait_for_results(++results));
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
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

TEST_F(AgentTest, RegistersAgainWhenTheCoordinatorForgotItAndDeliversWhatItHeld) {
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

TEST_F(AgentTest, SaysWhatItHoldsBeforeItAsksANewCoordinator) {
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
}

TEST_F(AgentTest, AnyOtherFailureIsNotTheScenesFault) {
  renderer_.load_error = absl::ResourceExhaustedError("out of memory");
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_failures(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_FALSE(coordinator_.failures()[0].scene_fault());
}

TEST_F(AgentTest, AMissingBlobFailsTheUnit) {
  v1::JobSpec spec = spec_for_scene();
  spec.add_blobs()->set_digest(std::string(64, 'a'));
  coordinator_.offer("job", spec, 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_failures(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_FALSE(coordinator_.failures()[0].scene_fault());
  EXPECT_THAT(coordinator_.failures()[0].message(), HasSubstr("no such blob"));
}

TEST_F(AgentTest, WhatTheBuilderDoesNotAskForIsNotFetched) {
  v1::JobSpec spec = spec_for_scene();
  spec.add_blobs()->set_digest(std::string(64, 'a'));
  renderer_.needs_blobs = false;
  coordinator_.offer("job", spec, 0, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_results(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_TRUE(coordinator_.failures().empty());
}

TEST_F(AgentTest, StoppingFinishesWhatWasBegunAndGivesTheRestBack) {
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

TEST_F(AgentTest, UnitsThatOutlastTheGracePeriodAreStopped) {
  renderer_.hanging_tiles = {0};
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  start(1, std::chrono::milliseconds{20});
  wait_for_hanging(1);
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_TRUE(coordinator_.results().empty());
  EXPECT_TRUE(coordinator_.wait_for_deregistration());
}

TEST_F(AgentTest, DrainsWhenTheCoordinatorAsksForIt) {
  coordinator_.ask_to_drain();
  start(1);
  runner_.join();
  EXPECT_TRUE(status_.ok()) << status_;
  EXPECT_TRUE(coordinator_.wait_for_deregistration());
}

TEST_F(AgentTest, OneThatWasRegisteredOutlivesAnswersToDamagedCalls) {
  start(1);
  coordinator_.offer("job", spec_for_scene(), 0, 1);
  ASSERT_TRUE(coordinator_.wait_for_results(1));
  coordinator_.misread(2);  // two calls of Lease
  coordinator_.offer("job", spec_for_scene(), 1, 1);
  ASSERT_TRUE(coordinator_.wait_for_results(2));
  coordinator_.forget_workers();
  coordinator_.misread(2);  // of Lease or Register
  coordinator_.offer("job", spec_for_scene(), 2, 1);
  ASSERT_TRUE(coordinator_.wait_for_results(3));
  EXPECT_TRUE(stop_and_join().ok());
}

TEST_F(AgentTest, AnAddressThatIsNoCoordinatorsEndsTheRun) {
  coordinator_.misread(1);
  start(1);
  runner_.join();
  EXPECT_EQ(status_.code(), absl::StatusCode::kUnimplemented);
}

TEST_F(AgentTest, ARefusedRegistrationEndsTheRun) {
  coordinator_.refuse_registration("build 0.0.9 does not match 0.1.0");
  start(2);
  runner_.join();
  EXPECT_EQ(status_.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string{status_.message()}, HasSubstr("Register at the fake: build 0.0.9"));
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

TEST_F(AgentTest, MetricsSayWhatItDid) {
  const auto spec = spec_for_scene();
  coordinator_.offer("job", spec, 0, 5);
  start(2);
  ASSERT_TRUE(coordinator_.wait_for_results(5));
  EXPECT_TRUE(stop_and_join().ok());
  const std::map<std::string, double> metrics = values_of(*agent_metrics(*agent_));
  const auto expect = [&](const char* name, double value) {
    ASSERT_TRUE(metrics.contains(name)) << name;
    EXPECT_EQ(metrics.at(name), value) << name;
  };
  expect("tessera_worker_units_total rendered", 5);
  expect("tessera_worker_units_total failed", 0);
  expect("tessera_worker_units_total stopped", 0);
  expect("tessera_worker_units_total handed_back", 0);
  expect("tessera_worker_results_total", 5);
  expect("tessera_worker_outbox_results", 0);
  expect("tessera_worker_outbox_bytes", 0);
  expect("tessera_worker_unit_seconds", 5);
  expect("tessera_worker_cache_lookups_total hit", 0);
  expect("tessera_worker_cache_lookups_total miss", 1);
  expect("tessera_worker_scenes_loaded_total", 1);
  expect("tessera_worker_scenes", 1);
  expect("tessera_worker_scene_bytes", 1);
  EXPECT_GT(metrics.at("tessera_worker_fetched_bytes_total"), 5000);
  EXPECT_EQ(metrics.at("tessera_worker_cache_bytes"), metrics.at("tessera_worker_fetched_bytes_total"));
}

TEST_F(AgentTest, MetricsTellFailuresFromStops) {
  renderer_.hanging_tiles = {0};
  coordinator_.offer("job", spec_for_scene(), 0, 4);  // of one thread: one hangs, and one waits in vain
  start(1, /*grace=*/std::chrono::milliseconds{0});
  ASSERT_TRUE(coordinator_.wait_for_leased(2));
  wait_for_hanging(1);
  EXPECT_TRUE(stop_and_join().ok());
  const std::map<std::string, double> metrics = values_of(*agent_metrics(*agent_));
  EXPECT_EQ(metrics.at("tessera_worker_units_total stopped"), 1);
  EXPECT_GE(metrics.at("tessera_worker_units_total handed_back"), 1);
  EXPECT_EQ(metrics.at("tessera_worker_units_total rendered"), 0);

  renderer_.load_error = absl::InvalidArgumentError("no such shape");
  coordinator_.offer("bad", spec_for_scene(), 4, 1);
  start(1);
  ASSERT_TRUE(coordinator_.wait_for_failures(1));
  EXPECT_TRUE(stop_and_join().ok());
  EXPECT_GE(values_of(*agent_metrics(*agent_)).at("tessera_worker_units_total failed"), 1);
}

}  // namespace
}  // namespace tessera::agent
