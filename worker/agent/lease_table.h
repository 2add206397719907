// The units that this worker holds, from the grant of a lease to the acknowledgement of its result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <tuple>
#include <vector>

#include "base/clock.h"
#include "telemetry/log.h"
#include "tessera/v1/work.pb.h"

namespace tessera::agent {

/// A unit in the worker's hands, or a run of them that is rendered as one.
struct HeldUnit {
  v1::WorkUnit unit;
  std::uint32_t ranges = 1;  // number of ranges of the run
  std::string job_id;
  std::uint32_t job_generation = 0;
  std::uint64_t inputs = 0;   // LeaseToken.inputs
  std::uint32_t spot = 0;     // LeaseToken.spot
  std::uint32_t attempt = 0;  // the grant that brought it
  std::shared_ptr<const v1::JobSpec> spec;
  std::stop_source stop;  // requested when the lease is revoked

  telemetry::LogFields log_fields() const {
    return {.job = job_id, .unit = unit.index(), .attempt = attempt};
  }
};

/// Thread-safe. Leases come in by add(), render threads take units with next(), and whoever has brought the
/// unit's result home (or given it up) calls release().
class LeaseTable {
 public:
  explicit LeaseTable(base::Clock& clock) : clock_(clock) {}

  /// Queues one granted unit. A unit that is held already only takes over the newer token: after a restart
  /// the coordinator may grant what this worker never put down. `asked_at`: deliveries() when the answer was
  /// asked for. A unit that was delivered since is left out: it was granted before its result arrived.
  void add(const v1::Lease& lease, std::shared_ptr<const v1::JobSpec> spec,
           std::uint64_t asked_at = ~std::uint64_t{0});

  /// The coordinator has the unit's result.
  void delivered(const HeldUnit& unit);
  /// How many times that was said.
  std::uint64_t deliveries() const;

  /// The oldest unit not begun; waits for one. Null when `stop` is requested.
  std::shared_ptr<HeldUnit> next(std::stop_token stop);

  /// Waits until nothing is queued, and nothing asked for. With `stop` requested it returns at once.
  void wait_until_hungry(std::stop_token stop);

  /// How many units to ask for, so that `full` are queued: none while more than half as many are queued or
  /// asked for already. They count as asked for until answered().
  std::size_t ask(std::size_t full);
  /// Notes that the answer to a request for so many has been added.
  void answered(std::size_t asked);

  /// The current token of a held unit.
  v1::LeaseToken token(const HeldUnit& unit) const;

  /// The unit was not rendered, which the coordinator is about to hear: a grant of it from now on is a fresh
  /// start.
  void give_up(const HeldUnit& unit);

  /// Tokens of everything held.
  std::vector<v1::LeaseToken> tokens() const;

  /// Stops the units with exactly these tokens; those not begun are forgotten. Returns how many there were.
  std::size_t revoke(std::span<const v1::LeaseToken> tokens);

  /// Stops everything that is held, and forgets what was not begun.
  void revoke_all();

  /// Forgets what was not begun, and takes no more. Returns how many units that were.
  std::size_t drop_queued();

  void release(const HeldUnit& unit);

  /// Waits until nothing is held, at most `timeout`; true when nothing is.
  bool wait_until_empty(std::chrono::milliseconds timeout);

 private:
  // Job, generation, unit, ranges, inputs.
  using Key =
      std::tuple<std::string, std::uint32_t, std::uint32_t, std::uint32_t, std::uint64_t, std::uint32_t>;
  struct Entry {
    std::shared_ptr<HeldUnit> held;
    v1::LeaseToken token;
    bool begun = false;
    bool given_up = false;
  };
  static Key key_of(const HeldUnit& unit);
  /// Tells those who wait for nothing to be queued, or held, once they can have the lock.
  void end_change(std::unique_lock<std::mutex> lock);
  void forget_if_queued(std::map<Key, Entry>::iterator entry);

  base::Clock& clock_;
  mutable std::mutex mutex_;
  base::Condition granted_{clock_};  // something is queued
  base::Condition hungry_{clock_};   // nothing is queued, nor asked for
  base::Condition empty_{clock_};    // nothing is held
  std::uint64_t deliveries_ = 0;
  std::map<Key, std::uint64_t> delivered_;  // the latest, numbered
  std::map<Key, Entry> entries_;
  std::deque<Key> queue_;  // leases that are not begun, in the order of their grant
  std::size_t asked_ = 0;
  bool closed_ = false;
};

}  // namespace tessera::agent
