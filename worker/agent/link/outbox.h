// Results on their way home. A result is kept until the coordinator has acknowledged it, through any number
// of restarts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "agent/agent.h"
#include "agent/lease_intake.h"
#include "agent/lease_table.h"
#include "agent/link/heart.h"
#include "agent/link/session.h"
#include "base/clock.h"

namespace tessera::agent {

/// Outcome of a unit.
struct Outcome {
  std::shared_ptr<HeldUnit> unit;
  std::string payload;  // an encoded TileResult, or a BlobRef of `blob`, when rendered
  std::string blob;     // made by a unit of a phase: uploaded before the result is sent
  v1::UnitStats stats;
  absl::Status failure;       // why it could not be rendered
  bool scene_fault = false;   // another worker would fail alike
  bool inputs_fault = false;  // The unit cannot be made of what it reads.
};

/// Thread-safe. Sends from threads of its own; the destructor waits for the call in flight, not for what is
/// queued.
class Outbox {
 public:
  struct Options {
    std::size_t capacity = 1;  // results that may wait
    int senders = 1;           // calls that run at once
    std::function<std::vector<std::string>(const std::string& job_id)> recent_log = {};  // see AgentOptions
  };

  Outbox(base::Clock& clock, CoordinatorLink& link, Session& session, LeaseTable& leases, LeaseIntake& intake,
         Heart& heart, Options options);
  ~Outbox();

  /// Waits while the outbox is full; false when `stop` is requested meanwhile, and the outcome is dropped.
  bool push(Outcome outcome, std::stop_token stop);

  /// Adds what it has delivered, and what it has not.
  void add_to(AgentReport& report) const;

 private:
  void send_all(std::stop_token stop);
  void deliver(Outcome& outcome, std::stop_token stop);
  absl::Status send_once(const Outcome& outcome, const std::string& worker_id, std::stop_token stop);

  CoordinatorLink& link_;
  Session& session_;
  LeaseTable& leases_;
  LeaseIntake& intake_;
  Heart& heart_;
  const Options options_;
  mutable std::mutex mutex_;
  base::Condition filled_, room_;
  std::deque<Outcome> queue_;
  std::uint64_t acknowledged_ = 0;
  std::uint64_t held_results_ = 0, held_bytes_ = 0;  // queued, or on their way
  std::vector<base::Thread> senders_;
};

}  // namespace tessera::agent
