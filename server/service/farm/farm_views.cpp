#include "service/farm/farm_views.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "service/farm/farm_core.h"
#include "service/farm/worker_registry.h"
#include "wire/limits.h"
#include "wire/tile_result.h"
#include "wire/version.h"

namespace tessera::server {
namespace {

// Upper bounds of one WatchJob message: enough to keep a connection busy, little enough to hold for a
// thousand slow readers.
constexpr std::size_t kWatchBatchBytes = std::size_t{1} << 20;
constexpr std::size_t kWatchBatchResults = 256;
// Upper bound of the workers in one answer. Twenty thousand with the longest names that are taken go into it.
constexpr std::size_t kMostWorkerBytes = wire::kMaxMessageBytes / 2;

/// DataLoss also for a payload that can be read, but is not what was written: it has a checksum of its own.
absl::StatusOr<std::string> read_result(Journal& journal, const std::string& job, std::uint64_t sequence) {
  absl::StatusOr<std::string> payload = journal.read_result(job, sequence);
  absl::Status status = payload.ok() ? wire::decode_tile_result(*payload).status() : payload.status();
  if (status.ok()) return payload;
  if (absl::IsInvalidArgument(status) || absl::IsNotFound(status))
    status = absl::DataLossError(status.message());
  return absl::Status(
      status.code(), absl::StrCat("result ", sequence, " of job ", job, ": ", std::string(status.message())));
}

/// Who works on the job.
void add_workers(const Scheduler& scheduler, const std::string& id, v1::GetJobResponse& response) {
  absl::flat_hash_map<std::string, std::uint32_t> leases;
  for (const Assignment& assignment : scheduler.assignments()) {
    if (assignment.job == id) leases[assignment.worker] = assignment.leases;
  }
  for (const WorkerView& view : scheduler.workers()) {
    const auto found = leases.find(view.info.id);
    if (found == leases.end()) continue;
    v1::JobWorker& worker = *response.add_workers();
    worker.set_name(view.info.name);
    worker.set_host(short_name(view.info.host));
    worker.set_leases(found->second);
  }
}

}  // namespace

// ---------------------------------------------------------------- jobs

v1::ListJobsResponse FarmViews::list_jobs() const {
  const std::lock_guard lock(core_.mutex());
  v1::ListJobsResponse response;
  for (const auto& entry : core_.jobs().all()) {
    v1::JobStatus& status = *response.add_jobs() = core_.outline(*entry);
    status.clear_set_aside();
    status.clear_latest_failures();
  }
  return response;
}

absl::StatusOr<v1::GetJobResponse> FarmViews::get_job(const std::string& id) const {
  const std::lock_guard lock(core_.mutex());
  const absl::StatusOr<JobEntry*> entry = core_.find_job(id);
  if (!entry.ok()) return entry.status();
  v1::GetJobResponse response;
  *response.mutable_status() = describe(**entry);
  add_failure_logs(**entry, core_.view_of(**entry), *response.mutable_status());
  *response.mutable_spec() = (*entry)->shape->spec;
  for (const HostShare& slow : (*entry)->hosts.slow()) {
    v1::SlowHost& host = *response.add_slow_hosts();
    host.set_host(short_name(slow.host));
    host.set_units(slow.timed_units);
    host.set_slowness(slow.slowness);
  }
  add_workers(core_.scheduler(), id, response);
  return response;
}

absl::StatusOr<std::string> FarmViews::owner_of(const std::string& id) const {
  const std::lock_guard lock(core_.mutex());
  const absl::StatusOr<JobEntry*> entry = core_.find_job(id);
  if (!entry.ok()) return entry.status();
  return (*entry)->shape->spec.farm().user();
}

absl::StatusOr<std::shared_ptr<const JobShape>> FarmViews::shape_of(const std::string& id) const {
  const std::lock_guard lock(core_.mutex());
  const absl::StatusOr<JobEntry*> entry = core_.find_job(id);
  if (!entry.ok()) return entry.status();
  return (*entry)->shape;
}

v1::JobStatus FarmViews::describe(const JobEntry& entry) const {
  v1::JobStatus status = core_.outline(entry);
  if (!entry.past) status.set_waiting_for(core_.scheduler().waiting_for(entry.id, core_.now()));
  if (!entry.past) status.set_left_out(core_.scheduler().left_out(entry.id));
  if (is_open(status.state())) return status;
  for (const std::string& host : entry.hosts.hosts()) {
    if (core_.scheduler().trusts(host)) continue;
    status.add_notes(
        absl::StrCat(entry.hosts.units_of(host), " units are of host ", short_name(host),
                     ", which returned wrong pixels and is in quarantine: they may be wrong too; ",
                     "tessera submit --fresh renders all again"));
  }
  return status;
}

// ---------------------------------------------------------------- workers

v1::ListWorkersResponse FarmViews::list_workers() const {
  const std::lock_guard lock(core_.mutex());
  const Time at = core_.now();
  v1::ListWorkersResponse response;
  response.set_build(wire::build_version());
  response.set_unix_time_ms(core_.unix_now());
  std::size_t bytes = 0;
  absl::flat_hash_map<std::string, std::vector<Assignment>> assignments;
  for (Assignment& assignment : core_.scheduler().assignments())
    assignments[assignment.worker].push_back(std::move(assignment));
  for (const WorkerView& view : core_.scheduler().workers()) {
    if (bytes > kMostWorkerBytes) {
      core_.tell(news::WorkerListCut{response.workers_size()});
      break;
    }
    v1::WorkerStatus& worker = *response.add_workers();
    worker.set_worker_id(view.info.id);
    worker.set_name(view.info.name);
    worker.set_isa(view.info.isa);
    worker.set_build(view.info.build);
    worker.set_threads(view.info.threads);
    worker.set_leases(view.leases);
    worker.set_units_done(view.units_done);
    worker.set_draining(view.draining);
    worker.set_last_seen_ms_ago((at - view.last_seen).count());
    worker.set_host(short_name(view.info.host));
    for (const std::string& tag : view.info.tags) worker.add_tags(tag);
    worker.set_quarantine(view.quarantine);
    worker.set_slowness(view.slowness);
    worker.set_certificate(view.info.certificate);
    if (const auto* const registration = workers_.find(view.info.id)) {
      worker.set_failures(registration->failures);
      worker.set_resident_bytes(registration->resident_bytes);
    }
    for (const Assignment& assignment : assignments[view.info.id]) {
      const v1::JobSpec& spec = core_.jobs().find(assignment.job)->shape->spec;
      v1::WorkerJob& job = *worker.add_jobs();
      job.set_job_id(assignment.job);
      job.set_name(spec.farm().name());
      job.set_user(spec.farm().user());
      job.set_leases(assignment.leases);
    }
    v1::WorkerArithmetic& arithmetic = *worker.mutable_arithmetic();
    for (const std::string& name : view.info.classes) arithmetic.add_classes(name);
    for (const std::string& job : view.closed_jobs) arithmetic.add_closed_jobs(job);
    bytes += worker.ByteSizeLong();
  }
  return response;
}

std::chrono::milliseconds FarmViews::heartbeat_interval() const {
  const std::lock_guard lock(core_.mutex());
  return core_.scheduler().heartbeat_interval();
}

std::vector<PixelsInWork> FarmViews::in_work(const std::string& id, std::size_t most) const {
  const std::lock_guard lock(core_.mutex());
  std::vector<PixelsInWork> result;
  const absl::StatusOr<JobEntry*> entry = core_.find_job(id);
  if (!entry.ok() || (*entry)->past) return result;
  const JobShape& shape = *(*entry)->shape;
  for (const Lease& lease : core_.scheduler().leases_of(id)) {
    if (result.size() == most) break;
    if (!shape.plan->is_of_picture(lease.units.first)) continue;
    const v1::TileUnit extent = extent_of(shape.plan->unit(lease.units), shape.spec);
    if (extent.view() == 0) result.push_back({.pixels = extent.pixels(), .worker = lease.worker});
  }
  return result;
}

// ---------------------------------------------------------------- results

struct FarmViews::Results {
  v1::JobStatus status;
  std::shared_ptr<const JobShape> shape;
  std::vector<CoveredUnits> units;     // those to be read
  std::vector<std::uint64_t> revoked;  // JobEntry::past_revoked
  std::uint64_t available = 0;
  bool ended = false;
};

absl::StatusOr<FarmViews::Results> FarmViews::results_after(const std::string& id, std::uint64_t after,
                                                            bool status_only) const {
  Results results;
  {
    const std::lock_guard lock(core_.mutex());
    const absl::StatusOr<JobEntry*> found = core_.find_job(id);
    if (!found.ok()) return found.status();
    const JobEntry& entry = **found;
    results.status = describe(entry);
    results.shape = entry.shape;
    results.revoked = entry.past_revoked;
    results.available = entry.durable_results;
    results.ended = entry.durable_end && (entry.past || results.available == entry.units_by_sequence.size());
    if (status_only || after >= results.available) return results;
    if (!entry.past) {
      const auto first = entry.units_by_sequence.begin() + static_cast<std::ptrdiff_t>(after);
      results.units.assign(first, first + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(
                                              results.available - after, kWatchBatchResults)));
      return results;
    }
  }
  absl::StatusOr<std::vector<CoveredUnits>> read = core_.journal().read_units(id, after, kWatchBatchResults);
  if (!read.ok()) return read.status();
  results.units = *std::move(read);
  return results;
}

