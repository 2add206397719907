// Metrics of an agent.
#include <prometheus/collectable.h>
#include <prometheus/metric_family.h>

#include <map>

#include "agent/metrics.h"
#include "unit/agent/agent_fixture.h"

namespace tessera::agent {
namespace {

using AgentMetrics = AgentTest;

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

TEST_F(AgentMetrics, MetricsSayWhatItDid) {
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

TEST_F(AgentMetrics, MetricsTellFailuresFromStops) {
  renderer_.hanging_tiles = {0};
  coordinator_.offer("job", spec_for_scene(), 0, 4);  // one thread: one unit hangs, and one waits in vain
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
