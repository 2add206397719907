// Who is told when jobs end.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

/// Both calls are made while others wait: they return at once. From any thread.
class EndListener {
 public:
  virtual ~EndListener() = default;
  /// Whether a job may have this URL as its webhook. PermissionDenied where the coordinator does not allow
  /// it.
  virtual absl::Status check_webhook(const std::string& url) const = 0;
  /// A job ended, and that is durable. `webhook`: its own; may be empty.
  virtual void ended(const v1::JobStatus& status, const std::string& webhook) = 0;
};

}  // namespace tessera::server