absl::StatusOr<WatchBatch> FarmViews::next_results(const std::string& id, std::uint64_t after,
                                                   bool status_only) {
  absl::StatusOr<Results> results = results_after(id, after, status_only);
  if (!results.ok()) return results.status();
  WatchBatch batch{.response = {}, .last = after};
  *batch.response.mutable_status() = std::move(results->status);
  const WorkPlan& plan = *results->shape->plan;
  const std::vector<std::uint64_t>& revoked = results->revoked;
  std::size_t bytes = 0;
  for (const CoveredUnits& covered : results->units) {
    if (covered.first == JobEntry::kRevoked || !plan.is_of_picture(covered.first) ||
        std::binary_search(revoked.begin(), revoked.end(), batch.last + 1)) {
      ++batch.last;
      continue;
    }
    const absl::StatusOr<std::string> payload = read_result(core_.journal(), id, batch.last + 1);
    if (absl::IsDataLoss(payload.status())) {
      const std::lock_guard lock(core_.mutex());
      const absl::StatusOr<JobEntry*> found = core_.find_job(id);
      if (!found.ok()) return found.status();
      if (absl::Status status = core_.do_again(**found, batch.last + 1, payload.status()); !status.ok())
        return status;
      results->ended = false;
      break;
    }
    if (!payload.ok()) return payload.status();
    if (bytes > 0 && bytes + payload->size() > kWatchBatchBytes) break;
    bytes += payload->size();
    v1::UnitResult& result = *batch.response.add_results();
    result.set_sequence(++batch.last);
    // A journal may be damaged.
    const std::optional<UnitRun> run = plan.run(covered.first, covered.ranges);
    if (!run)
      return absl::DataLossError(
          absl::StrCat("journal: job ", id, ": result ", batch.last, " cannot be read"));
    *result.mutable_unit() = plan.unit(*run);
    result.set_ranges(run->count);
    result.set_payload(*payload);
  }
  batch.finished = results->ended && (status_only || batch.last >= results->available);
  return batch;
}

