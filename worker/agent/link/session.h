// The worker's registration with the coordinator, renewed whenever the coordinator no longer knows it.
#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "agent/link/coordinator_link.h"
#include "base/clock.h"

namespace tessera::agent {

/// Thread-safe.
class Session {
 public:
  /// Says what this worker holds already, before anybody is told that it is registered by this id.
  using Introduce = std::function<void(const std::string& worker_id, std::stop_token stop)>;

  Session(base::Clock& clock, CoordinatorLink& link, v1::RegisterRequest request, Introduce introduce);

  /// The worker's id; registers first when there is none, and goes on trying while the coordinator cannot be
  /// reached. Cancelled when `stop` is requested; any other error is final: the coordinator refuses this
  /// worker, or the address is none of a coordinator.
  absl::StatusOr<std::string> worker_id(std::stop_token stop);

  /// The coordinator does not know `worker_id`: the next caller of worker_id() registers again.
  void lost(const std::string& worker_id);

  /// The id, or empty when there is none now.
  std::string current() const;

  /// The worker's id, when it is time for a heartbeat: as often as the coordinator wants to hear from the
  /// worker, and at once for an id other than `known`. Otherwise as worker_id().
  absl::StatusOr<std::string> wait_for_beat(const std::string& known, std::stop_token stop);
  /// Whether a heartbeat may go out with another call now, for half of the interval is over; the next one is
  /// due an interval later.
  bool beat_early();
  /// That heartbeat did not arrive.
  void beat_at_once();
  /// How often the coordinator wants to hear from the worker from now on.
  void set_heartbeat_interval(const google::protobuf::Duration& interval);

 private:
  absl::StatusOr<v1::RegisterResponse> register_until_heard(bool registered_before, std::stop_token stop);

  base::Clock& clock_;
  CoordinatorLink& link_;
  const v1::RegisterRequest request_;
  const Introduce introduce_;
  mutable std::mutex mutex_;
  base::Condition changed_{clock_};
  bool registering_ = false;
  bool registered_before_ = false;
  std::string worker_id_;
  absl::Status refused_;
  std::chrono::milliseconds heartbeat_interval_{1000};
  base::Clock::TimePoint last_beat_;
};

}  // namespace tessera::agent
