#include "service/farm/job_retention.h"

#include <algorithm>
#include <utility>

#include "service/farm/farm_core.h"
#include "service/farm/worker_leases.h"

namespace tessera::server {

JobRetention::JobRetention(FarmCore& core, WorkerLeases& leases)
    : core_(core),
      leases_(leases),
      keeper_(core.options().retention, core.blobs(), core.clock(), core.options().lived_time) {}

void JobRetention::forget(const std::string& id, DoneEmpty done) {
  if (!core_.jobs().find(id)->past) static_cast<void>(core_.scheduler().forget_job(id));
  core_.jobs().erase(id);
  keeper_.forget(id);
  core_.commit({.entries = {JobPruned{.id = id}}}, std::move(done));
}

void JobRetention::tick() {
  retire_jobs();
  if (keeper_.is_due()) prune();
}

void JobRetention::stop() {
  const std::lock_guard lock(core_.mutex());
  keeper_.stop();
}

void JobRetention::retire_jobs() {
  keeper_.live_on();
  for (const auto& entry : core_.jobs().all()) {
    if (entry->past || !entry->durable_end || entry->durable_results < entry->units_by_sequence.size() ||
        keeper_.since_end_of(entry->id) < core_.options().late_results) {
      continue;
    }
    JobView view = core_.view_of(*entry);
    if (view.state == v1::INCOMPLETE || !core_.scheduler().forget_job(entry->id).ok()) continue;
    retire(*entry, std::move(view));
  }
}

void JobRetention::prune() {
  const std::vector<std::string> old =
      keeper_.old_jobs(core_.jobs(), [this](const JobEntry& entry) { return core_.view_of(entry).state; });
  for (const std::string& id : old) {
    core_.tell(news::JobDeleted{*core_.jobs().find(id), /*on_request=*/false});
    forget(id, [](const absl::Status&) {});
  }
  drop_lease_uploads();
  keeper_.clean_up(core_.jobs(), !old.empty());
}

void JobRetention::drop_lease_uploads() {
  std::vector<std::string> old = leases_.take_old_uploads();
  std::erase_if(old, [this](const std::string& digest) {
    return core_.jobs().blobs().size_of(digest).has_value() ||
           std::ranges::any_of(core_.jobs().all(), [&](const std::unique_ptr<JobEntry>& entry) {
             return entry->phase_blobs.has(digest);
           });
  });
  keeper_.drop_unused(std::move(old), LeaseUploads::kKept);
}

}  // namespace tessera::server
