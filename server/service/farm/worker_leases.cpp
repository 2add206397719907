#include "service/farm/worker_leases.h"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "service/farm/farm_core.h"
#include "service/farm/lease_seal.h"
#include "service/farm/worker_registry.h"
#include "wire/limits.h"

namespace tessera::server {
namespace {

using google::protobuf::util::TimeUtil;

// A worker that took over its leases from an earlier coordinator may hold more than this one would give it.
constexpr int kMaxLeasesPerHeartbeat = 4 * wire::kMaxLeasesPerWorker;
constexpr int kMaxNamedPerLease = 256;  // jobs or scenes that a worker says it knows
// Bytes of a call that waits, with all its names.
constexpr std::size_t kMaxLeaseBytes = std::size_t{32} << 10;

}  // namespace

const LeaseSeal& WorkerLeases::seal() const { return *core_.options().seal; }

bool WorkerLeases::names_few(const v1::LeaseRequest& request) {
  return std::max(request.known_job_ids_size(), request.loaded_scene_digests_size()) <= kMaxNamedPerLease &&
         request.ByteSizeLong() <= kMaxLeaseBytes;
}

void WorkerLeases::lease(v1::LeaseRequest request, const WorkerOrigin& origin,
                         std::function<bool()> cancelled, Done<v1::LeaseResponse> done) {
  absl::Status status = core_.check_serving();
  if (status.ok()) {
    const std::lock_guard lock(core_.mutex());
    status = workers_.check(request.worker_id(), origin);
  }
  if (!status.ok()) return done(std::move(status));
  if (!names_few(request)) {
    return done(absl::ResourceExhaustedError(
        absl::StrCat("more than ", kMaxNamedPerLease, " jobs or scenes, or too long names, in one call")));
  }
  const auto wait = std::clamp<std::int64_t>(TimeUtil::DurationToMilliseconds(request.max_wait()), 0,
                                             std::int64_t{wire::kMaxLeaseWaitSeconds} * 1000);
  if (try_lease(request, wait == 0, done)) return;
  const std::string worker = request.worker_id();
  core_.dispatcher().park(worker, core_.clock().now() + std::chrono::milliseconds(wait),
                          [this, request = std::move(request), cancelled = std::move(cancelled),
                           done = std::move(done)](bool last) {
                            if (!cancelled()) return try_lease(request, last, done);
                            done(absl::CancelledError("the worker hung up"));
                            return true;
                          });
}

bool WorkerLeases::try_lease(const v1::LeaseRequest& request, bool last,
                             const Done<v1::LeaseResponse>& done) {
  if (absl::Status status = core_.check_serving(); !status.ok()) {
    done(std::move(status));
    return true;
  }
  const TimedCall timed(core_, news::Call::kLease);
  std::unique_lock lock(core_.mutex());
  absl::StatusOr<v1::LeaseResponse> response = grant(request.worker_id(), request);
  if (!response.ok()) {
    lock.unlock();
    done(response.status());
    return true;
  }
  if (response->leases().empty() && !last) return false;
  // No worker may begin before it is durable in which class: after a restart another one could be chosen. The
  // choice may have been that of another call, and on its way.
  const bool binding =
      std::any_of(response->leases().begin(), response->leases().end(), [&](const v1::Lease& lease) {
        return core_.jobs().find(lease.token().job_id())->bounds_under_way > 0;
      });
  if (!binding && !core_.scheduler().has_events()) {
    lock.unlock();
    done(std::move(response));
    return true;
  }
  core_.commit({}, [response = *std::move(response), done](const absl::Status& status) {
    status.ok() ? done(response) : done(status);
  });
  return true;
}

absl::StatusOr<v1::LeaseResponse> WorkerLeases::grant(const std::string& worker,
                                                      const v1::LeaseRequest& request) {
  absl::StatusOr<LeaseDecision> decision = core_.scheduler().lease(
      {.worker = worker,
       .max_units = request.max_units(),
       .loaded_scenes = {request.loaded_scene_digests().begin(), request.loaded_scene_digests().end()}},
      core_.now());
  if (!decision.ok()) return decision.status();
  core_.tell(news::UnitsLeased{decision->leases.size()});
  v1::LeaseResponse response;
  const auto& known = request.known_job_ids();
  for (const std::string& id : known) {
    const JobEntry* const entry = core_.jobs().find(id);
    const bool has_phases = entry == nullptr || entry->shape->spec.cut().phases_size() > 0;
    if (has_phases && (entry == nullptr || entry->past || !is_open(core_.scheduler().job(id)->state)))
      response.add_over_job_ids(id);
  }
  const std::string host = core_.scheduler().host_of(worker);
  for (v1::Lease& lease : decision->leases) {
    const std::string id = lease.token().job_id();
    const JobEntry& entry = *core_.jobs().find(id);
    const PhasePlan& phases = entry.shape->plan->phases();
    for (PhaseBlobs::Made& input : entry.phase_blobs.inputs(phases, lease.unit().index()))
      lease.mutable_unit()->add_inputs()->set_digest(std::move(input.digest));
    seal().seal(*lease.mutable_token(), host);
    if (!response.specs().contains(id) && std::find(known.begin(), known.end(), id) == known.end()) {
      v1::JobSpec& spec = (*response.mutable_specs())[id];
      spec = entry.shape->spec;
      spec.mutable_farm()->set_isa(core_.scheduler().isa_for(worker, id));
    }
    *response.add_leases() = std::move(lease);
  }
  return response;
}

absl::StatusOr<v1::HeartbeatResponse> WorkerLeases::heartbeat(const v1::HeartbeatRequest& request,
                                                              const WorkerOrigin& origin) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return status;
  const TimedCall timed(core_, news::Call::kHeartbeat);
  const std::lock_guard lock(core_.mutex());
  if (absl::Status status = workers_.check(request.worker_id(), origin); !status.ok()) return status;
  absl::StatusOr<v1::HeartbeatResponse> response = beat(request.worker_id(), request);
  if (response.ok()) core_.commit();
  return response;
}

