#include "agent/link/heart.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace tessera::agent {
namespace {

/// Memory that this process takes; 0 where the system does not say.
std::uint64_t resident_bytes() {
  std::ifstream statm{"/proc/self/statm"};
  std::uint64_t size = 0, resident = 0;
  if (!(statm >> size >> resident)) return 0;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

Heart::Heart(CoordinatorLink& link, Session& session, LeaseTable& leases, std::stop_source drain)
    : link_(link), session_(session), leases_(leases), drain_(std::move(drain)) {}

void Heart::beat(std::stop_token halt) {
  bool warned = false;
  std::string known;  // the registration that was last heard of
  while (true) {
    const absl::StatusOr<std::string> worker_id = session_.wait_for_beat(known, halt);
    if (!worker_id.ok()) return;
    known = *worker_id;
    const absl::StatusOr<v1::HeartbeatResponse> response = link_.heartbeat(all_held(*worker_id), halt);
    if (response.ok()) {
      obey(*response);
    } else {
      if (absl::IsNotFound(response.status())) session_.lost(*worker_id);
      if (!halt.stop_requested() && !warned) spdlog::warn("{}", response.status().ToString());
    }
    warned = !response.ok();
  }
}

void Heart::introduce(const std::string& worker_id, std::stop_token halt) {
  const v1::HeartbeatRequest request = all_held(worker_id);
  if (request.leases().empty()) return;
  if (const absl::StatusOr<v1::HeartbeatResponse> response = link_.heartbeat(request, halt); response.ok()) {
    obey(*response);
  }
}

v1::HeartbeatRequest Heart::all_held(const std::string& worker_id) const {
  v1::HeartbeatRequest request;
  request.set_worker_id(worker_id);
  request.set_resident_bytes(resident_bytes());
  for (v1::LeaseToken& token : leases_.tokens()) *request.add_leases() = std::move(token);
  return request;
}

bool Heart::ride(const HeldUnit& home, v1::HeartbeatRequest& request) {
  if (!session_.beat_early()) return false;
  request.set_resident_bytes(resident_bytes());
  for (v1::LeaseToken& token : leases_.tokens()) {
    const bool goes_home = token.job_id() == home.job_id && token.generation() == home.job_generation &&
                           token.unit_index() == home.unit.index() &&
                           std::max(token.ranges(), 1u) == home.ranges;
    if (!goes_home) *request.add_leases() = std::move(token);
  }
  return true;
}

void Heart::arrived(const v1::HeartbeatResponse* response) {
  if (response == nullptr) return session_.beat_at_once();
  obey(*response);
}

void Heart::obey(const v1::HeartbeatResponse& response) {
  if (response.has_heartbeat_interval()) session_.set_heartbeat_interval(response.heartbeat_interval());
  const std::vector<v1::LeaseToken> revoked{response.revoked().begin(), response.revoked().end()};
  if (const std::size_t stopped = leases_.revoke(revoked); stopped > 0)
    spdlog::info("{} leases revoked", stopped);
  if (response.drain()) drain_.request_stop();
}

}  // namespace tessera::agent
