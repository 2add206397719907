#include "service/farm/worker_registry.h"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/printable.h"
#include "scheduler/identity.h"
#include "service/farm/farm_core.h"
#include "wire/arithmetic_class.h"
#include "wire/limits.h"
#include "wire/version.h"

namespace tessera::server {
namespace {

using google::protobuf::util::TimeUtil;

constexpr std::size_t kMaxNameBytes = WorkerRegistry::kMaxNameBytes;
constexpr int kMaxIsas = 16;
constexpr std::size_t kMaxIsaBytes = 32;
constexpr std::size_t kMaxTagBytes = 1024;  // all tags together

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

absl::StatusOr<v1::RegisterResponse> WorkerRegistry::register_worker(const v1::RegisterRequest& request,
                                                                     const WorkerOrigin& origin) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return status;
  if (absl::Status status = check_registration(request); !status.ok()) {
    core_.tell(news::RegistrationRefused{request, origin.peer, status});
    return status;
  }
  v1::RegisterResponse response;
  response.set_worker_id(core_.options().make_identifier(16));
  response.set_epoch(core_.journal().epoch());
  const std::string& id = response.worker_id();
  const std::string host =
      host_named(request.host().empty() ? request.name() : request.host(), origin.fingerprint);
  const std::lock_guard lock(core_.mutex());
  *response.mutable_heartbeat_interval() =
      TimeUtil::MillisecondsToDuration(core_.scheduler().heartbeat_interval().count());
  const absl::Status status = core_.scheduler().register_worker(
      {.id = id,
       .name = request.name(),
       .build = request.build(),
       .isa = request.isa(),
       .supported_isas = {request.supported_isas().begin(), request.supported_isas().end()},
       .threads = request.threads(),
       .host = host,
       .tags = {request.tags().begin(), request.tags().end()},
       .certificate = origin.certificate,
       .peer = origin.peer,
       .classes = {request.arithmetic_classes().begin(), request.arithmetic_classes().end()}},
      core_.now());
  if (!status.ok()) return status;
  registrations_by_worker_[id] = {.account = origin.account};
  core_.tell(news::WorkerRegistered{request, id, core_.scheduler().host_of(id), origin.peer});
  return response;
}

absl::Status WorkerRegistry::deregister(const std::string& worker, const WorkerOrigin& origin) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return status;
  std::string name;
  {
    const std::lock_guard lock(core_.mutex());
    if (absl::Status status = check(worker, origin); !status.ok()) return status;
    name = core_.scheduler().name_of(worker);
    if (absl::Status status = core_.scheduler().deregister_worker(worker); !status.ok()) return status;
    registrations_by_worker_.erase(worker);
  }
  core_.tell(news::WorkerLeft{worker, name});
  core_.dispatcher().notify_work();
  return absl::OkStatus();
}

std::uint32_t WorkerRegistry::expel(const std::string& certificate) {
  std::uint32_t expelled = 0;
  {
    const std::lock_guard lock(core_.mutex());
    for (const WorkerView& worker : core_.scheduler().workers()) {
      const WorkerInfo& info = worker.info;
      if (info.certificate != certificate || !core_.scheduler().deregister_worker(info.id).ok()) continue;
      registrations_by_worker_.erase(info.id);
      ++expelled;
      core_.tell(news::WorkerExpelled{worker});
    }
  }
  core_.dispatcher().notify_work();
  return expelled;
}

void WorkerRegistry::trust_host(const std::string& host, DoneEmpty done) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(core_.mutex());
  if (absl::Status status = core_.scheduler().trust_host(host); !status.ok()) return done(std::move(status));
  core_.commit({}, std::move(done));
  core_.dispatcher().notify_work();
}

absl::Status WorkerRegistry::check(const std::string& worker, const WorkerOrigin& origin) const {
  const std::string host = core_.scheduler().host_of(worker);
  if (host.empty() || (!origin.fingerprint.empty() && identity_of(host) != origin.fingerprint)) {
    return absl::NotFoundError(absl::StrCat("worker ", worker, " is not known; register again"));
  }
  return absl::OkStatus();
}

const WorkerRegistry::Registration* WorkerRegistry::find(const std::string& worker) const {
  const auto found = registrations_by_worker_.find(worker);
  return found == registrations_by_worker_.end() ? nullptr : &found->second;
}

void WorkerRegistry::note_failure(const std::string& worker) {
  const auto known = registrations_by_worker_.find(worker);
  if (known != registrations_by_worker_.end()) ++known->second.failures;
}

void WorkerRegistry::note_memory(const std::string& worker, std::uint64_t resident_bytes) {
  const auto known = registrations_by_worker_.find(worker);
  if (known != registrations_by_worker_.end()) known->second.resident_bytes = resident_bytes;
}

void WorkerRegistry::give_up_lost() {
  const Expiry expiry = core_.scheduler().advance(core_.now());
  for (const WorkerInfo& worker : expiry.lost_workers) {
    registrations_by_worker_.erase(worker.id);
    core_.tell(news::WorkerLost{worker});
  }
  if (expiry.lost_leases > 0) core_.tell(news::LeasesLost{expiry.lost_leases});
}

}  // namespace tessera::server
