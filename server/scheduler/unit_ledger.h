// Which units of one job are to do, leased or done.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <queue>
#include <vector>

namespace tessera::server {

enum class UnitState : std::uint8_t { kPending, kLeased, kDone };

/// The first 8 bytes of a result's SHA-256: enough to tell results apart that differ by fault.
using ResultFingerprint = std::uint64_t;

/// Nine bytes a unit. Every operation takes O(log n) amortised over the life of a job.
class UnitLedger {
 public:
  explicit UnitLedger(std::uint32_t count);

  std::uint32_t count() const { return static_cast<std::uint32_t>(states_.size()); }
  std::uint32_t pending() const { return pending_; }
  std::uint32_t done() const { return done_; }
  UnitState state(std::uint32_t unit) const { return states_[unit]; }
  /// Of a unit that is done.
  ResultFingerprint result(std::uint32_t unit) const { return results_[unit]; }

  /// Leases the pending unit of the lowest index that `suits`; none when there is none.
  std::optional<std::uint32_t> take_pending(const std::function<bool(std::uint32_t)>& suits);

  /// A pending unit becomes leased, out of turn.
  void take(std::uint32_t unit);

  /// A leased unit becomes pending again.
  void put_back(std::uint32_t unit);

  /// A unit that is not done becomes done.
  void finish(std::uint32_t unit, ResultFingerprint result);

 private:
  std::optional<std::uint32_t> next_pending();

  std::vector<UnitState> states_;
  std::vector<ResultFingerprint> results_;
  std::uint32_t pending_ = 0;
  std::uint32_t done_ = 0;
  // Units from here on were never taken in turn. Those before that were put back wait in `returned_`, which may
  // also hold units that are not pending any more: they are dropped when they come up.
  std::uint32_t first_untouched_ = 0;
  std::priority_queue<std::uint32_t, std::vector<std::uint32_t>, std::greater<>> returned_;
};

}  // namespace tessera::server
