#include "service/metrics.h"

#include <prometheus/collectable.h>
#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <algorithm>
#include <array>
#include <utility>

#include "connections/connections.h"
#include "service/farm/farm_views.h"
#include "service/rpc/open_streams.h"
#include "telemetry/metrics.h"

namespace tessera::server {
namespace {

constexpr std::array kCallNames{"lease", "heartbeat", "complete", "fail", "tick"};

double seconds(std::chrono::nanoseconds time) { return std::chrono::duration<double>(time).count(); }

prometheus::Histogram::BucketBoundaries short_times() {
  return {1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1};
}

prometheus::Counter& counter(prometheus::Registry& registry, const char* name, const char* help) {
  return prometheus::BuildCounter().Name(name).Help(help).Register(registry).Add({});
}

void add(prometheus::Counter& counter, std::uint64_t amount) {
  counter.Increment(static_cast<double>(amount));
}

/// Read anew at each call.
telemetry::ReadFamily gauge(const char* name, const char* help, const char* label) {
  return {prometheus::MetricType::Gauge, name, help, label};
}

class FarmGauges final : public prometheus::Collectable {
 public:
  explicit FarmGauges(const FarmViews& views) : views_(views) {}

  std::vector<prometheus::MetricFamily> Collect() const override {
    telemetry::ReadFamily jobs = gauge("tessera_jobs", "Jobs, by state", "state");
    telemetry::ReadFamily units =
        gauge("tessera_units", "Units of jobs that are not over, by state", "state");
    units["waiting"] = units["leased"] = units["done"] = units["set_aside"] = 0;
    const v1::ListJobsResponse all_jobs = views_.list_jobs();
    for (const v1::JobStatus& job : all_jobs.jobs()) {
      ++jobs[v1::JobState_Name(job.state())];
      if (job.state() != v1::QUEUED && job.state() != v1::RUNNING) continue;
      units["leased"] += job.units_leased();
      units["done"] += job.units_done();
      units["set_aside"] += job.units_set_aside();
      units["waiting"] += job.units_waiting();
    }
    telemetry::ReadFamily workers = gauge("tessera_workers", "Workers that are connected, by state", "state");
    workers["working"] = workers["idle"] = workers["draining"] = workers["quarantine"] = 0;
    telemetry::ReadFamily threads =
        gauge("tessera_worker_threads", "Threads of the workers that are connected, by kernel ISA", "isa");
    const v1::ListWorkersResponse all_workers = views_.list_workers();
    for (const v1::WorkerStatus& worker : all_workers.workers()) {
      ++workers[!worker.quarantine().empty() ? "quarantine"
                : worker.draining()          ? "draining"
                : worker.leases() > 0        ? "working"
                                             : "idle"];
      threads[worker.isa()] += worker.threads();
    }
    std::vector<prometheus::MetricFamily> families;
    for (telemetry::ReadFamily* read : {&jobs, &units, &workers, &threads})
      families.push_back(std::move(*read).family());
    return families;
  }

 private:
  const FarmViews& views_;
};

class StreamCounter final : public prometheus::Collectable {
 public:
  explicit StreamCounter(const OpenStreams& streams) : streams_(streams) {}

  std::vector<prometheus::MetricFamily> Collect() const override {
    telemetry::ReadFamily cut{prometheus::MetricType::Counter, "tessera_cut_streams_total",
                              "Streams that were cut off because their other end took, or sent, nothing"};
    cut[""] = static_cast<double>(streams_.cut_count());
    return {std::move(cut).family()};
  }

 private:
  const OpenStreams& streams_;
};

class ConnectionMetrics final : public prometheus::Collectable {
 public:
  explicit ConnectionMetrics(const Connections& connections) : connections_(connections) {}

  std::vector<prometheus::MetricFamily> Collect() const override {
    telemetry::ReadFamily open =
        gauge("tessera_connections", "Connections, by whether a call has come on them", "state");
    const std::size_t silent = connections_.silent(), all = connections_.open();
    open["silent"] = static_cast<double>(silent);
    open["called"] = static_cast<double>(all - std::min(all, silent));
    telemetry::ReadFamily ended{prometheus::MetricType::Counter, "tessera_ended_connections_total",
                                "Connections that the coordinator refused, or closed because no call came",
                                "why"};
    ended["refused"] = static_cast<double>(connections_.refused());
    ended["silent"] = static_cast<double>(connections_.closed());
    return {std::move(open).family(), std::move(ended).family()};
  }