absl::StatusOr<v1::HeartbeatResponse> WorkerLeases::beat(const std::string& worker,
                                                         const v1::HeartbeatRequest& request) {
  if (request.leases_size() > kMaxLeasesPerHeartbeat) {
    return absl::ResourceExhaustedError(
        absl::StrCat("more than ", kMaxLeasesPerHeartbeat, " leases in one call"));
  }
  if (request.resident_bytes() > 0) workers_.note_memory(worker, request.resident_bytes());
  v1::HeartbeatResponse response;
  std::vector<v1::LeaseToken> granted;
  for (const v1::LeaseToken& token : request.leases()) {
    check_granted(worker, token).ok() ? granted.push_back(token)
                                      : static_cast<void>(*response.add_revoked() = token);
  }
  absl::StatusOr<HeartbeatDecision> decision = core_.scheduler().heartbeat(worker, granted, core_.now());
  if (!decision.ok()) return decision.status();
  for (v1::LeaseToken& token : decision->revoked) *response.add_revoked() = std::move(token);
  response.set_drain(decision->drain);
  *response.mutable_heartbeat_interval() =
      TimeUtil::MillisecondsToDuration(core_.scheduler().heartbeat_interval().count());
  return response;
}

absl::Status WorkerLeases::check_granted(const std::string& worker, const v1::LeaseToken& token) const {
  const std::string host = core_.scheduler().host_of(worker);
  if (core_.scheduler().holds(worker, token) || seal().is_sealed(token, host)) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("unit ", token.unit_index(), " of job ", token.job_id(),
                                                    " was not granted to host ", short_name(host),
                                                    " by this lease"));
}

absl::Status WorkerLeases::begin_unit_upload(const v1::UploadRequest& first, const WorkerOrigin& origin) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return status;
  const v1::LeaseToken& token = first.token();
  const std::lock_guard lock(core_.mutex());
  if (absl::Status status = workers_.check(first.worker_id(), origin); !status.ok()) return status;
  const absl::StatusOr<JobEntry*> found = core_.find_job(token.job_id());
  if (!found.ok()) return found.status();
  const JobEntry& entry = **found;
  const auto not_called_for = [&](const char* why) {
    return absl::FailedPreconditionError(
        absl::StrCat("unit ", token.unit_index(), " of job ", entry.id, " calls for no blob: ", why));
  };
  if (entry.shape->plan->is_of_picture(token.unit_index())) return not_called_for("it is not of a phase");
  if (absl::Status status = check_granted(first.worker_id(), token); !status.ok()) return status;
  if (entry.past || !is_open(core_.scheduler().job(entry.id)->state))
    return not_called_for("the job is over");
  if (entry.phase_blobs.made_by(token.unit_index()) && !core_.scheduler().holds(first.worker_id(), token))
    return not_called_for("it is done");
  const std::string identity = identity_of(core_.scheduler().host_of(first.worker_id()));
  return uploads_.begin(token, first.blob(), identity, core_.clock().now());
}

std::vector<std::string> WorkerLeases::take_old_uploads() { return uploads_.take_old(core_.clock().now()); }

}  // namespace tessera::server
