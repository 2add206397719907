// The calls of workers but for their results.
#include <google/protobuf/util/time_util.h>

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/printable.h"
#include "scheduler/identity.h"
#include "service/farm/farm.h"
#include "service/farm/worker_calls.h"
#include "service/identifier.h"
#include "telemetry/log.h"
#include "wire/arithmetic_class.h"
#include "wire/limits.h"
#include "wire/version.h"

namespace tessera::server {
namespace {

using google::protobuf::util::TimeUtil;

// A registration stays for as long as its worker, and all of them go into one answer (ListWorkers).
constexpr std::size_t kMaxNameBytes = 256;
constexpr int kMaxIsas = 16;
constexpr std::size_t kMaxIsaBytes = 32;
constexpr std::size_t kMaxTagBytes = 1024;  // of all together
// A worker that took over its leases from an earlier coordinator may hold more than this one would give it.
constexpr int kMaxLeasesPerHeartbeat = 4 * wire::kMaxLeasesPerWorker;
absl::Status check_registration(const v1::RegisterRequest& request) {
  if (request.protocol() != wire::kProtocolVersion) {
    return absl::FailedPreconditionError(absl::StrCat("the worker speaks protocol ", request.protocol(),
                                                      ", the coordinator protocol ", wire::kProtocolVersion));
  }
  if (request.build() != wire::build_version()) {
    return absl::FailedPreconditionError(absl::StrCat("the worker is of build \"", request.build(),
                                                      "\", the coordinator of build \"",
                                                      wire::build_version(), "\""));
  }
  if (request.name().size() > kMaxNameBytes || request.supported_isas_size() > kMaxIsas) {
    return absl::InvalidArgumentError("the name is too long, or there are too many ISAs");
  }
  const auto& isas = request.supported_isas();
  if (std::find(isas.begin(), isas.end(), request.isa()) == isas.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat("ISA \"", request.isa(), "\" is not among those supported"));
  }
  if (std::any_of(isas.begin(), isas.end(), [](const std::string& isa) { return isa.size() > kMaxIsaBytes; }))
    return absl::InvalidArgumentError("the name of an ISA is too long");
  const auto& classes = request.arithmetic_classes();
  const auto is_of = [](const std::string& name, const std::string& isa) {
    return wire::isa_of(name) == isa;
  };
  const auto is_long = [](const std::string& name) { return name.size() > kMaxNameBytes; };
  if (!std::equal(classes.begin(), classes.end(), isas.begin(), isas.end(), is_of) ||
      std::any_of(classes.begin(), classes.end(), is_long)) {
    return absl::InvalidArgumentError(
        "expected one arithmetic class, ISA/..., for each ISA that is supported");
  }
  std::size_t tag_bytes = 0;
  for (const std::string& tag : request.tags()) tag_bytes += tag.size() + 1;
  if (request.host().size() > kMaxNameBytes || tag_bytes > kMaxTagBytes) {
    return absl::InvalidArgumentError("the host is too long, or the tags are");
  }
  if (request.name().empty() && request.host().empty()) {
    return absl::InvalidArgumentError("a worker has a name, or says on which host it is");
  }
  const auto is_plain = [](const std::string& name) { return base::printable(name) == name; };
  if (!is_plain(request.name()) || !is_plain(request.host()) ||
      !std::all_of(request.tags().begin(), request.tags().end(), is_plain)) {
    return absl::InvalidArgumentError("the name, the host or a tag has a control character");
  }
  if (request.threads() == 0 || request.threads() > wire::kMaxLeasesPerWorker) {
    return absl::InvalidArgumentError(absl::StrCat("the worker has ", request.threads(), " threads; 1 to ",
                                                   wire::kMaxLeasesPerWorker, " were expected"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::RegisterResponse> Farm::register_worker(const v1::RegisterRequest& request,
                                                           const Origin& origin) {
  if (absl::Status status = check_serving(); !status.ok()) return status;
  if (absl::Status status = check_registration(request); !status.ok()) {
    const std::string name = request.name().substr(0, kMaxNameBytes);
    telemetry::log(spdlog::level::warn, {.worker = name, .peer = origin.peer}, "worker {} refused: {}", name,
                   std::string(status.message()));
    return status;
  }
  v1::RegisterResponse response;
  response.set_worker_id(random_identifier(16));
  response.set_epoch(journal_.epoch());
  const std::lock_guard lock(mutex_);
  *response.mutable_heartbeat_interval() =
      TimeUtil::MillisecondsToDuration(scheduler_.heartbeat_interval().count());
  const absl::Status status = scheduler_.register_worker(
      {.id = response.worker_id(),
       .name = request.name(),
       .build = request.build(),
       .isa = request.isa(),
       .supported_isas = {request.supported_isas().begin(), request.supported_isas().end()},
       .threads = request.threads(),
       .host = host_named(request.host().empty() ? request.name() : request.host(), origin.fingerprint),
       .tags = {request.tags().begin(), request.tags().end()},
       .certificate = origin.certificate,
       .peer = origin.peer,
       .classes = {request.arithmetic_classes().begin(), request.arithmetic_classes().end()}},
      now());
  if (!status.ok()) return status;
  registrations_by_worker_[response.worker_id()] = {.account = origin.account};
  telemetry::log(
      spdlog::level::info,
      {.worker = request.name(), .host = scheduler_.host_of(response.worker_id()), .peer = origin.peer},
      "worker {} ({}, {} threads) registered as {}", request.name(),
      absl::StrJoin(request.arithmetic_classes(), " "), request.threads(), response.worker_id());
  return response;
}

absl::Status Farm::check_worker(const std::string& worker, const Origin& origin) const {
  const std::string host = scheduler_.host_of(worker);
  if (host.empty() || (!origin.fingerprint.empty() && identity_of(host) != origin.fingerprint)) {
    return absl::NotFoundError(absl::StrCat("worker ", worker, " is not known; register again"));
  }
  return absl::OkStatus();
}

absl::Status Farm::check_granted(const std::string& worker, const v1::LeaseToken& token) const {
  const std::string host = scheduler_.host_of(worker);
  if (scheduler_.holds(worker, token) || seal_->is_sealed(token, host)) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("unit ", token.unit_index(), " of job ", token.job_id(),
                                                    " was not granted to host ", short_name(host),
                                                    " by this lease"));
}

// ---------------------------------------------------------------- leases

void Farm::lease(v1::LeaseRequest request, const Origin& origin, std::function<bool()> cancelled,
                 Done<v1::LeaseResponse> done) {
  absl::Status status = check_serving();
  if (status.ok()) {
    const std::lock_guard lock(mutex_);
    status = check_worker(request.worker_id(), origin);
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
  dispatcher_.park(worker, clock_.now() + std::chrono::milliseconds(wait),
                   [this, request = std::move(request), cancelled = std::move(cancelled),
                    done = std::move(done)](bool last) {
                     if (!cancelled()) return try_lease(request, last, done);
                     done(absl::CancelledError("the worker hung up"));
                     return true;
                   });
}

bool Farm::try_lease(const v1::LeaseRequest& request, bool last, const Done<v1::LeaseResponse>& done) {
  if (absl::Status status = check_serving(); !status.ok()) {
    done(std::move(status));
    return true;
  }
  const Served served(metrics_, FarmMetrics::Call::kLease);
  std::unique_lock lock(mutex_);
  absl::StatusOr<v1::LeaseResponse> response = grant(request.worker_id(), request);
  if (!response.ok()) {
    lock.unlock();
    done(response.status());
    return true;
  }
  if (response->leases().empty() && !last) return false;
  // No worker may begin before it is durable in which class: after a restart another one could be chosen. The
  // choice may have been that of another call, and on its way.
  const bool binding = std::any_of(
      response->leases().begin(), response->leases().end(),
      [&](const v1::Lease& lease) { return jobs_.find(lease.token().job_id())->bounds_under_way > 0; });
  if (!binding && !scheduler_.has_events()) {
    lock.unlock();
    done(std::move(response));
    return true;
  }
  commit({}, {}, /*wait=*/true, [response = *std::move(response), done](const absl::Status& status) {
    status.ok() ? done(response) : done(status);
  });
  return true;
}

std::vector<PhaseBlobs::Made> Farm::lost(std::vector<PhaseBlobs::Made> blobs) const {
  std::erase_if(blobs, [&](const PhaseBlobs::Made& made) { return blobs_.query(made.digest).complete; });
  return blobs;
}

absl::StatusOr<v1::LeaseResponse> Farm::grant(const std::string& worker, const v1::LeaseRequest& request) {
  absl::StatusOr<LeaseDecision> decision = scheduler_.lease(
      {.worker = worker,
       .max_units = request.max_units(),
       .loaded_scenes = {request.loaded_scene_digests().begin(), request.loaded_scene_digests().end()}},
      now());
  if (!decision.ok()) return decision.status();
  metrics_.leased(decision->leases.size());
  v1::LeaseResponse response;
  const auto& known = request.known_job_ids();
  for (const std::string& id : known) {
    const JobEntry* const entry = jobs_.find(id);
    const bool has_phases = entry == nullptr || entry->shape->spec.cut().phases_size() > 0;
    if (has_phases && (entry == nullptr || entry->past || !is_open(scheduler_.job(id)->state)))
      response.add_over_job_ids(id);
  }
  const std::string host = scheduler_.host_of(worker);
  for (v1::Lease& lease : decision->leases) {
    const std::string id = lease.token().job_id();
    const JobEntry& entry = *jobs_.find(id);
    const PhasePlan& phases = entry.shape->plan->phases();
    for (PhaseBlobs::Made& input : entry.phase_blobs.inputs(phases, lease.unit().index()))
      lease.mutable_unit()->add_inputs()->set_digest(std::move(input.digest));
    seal_->seal(*lease.mutable_token(), host);
    if (!response.specs().contains(id) && std::find(known.begin(), known.end(), id) == known.end()) {
      v1::JobSpec& spec = (*response.mutable_specs())[id];
      spec = entry.shape->spec;
      spec.mutable_farm()->set_isa(scheduler_.isa_for(worker, id));
    }
    *response.add_leases() = std::move(lease);
  }
  return response;
}

absl::StatusOr<v1::HeartbeatResponse> Farm::heartbeat(const v1::HeartbeatRequest& request,
                                                      const Origin& origin) {
  if (absl::Status status = check_serving(); !status.ok()) return status;
  const Served served(metrics_, FarmMetrics::Call::kHeartbeat);
  const std::lock_guard lock(mutex_);
  if (absl::Status status = check_worker(request.worker_id(), origin); !status.ok()) return status;
  absl::StatusOr<v1::HeartbeatResponse> response = beat(request.worker_id(), request);
  if (response.ok()) commit({}, {}, /*wait=*/false, [](const absl::Status&) {});
  return response;
}

absl::StatusOr<v1::HeartbeatResponse> Farm::beat(const std::string& worker,
                                                 const v1::HeartbeatRequest& request) {
  if (request.leases_size() > kMaxLeasesPerHeartbeat) {
    return absl::ResourceExhaustedError(
        absl::StrCat("more than ", kMaxLeasesPerHeartbeat, " leases in one call"));
  }
  if (const auto known = registrations_by_worker_.find(worker);
      known != registrations_by_worker_.end() && request.resident_bytes() > 0)
    known->second.resident_bytes = request.resident_bytes();
  v1::HeartbeatResponse response;
  std::vector<v1::LeaseToken> granted;
  for (const v1::LeaseToken& token : request.leases()) {
    check_granted(worker, token).ok() ? granted.push_back(token)
                                      : static_cast<void>(*response.add_revoked() = token);
  }
  absl::StatusOr<HeartbeatDecision> decision = scheduler_.heartbeat(worker, granted, now());
  if (!decision.ok()) return decision.status();
  for (v1::LeaseToken& token : decision->revoked) *response.add_revoked() = std::move(token);
  response.set_drain(decision->drain);
  *response.mutable_heartbeat_interval() =
      TimeUtil::MillisecondsToDuration(scheduler_.heartbeat_interval().count());
  return response;
}

absl::Status Farm::deregister(const std::string& worker, const Origin& origin) {
  if (absl::Status status = check_serving(); !status.ok()) return status;
  std::string name;
  {
    const std::lock_guard lock(mutex_);
    if (absl::Status status = check_worker(worker, origin); !status.ok()) return status;
    name = scheduler_.name_of(worker);
    if (absl::Status status = scheduler_.deregister_worker(worker); !status.ok()) return status;
    registrations_by_worker_.erase(worker);
  }
  telemetry::log(spdlog::level::info, {.worker = name}, "worker {} ({}) left", name, worker);
  dispatcher_.notify_work();
  return absl::OkStatus();
}

absl::Status Farm::begin_unit_upload(const v1::UploadRequest& first, const Origin& origin) {
  if (absl::Status status = check_serving(); !status.ok()) return status;
  const v1::LeaseToken& token = first.token();
  const std::lock_guard lock(mutex_);
  if (absl::Status status = check_worker(first.worker_id(), origin); !status.ok()) return status;
  const absl::StatusOr<JobEntry*> found = find_job(token.job_id());
  if (!found.ok()) return found.status();
  const JobEntry& entry = **found;
  const auto not_called_for = [&](const char* why) {
    return absl::FailedPreconditionError(
        absl::StrCat("unit ", token.unit_index(), " of job ", entry.id, " calls for no blob: ", why));
  };
  if (entry.shape->plan->is_of_picture(token.unit_index())) return not_called_for("it is not of a phase");
  if (absl::Status status = check_granted(first.worker_id(), token); !status.ok()) return status;
  if (entry.past || !is_open(scheduler_.job(entry.id)->state)) return not_called_for("the job is over");
  if (entry.phase_blobs.made_by(token.unit_index()) && !scheduler_.holds(first.worker_id(), token))
    return not_called_for("it is done");
  const std::string identity = identity_of(scheduler_.host_of(first.worker_id()));
  return lease_uploads_.begin(token, first.blob(), identity, clock_.now());
}

std::uint32_t Farm::expel(const std::string& certificate) {
  std::uint32_t expelled = 0;
  {
    const std::lock_guard lock(mutex_);
    for (const WorkerView& worker : scheduler_.workers()) {
      const WorkerInfo& info = worker.info;
      if (info.certificate != certificate || !scheduler_.deregister_worker(info.id).ok()) continue;
      registrations_by_worker_.erase(info.id);
      ++expelled;
      telemetry::log(spdlog::level::warn,
                     {.worker = info.name, .host = info.host, .user = certificate, .peer = info.peer},
                     "worker {} ({}) is expelled; its {} leases go to others", info.name, info.id,
                     worker.leases);
    }
  }
  dispatcher_.notify_work();
  return expelled;
}

void Farm::tick() {
  const Served served(metrics_, FarmMetrics::Call::kTick);
  const std::lock_guard lock(mutex_);
  const Expiry expiry = scheduler_.advance(now());
  for (const WorkerInfo& worker : expiry.lost_workers) {
    registrations_by_worker_.erase(worker.id);
    telemetry::log(spdlog::level::warn, {.worker = worker.name, .host = worker.host},
                   "worker {} ({}) was lost", worker.name, worker.id);
  }
  metrics_.lost(expiry.lost_leases);
  if (expiry.lost_leases > 0)
    spdlog::warn("{} leases expired; their units go to other workers", expiry.lost_leases);
  commit({}, {}, /*wait=*/false, [](const absl::Status&) {});
  retire_jobs();
  if (keeper_.is_due()) prune();
}

}  // namespace tessera::server
