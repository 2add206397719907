#include "agent/agent.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "agent/lease_table.h"
#include "agent/link/coordinator_link.h"
#include "agent/link/heart.h"
#include "agent/link/outbox.h"
#include "agent/link/session.h"
#include "agent/stores/blob_fetcher.h"
#include "agent/unit_renderer.h"
#include "net/backoff.h"
#include "net/status.h"
#include "telemetry/log.h"
#include "wire/limits.h"
#include "wire/version.h"

namespace tessera::agent {
namespace {

using std::chrono::milliseconds;

constexpr std::chrono::seconds kLeaseWait{10};
constexpr std::size_t kQueuedPerThread = 2;
constexpr std::size_t kResultsPerThread = 8;
constexpr int kMaxSenders = 4;

v1::RegisterRequest registration(const AgentOptions& options) {
  v1::RegisterRequest request;
  request.set_protocol(wire::kProtocolVersion);
  request.set_build(wire::build_version());
  request.set_isa(options.isas.front());
  for (const std::string& isa : options.isas) request.add_supported_isas(isa);
  const auto& classes = options.arithmetic_classes.empty() ? options.isas : options.arithmetic_classes;
  for (const std::string& name : classes) request.add_arithmetic_classes(name);
  request.set_name(options.name);
  request.set_host(options.host);
  for (const std::string& tag : options.tags) request.add_tags(tag);
  request.set_threads(static_cast<std::uint32_t>(options.threads));
  return request;
}

}  // namespace

/// Everything that lives while the agent runs. Declared in the order in which it is built; torn down in
/// reverse.
class Agent::Work {
 public:
  Work(std::unique_ptr<CoordinatorLink> link, AgentOptions options, std::unique_ptr<BlobCache> cache)
      : options_(std::move(options)),
        clock_(*options_.clock),
        owned_link_(std::move(link)),
        link_(*owned_link_),
        session_(clock_, link_, registration(options_),
                 [this](const std::string& id, std::stop_token stop) { heart_.introduce(id, stop); }),
        leases_(clock_),
        cache_(std::move(cache)),
        fetcher_(cache_ ? std::make_unique<BlobFetcher>(clock_, link_, *cache_) : nullptr),
        renderer_(options_, link_, fetcher_.get()),
        intake_(leases_,
                {.scene_digests = [this] { return renderer_.loaded_digests(); },
                 .forget_job = [this](const std::string& job_id) { renderer_.forget_job(job_id); }},
                link_.address(),
                std::min<std::size_t>(kQueuedPerThread * static_cast<std::size_t>(options_.threads),
                                      wire::kMaxLeasesPerCall)),
        heart_(link_, session_, leases_, drain_),
        outbox_(clock_, link_, session_, leases_, intake_, heart_,
                {.capacity = kResultsPerThread * static_cast<std::size_t>(options_.threads),
                 .senders = std::min(kMaxSenders, options_.threads),
                 .recent_log = options_.recent_log}) {}

  /// Until `stop`, a drain request, or a refusal, which is the error.
  absl::Status work(std::stop_token stop) {
    std::stop_callback outer{stop, [this] { drain_.request_stop(); }};
    std::vector<base::Thread> renderers;
    for (int i = 0; i < options_.threads; ++i) {
      renderers.push_back(clock_.start("renderer", [this](std::stop_token halt) { render_units(halt); }));
    }
    const base::Thread heart = clock_.start("heart", [this](std::stop_token halt) { heart_.beat(halt); });

    const absl::Status status = lease_units(drain_.get_token());
    if (status.ok()) wind_down();
    leases_.revoke_all();
    return status;
  }

  void deregister() {
    const std::string worker_id = session_.current();
    if (worker_id.empty()) return;
    v1::DeregisterRequest request;
    request.set_worker_id(worker_id);
    if (const absl::Status status = link_.deregister(request); !status.ok()) {
      spdlog::warn("{}; the coordinator will notice by itself", status.ToString());
    }
  }

  AgentReport report() const {
    AgentReport report = renderer_.report();
    outbox_.add_to(report);
    report.units_handed_back = handed_back_;
    if (cache_ != nullptr) report.cache_bytes = cache_->bytes();
    return report;
  }

 private:
  absl::Status lease_units(std::stop_token stop);
  void render_units(std::stop_token halt);
  void wind_down();

