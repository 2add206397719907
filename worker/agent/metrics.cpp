#include "agent/metrics.h"

#include <prometheus/collectable.h>

#include <limits>
#include <utility>
#include <vector>

#include "agent/agent.h"
#include "telemetry/metrics.h"

namespace tessera::agent {
namespace {

using prometheus::MetricType;
using telemetry::ReadFamily;

prometheus::MetricFamily unit_seconds(const AgentReport& report) {
  prometheus::MetricFamily family;
  family.name = "tessera_worker_unit_seconds";
  family.help = "Time that units took to render";
  family.type = MetricType::Histogram;
  prometheus::ClientMetric::Histogram& histogram = family.metric.emplace_back().histogram;
  histogram.sample_sum = report.rendered_unit_seconds;
  for (std::size_t i = 0; i < report.units_by_seconds.size(); ++i) {
    const bool last = i == telemetry::kUnitSecondsBuckets.size();
    histogram.sample_count += report.units_by_seconds[i];
    histogram.bucket.push_back({histogram.sample_count, last ? std::numeric_limits<double>::infinity()
                                                             : telemetry::kUnitSecondsBuckets[i]});
  }
  return family;
}

class AgentMetrics final : public prometheus::Collectable {
 public:
  explicit AgentMetrics(const Agent& agent) : agent_(agent) {}

  std::vector<prometheus::MetricFamily> Collect() const override {
    const AgentReport report = agent_.report();
    std::vector<prometheus::MetricFamily> families{unit_seconds(report)};
    const auto add = [&](MetricType type, const char* name, const char* help, const char* label,
                         std::initializer_list<std::pair<const char*, double>> values) {
      ReadFamily family{type, name, help, label};
      for (const auto& [value, number] : values) family[value] = number;
      families.push_back(std::move(family).family());
    };
    const auto number = [](std::uint64_t count) { return static_cast<double>(count); };
    add(MetricType::Counter, "tessera_worker_units_total", "Units, by what became of them", "outcome",
        {{"rendered", number(report.units_rendered)},
         {"failed", number(report.units_failed)},
         {"stopped", number(report.units_stopped)},
         {"handed_back", number(report.units_handed_back)}});
    add(MetricType::Counter, "tessera_worker_results_total", "Results that the coordinator has acknowledged",
        "", {{"", number(report.results_acknowledged)}});
    add(MetricType::Gauge, "tessera_worker_outbox_results", "Results that are not acknowledged yet", "",
        {{"", number(report.outbox_results)}});
    add(MetricType::Gauge, "tessera_worker_outbox_bytes", "Their bytes", "",
        {{"", number(report.outbox_bytes)}});
    add(MetricType::Counter, "tessera_worker_cache_lookups_total", "Blobs asked of the cache", "result",
        {{"hit", number(report.cache_hits)}, {"miss", number(report.cache_misses)}});
    add(MetricType::Gauge, "tessera_worker_cache_bytes", "Bytes of the cache, parts of downloads included",
        "", {{"", number(report.cache_bytes)}});
    add(MetricType::Counter, "tessera_worker_fetched_bytes_total", "Bytes of blobs from the coordinator", "",
        {{"", number(report.downloaded_bytes)}});
    add(MetricType::Counter, "tessera_worker_scenes_loaded_total", "Scenes built", "",
        {{"", number(report.scenes_loaded)}});
    add(MetricType::Gauge, "tessera_worker_scenes", "Scenes held", "", {{"", number(report.scenes_held)}});
    add(MetricType::Gauge, "tessera_worker_scene_bytes", "Bytes that they hold", "",
        {{"", number(report.scene_bytes_held)}});
    return families;
  }

 private:
  const Agent& agent_;
};

}  // namespace

std::shared_ptr<prometheus::Collectable> agent_metrics(const Agent& agent) {
  return std::make_shared<AgentMetrics>(agent);
}

}  // namespace tessera::agent
