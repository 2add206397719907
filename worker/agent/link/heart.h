// How the coordinator learns that this worker lives, and what it holds.
#pragma once

#include <stop_token>
#include <string>

#include "agent/lease_table.h"
#include "agent/link/coordinator_link.h"
#include "agent/link/session.h"

namespace tessera::agent {

/// Heartbeats go with results that are sent when one is due soon, and by a call of their own otherwise.
/// Thread-safe.
class Heart {
 public:
  /// `drain` is asked to stop when the coordinator wants no more of this worker.
  Heart(CoordinatorLink& link, Session& session, LeaseTable& leases, std::stop_source drain);

  /// Calls whenever it is time, until `halt`, or until the worker is refused.
  void beat(std::stop_token halt);

  /// Tells a coordinator that has started again what is held here, before it gives it to others, or anew and
  /// cut in another way to this worker. Whether it is heard or not, the next heartbeat says the same.
  void introduce(const std::string& worker_id, std::stop_token halt);

  /// Fills in `request` when a heartbeat may go with the result of this unit, which is not held for long any
  /// more; false when none is due soon. What came of it is to be told to arrived().
  bool ride(const HeldUnit& home, v1::HeartbeatRequest& request);
  /// `response` is null when the heartbeat was not taken.
  void arrived(const v1::HeartbeatResponse* response);

 private:
  v1::HeartbeatRequest all_held(const std::string& worker_id) const;
  void obey(const v1::HeartbeatResponse& response);

  CoordinatorLink& link_;
  Session& session_;
  LeaseTable& leases_;
  std::stop_source drain_;
};

}  // namespace tessera::agent