  const AgentOptions options_;
  base::Clock& clock_;
  const std::unique_ptr<CoordinatorLink> owned_link_;
  CoordinatorLink& link_;
  Session session_;
  LeaseTable leases_;
  const std::unique_ptr<BlobCache> cache_;      // null when the options name a blob source
  const std::unique_ptr<BlobFetcher> fetcher_;  // likewise
  UnitRenderer renderer_;
  LeaseIntake intake_;
  std::stop_source drain_;
  Heart heart_;
  Outbox outbox_;
  std::atomic<std::uint64_t> handed_back_{0};
};

absl::Status Agent::Work::lease_units(std::stop_token stop) {
  net::Backoff backoff{milliseconds{100}, milliseconds{2000}};
  bool warned = false;
  while (true) {
    leases_.wait_until_hungry(stop);
    const absl::StatusOr<std::string> worker_id = session_.worker_id(stop);
    if (stop.stop_requested()) return absl::OkStatus();
    if (!worker_id.ok()) return worker_id.status();

    v1::LeaseRequest request;
    request.set_worker_id(*worker_id);
    request.mutable_max_wait()->set_seconds(kLeaseWait.count());
    const LeaseIntake::Ask ask = intake_.ask(request);
    if (ask.units == 0) continue;  // a result that goes home has asked since
    const absl::StatusOr<v1::LeaseResponse> response = link_.lease(request, stop);
    const bool stopped = stop.stop_requested();  // what was granted this instant goes back with Deregister
    intake_.answered(ask, response.ok() && !stopped ? &*response : nullptr);
    if (stopped) return absl::OkStatus();
    if (response.ok()) {
      backoff.reset();
      warned = false;
      continue;
    }
    if (absl::IsNotFound(response.status())) {
      session_.lost(*worker_id);
      continue;
    }
    if (net::is_refusal(response.status())) return response.status();
    if (!warned) spdlog::warn("{}; trying again", response.status().ToString());
    warned = true;
    link_.wait(backoff, stop);
  }
}

void Agent::Work::render_units(std::stop_token halt) {
  while (std::shared_ptr<HeldUnit> unit = leases_.next(halt)) {
    // Lines of this thread are about the unit, those of building its scene, too.
    const telemetry::LogFields fields = unit->log_fields();
    const telemetry::LogAbout about{fields};
    Outcome outcome = renderer_.render(unit);
    if (absl::IsCancelled(outcome.failure)) {
      leases_.release(*unit);
      continue;
    }
    if (!outcome.failure.ok()) {
      spdlog::error("unit {} of job {}: {}", unit->unit.index(), unit->job_id, outcome.failure.ToString());
    }
    outbox_.push(std::move(outcome), halt);
  }
}

void Agent::Work::wind_down() {
  const std::size_t given_back = leases_.drop_queued();
  handed_back_ = given_back;
  const std::size_t begun = leases_.tokens().size();
  if (begun + given_back > 0) spdlog::info("stopping: {} units finish, {} are given back", begun, given_back);
  if (!leases_.wait_until_empty(options_.grace))
    spdlog::warn("units still at work after the grace period are stopped");
}

absl::StatusOr<std::unique_ptr<Agent>> Agent::create(std::unique_ptr<CoordinatorLink> link,
                                                     AgentOptions options) {
  if (options.isas.empty())
    return absl::FailedPreconditionError("this worker has no kernels for this machine");
  std::unique_ptr<BlobCache> cache;
  if (!options.blobs) {
    absl::StatusOr<std::unique_ptr<BlobCache>> opened =
        BlobCache::open(*options.clock, options.cache_dir, options.cache_cap_bytes);
    if (!opened.ok()) return opened.status();
    cache = *std::move(opened);
  }
  auto work = std::make_unique<Work>(std::move(link), std::move(options), std::move(cache));
  return std::unique_ptr<Agent>{new Agent{std::move(work)}};
}

Agent::Agent(std::unique_ptr<Work> work) : work_(std::move(work)) {}
Agent::~Agent() = default;

absl::Status Agent::run(std::stop_token stop) {
  const absl::Status status = work_->work(stop);
  work_->deregister();
  return status;
}

AgentReport Agent::report() const { return work_->report(); }

}  // namespace tessera::agent
