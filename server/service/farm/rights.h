// The rights of a caller of the farm, to see and to change: the same for calls of gRPC and for the web page.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "service/farm/caller.h"
#include "tessera/v1/farm.pb.h"
#include "tls/role.h"

namespace tessera::server {

class FarmViews;

/// Whether a role is for a method, named as gRPC does: "/tessera.v1.FarmService/CancelJob".
bool is_allowed(Role role, std::string_view method);

/// Each sees and changes its own jobs, administrators all; with `share_jobs`, everybody all. The farm must
/// outlive this.
class Rights {
 public:
  Rights(const FarmViews& views, bool share_jobs) : views_(views), share_jobs_(share_jobs) {}

  bool sees_all(const Caller& who) const { return !who.role || share_jobs_ || who.role == Role::kAdmin; }
  /// NotFound for a job that is not there, PermissionDenied, logged with the address `peer`, for one that is
  /// not the caller's.
  absl::Status check(const Caller& who, const std::string& peer, const std::string& job) const;
  /// The jobs that the caller may see.
  v1::ListJobsResponse jobs(const Caller& who) const;
  /// All workers; of jobs that are not the caller's to see, only how many units they hold.
  v1::ListWorkersResponse workers(const Caller& who) const;

 private:
  const FarmViews& views_;
  const bool share_jobs_;
};

}  // namespace tessera::server
