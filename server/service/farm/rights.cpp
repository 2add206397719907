#include "service/farm/rights.h"

#include <algorithm>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "service/farm/farm_views.h"
#include "telemetry/log.h"

namespace tessera::server {

bool is_allowed(Role role, std::string_view method) {
  const auto is_of = [&](const char* prefix) {
    return absl::StartsWith({method.data(), method.size()}, prefix);
  };
  if (is_of("/grpc.health.v1.Health/")) return true;
  if (is_of("/grpc.reflection.")) return role == Role::kClient || role == Role::kAdmin;
  if (is_of("/tessera.v1.WorkService/")) return role == Role::kWorker;
  // Blobs of phases are for the workers that come after.
  if (is_of("/tessera.v1.BlobService/Upload") || is_of("/tessera.v1.BlobService/QueryUpload"))
    return role != Role::kServer;
  // Clients have what they uploaded; what others did is not theirs to read.
  if (is_of("/tessera.v1.BlobService/Download")) return role == Role::kWorker || role == Role::kAdmin;
  for (const char* for_admins : {"TrustHost", "MakeJoinToken", "Expel"}) {
    if (is_of(absl::StrCat("/tessera.v1.FarmService/", for_admins).c_str())) return role == Role::kAdmin;
  }
  if (is_of("/tessera.v1.FarmService/") || is_of("/tessera.v1.BlobService/")) {
    return role == Role::kClient || role == Role::kAdmin;
  }
  return false;
}

absl::Status Rights::check(const Caller& who, const std::string& peer, const std::string& job) const {
  if (!who.role || share_jobs_) return absl::OkStatus();
  const absl::StatusOr<std::string> owner = views_.owner_of(job);
  if (!owner.ok() || who.may_act_for(*owner)) return owner.status();
  telemetry::log(spdlog::level::warn, {.job = job, .user = who.user, .peer = peer},
                 "refused: '{}' asked for job {} of '{}'", who.user, job, *owner);
  return absl::PermissionDeniedError(absl::StrCat("job ", job, " belongs to another user"));
}

v1::ListJobsResponse Rights::jobs(const Caller& who) const {
  v1::ListJobsResponse response = views_.list_jobs();
  if (sees_all(who)) return response;
  auto& jobs = *response.mutable_jobs();
  jobs.erase(std::remove_if(jobs.begin(), jobs.end(),
                            [&](const v1::JobStatus& job) { return !who.may_act_for(job.user()); }),
             jobs.end());
  return response;
}

v1::ListWorkersResponse Rights::workers(const Caller& who) const {
  v1::ListWorkersResponse response = views_.list_workers();
  if (sees_all(who)) return response;
  for (v1::WorkerStatus& worker : *response.mutable_workers()) {
    for (v1::WorkerJob& job : *worker.mutable_jobs()) {
      if (who.may_act_for(job.user())) continue;
      const std::uint32_t leases = job.leases();
      job.Clear();
      job.set_leases(leases);
    }
  }
  return response;
}

}  // namespace tessera::server