 private:
  const Connections& connections_;
};

}  // namespace

struct FarmMetrics::Series {
  std::shared_ptr<prometheus::Registry> registry = std::make_shared<prometheus::Registry>();
  prometheus::Counter& leases = counter(*registry, "tessera_leases_total", "Units handed out");
  prometheus::Counter& lost =
      counter(*registry, "tessera_lost_leases_total", "Leases that ran out with no result");
  prometheus::Counter& repeated =
      counter(*registry, "tessera_repeated_results_total", "Results that were there already");
  prometheus::Counter& refused =
      counter(*registry, "tessera_refused_results_total", "Results that were not accepted");
  prometheus::Counter& failures =
      counter(*registry, "tessera_failures_total", "Units that a worker could not render");
  prometheus::Counter& result_bytes =
      counter(*registry, "tessera_result_bytes_total", "Bytes of accepted results");
  prometheus::Counter& blob_bytes =
      counter(*registry, "tessera_uploaded_bytes_total", "Bytes of blobs from clients");
  prometheus::Counter& entries =
      counter(*registry, "tessera_journal_entries_total", "Entries committed to the journal");
  // Its count is that of completions.
  prometheus::Histogram& unit_seconds =
      prometheus::BuildHistogram()
          .Name("tessera_unit_seconds")
          .Help("Time that workers took for the units whose results were accepted")
          .Register(*registry)
          .Add({}, telemetry::kUnitSecondsBuckets);
  prometheus::Histogram& commit_seconds = prometheus::BuildHistogram()
                                              .Name("tessera_commit_seconds")
                                              .Help("Time from a change to its being durable")
                                              .Register(*registry)
                                              .Add({}, short_times());
  std::array<prometheus::Histogram*, kCallNames.size()> calls = [this] {
    auto& family = prometheus::BuildHistogram()
                       .Name("tessera_scheduler_seconds")
                       .Help("Time that calls spent in the scheduler, waiting for it included")
                       .Register(*registry);
    std::array<prometheus::Histogram*, kCallNames.size()> result{};
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = &family.Add({{"call", kCallNames[i]}}, short_times());
    return result;
  }();

  /// News that are not counted.
  template <class Other>
  void operator()(const Other&) const {}

  void operator()(const news::CallServed& news) const {
    calls[static_cast<std::size_t>(news.call)]->Observe(seconds(news.taken));
  }
  void operator()(const news::Committed& news) const {
    commit_seconds.Observe(seconds(news.taken));
    add(entries, news.entries);
  }
  void operator()(const news::BlobUploaded& news) const { add(blob_bytes, news.bytes); }
  void operator()(const news::UnitsLeased& news) const { add(leases, news.units); }
  void operator()(const news::LeasesLost& news) const { add(lost, news.leases); }
  void operator()(const news::ResultAccepted& news) const {
    unit_seconds.Observe(seconds(news.unit_time));
    add(result_bytes, news.bytes);
  }
  void operator()(const news::ResultRepeated&) const { repeated.Increment(); }
  void operator()(const news::ResultRefused& news) const {
    refused.Increment();
    if (news.reason == news::ResultRefused::Reason::kMisrendered) failures.Increment();
  }
  void operator()(const news::UnitFailed&) const { failures.Increment(); }
};

static_assert(kCallNames.size() == static_cast<std::size_t>(news::Call::kCount));

FarmMetrics::FarmMetrics() : series_(std::make_unique<Series>()) {}
FarmMetrics::~FarmMetrics() = default;

void FarmMetrics::note(const FarmNews& news) { std::visit(*series_, news); }

std::shared_ptr<prometheus::Collectable> FarmMetrics::collectable() const { return series_->registry; }

std::shared_ptr<prometheus::Collectable> farm_gauges(const FarmViews& views) {
  return std::make_shared<FarmGauges>(views);
}

std::shared_ptr<prometheus::Collectable> stream_counter(const OpenStreams& streams) {
  return std::make_shared<StreamCounter>(streams);
}

std::shared_ptr<prometheus::Collectable> connection_metrics(const Connections& connections) {
  return std::make_shared<ConnectionMetrics>(connections);
}

}  // namespace tessera::server