absl::StatusOr<std::string> FarmViews::result_of(const std::string& id, std::uint64_t sequence) const {
  return core_.journal().read_result(id, sequence);
}

absl::StatusOr<std::vector<v1::UnitStats>> FarmViews::costs_of(const std::string& id, std::uint64_t after,
                                                               std::uint32_t most) const {
  const absl::StatusOr<std::vector<std::string>> read = core_.journal().read_stats(id, after, most);
  if (!read.ok()) return read.status();
  std::vector<v1::UnitStats> costs(read->size());
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (!costs[i].ParseFromString((*read)[i]))
      return absl::DataLossError(absl::StrCat("journal: cost of result ", after + i + 1, " of job ", id));
  }
  return costs;
}

absl::StatusOr<std::string> FarmViews::last_phase_of(const std::string& id) const {
  std::optional<std::string> digest;
  {
    const std::lock_guard lock(core_.mutex());
    const absl::StatusOr<JobEntry*> entry = core_.find_job(id);
    if (!entry.ok()) return entry.status();
    const std::vector<std::uint32_t>& roots = (*entry)->shape->plan->phases().roots();
    if (!roots.empty()) digest = (*entry)->phase_blobs.made_by(roots.back());
  }
  if (!digest) return absl::NotFoundError(absl::StrCat("job ", id, " has no blob of a last phase"));
  const absl::StatusOr<std::unique_ptr<BlobReader>> blob = core_.blobs().read(*digest);
  if (!blob.ok()) return blob.status();
  return (*blob)->read(0, (*blob)->size());
}

absl::StatusOr<std::unique_ptr<BlobReader>> FarmViews::scene_of(const std::string& id) const {
  const absl::StatusOr<std::shared_ptr<const JobShape>> shape = shape_of(id);
  if (!shape.ok()) return shape.status();
  return core_.blobs().read((*shape)->spec.content().scene());
}

}  // namespace tessera::server
