// One unit of work: from the lease to the encoded result.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <stop_token>

#include "agent/agent.h"
#include "agent/link/outbox.h"
#include "agent/stores/blob_fetcher.h"
#include "agent/stores/prepared_store.h"
#include "agent/stores/scene_store.h"
#include "agent/time_limit.h"
#include "base/clock.h"

namespace tessera::agent {

/// Thread-safe.
class UnitRenderer {
 public:
  /// `fetcher` may be null when the options name a blob source.
  UnitRenderer(const AgentOptions& options, CoordinatorLink& link, BlobFetcher* fetcher);

  /// Renders on the calling thread. The outcome's failure is Cancelled when the unit was revoked.
  Outcome render(std::shared_ptr<HeldUnit> unit);

  std::vector<std::string> loaded_digests() const { return scenes_.digests(); }
  /// The job is over: what its phases made is not needed any more.
  void forget_job(const std::string& job_id) { prepared_.drop(job_id); }
  /// Everything but the results' way home.
  AgentReport report() const;

 private:
  absl::StatusOr<LoadedScene> load(const v1::JobSpec& spec, std::uint32_t view, std::stop_token stop);
  absl::Status render_unit(const HeldUnit& unit, Outcome& outcome);
  /// Makes the unit's pixels or blob, into the outcome.
  absl::Status make(const HeldUnit& held, const std::shared_ptr<const LoadedScene>& scene,
                    std::stop_token stop, Outcome& outcome, render::RenderStats& counts);

  const AgentOptions& options_;
  base::Clock& clock_;
  BlobFetcher* const fetcher_;
  render::SharedContents contents_;
  SceneStore scenes_;
  PreparedStore prepared_;
  TimeLimit time_limit_;
  mutable std::mutex mutex_;
  AgentReport report_;
  /// Cost of loading, until a unit of that scene tells the coordinator. CPU time is the whole process's
  /// meanwhile.
  struct LoadCost {
    std::chrono::nanoseconds fetch_cpu{0}, build_cpu{0};
    std::uint64_t blob_bytes = 0;
  };
  std::map<const render::RenderScene*, LoadCost> untold_costs_;
};

}  // namespace tessera::agent
