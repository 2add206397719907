// Which units of one job are to do, leased, done or set aside.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <queue>
#include <vector>

#include "scheduler/unit_run.h"

namespace tessera::server {

enum class UnitState : std::uint8_t { kPending, kLeased, kDone, kSetAside };

/// The first 8 bytes of a result's SHA-256: enough to tell results apart that differ by fault.
using ResultFingerprint = std::uint64_t;

/// Hosts by number: what a ledger says of who made a result.
using HostNumber = std::uint32_t;

/// A result that was accepted.
struct AcceptedResult {
  ResultFingerprint fingerprint = 0;
  std::uint32_t sequence = 0;  // number within the job, from 1
  HostNumber host = 0;
  UnitRun units = {};  // units that it covers
};

/// Units up to an end are open: those that are pending may be taken. The others wait until it is moved.
/// Units are kept in pages that are made when one of their units is first anything but pending: 5 bytes a
/// unit of these, and 32 a result. Every operation takes O(log n) a unit, amortised over the life of a job,
/// but for `results`; to open units takes O(1) a page.
class UnitLedger {
 public:
  /// All units are closed.
  explicit UnitLedger(std::uint32_t count);

  std::uint32_t count() const { return count_; }
  /// Units below it are open.
  std::uint32_t open_end() const { return open_end_; }
  /// Moves that up; units that were not closed before are as they were.
  void open_until(std::uint32_t end);
  /// Moves it down. Units from there on must be pending or done.
  void close_from(std::uint32_t end);

  /// Open units that nobody has begun with.
  std::uint32_t pending() const { return pending_; }
  std::uint32_t leased() const { return leased_; }
  std::uint32_t done() const { return done_; }
  std::uint32_t set_aside() const { return set_aside_; }
  /// Every open unit is done or set aside.
  bool settled() const { return pending_ == 0 && leased_ == 0; }
  UnitState state(std::uint32_t unit) const {
    const Page* const page = pages_[unit / kPageUnits].get();
    return page == nullptr ? UnitState::kPending : page->states[unit % kPageUnits];
  }
  /// Result of a unit that is done.
  const AcceptedResult& result(std::uint32_t unit) const {
    return results_by_sequence_[sequence_of(unit) - 1];
  }
  /// Returns the results that count, by sequence number. Looks at every result; for events that are rare.
  std::vector<AcceptedResult> results() const;

  /// Leases the pending unit of the lowest index that `suits`; none when there is none.
  std::optional<std::uint32_t> take_pending(const std::function<bool(std::uint32_t)>& suits);

  /// A pending unit becomes leased, out of turn.
  void take(std::uint32_t unit);

  /// A unit that is leased, done or set aside becomes pending again.
  void put_back(std::uint32_t unit);

  /// Units that are not done become done: those of the result, whose number was not there before.
  void finish(const AcceptedResult& result);

  /// A unit that is not done is not given out any more.
  void set_aside(std::uint32_t unit);

 private:
  static constexpr std::uint32_t kPageUnits = 4096;
  struct Page {
    explicit Page(std::uint32_t count) : states(count, UnitState::kPending), result_sequences(count) {}
    std::vector<UnitState> states;
    std::vector<std::uint32_t> result_sequences;  // set for units that are done
  };

  std::uint32_t sequence_of(std::uint32_t unit) const {
    return pages_[unit / kPageUnits]->result_sequences[unit % kPageUnits];
  }
  /// The page of a unit that changes.
  Page& page_of(std::uint32_t unit);
  void set(std::uint32_t unit, UnitState state) { page_of(unit).states[unit % kPageUnits] = state; }
  std::optional<std::uint32_t> next_pending();
  void leave(std::uint32_t unit);

  std::uint32_t count_;
  std::vector<std::unique_ptr<Page>> pages_;
  std::vector<AcceptedResult> results_by_sequence_;  // index: sequence number - 1; some are revoked
  std::uint32_t open_end_ = 0;
  std::uint32_t pending_ = 0;  // open ones
  std::uint32_t leased_ = 0;
  std::uint32_t done_ = 0;
  std::uint32_t set_aside_ = 0;
  // Units from here on were never taken in turn. Those before that were put back wait in `returned_`, which
  // may also hold units that are not pending any more: they are dropped when they come up.
  std::uint32_t first_untouched_ = 0;
  std::priority_queue<std::uint32_t, std::vector<std::uint32_t>, std::greater<>> returned_;
};

}  // namespace tessera::server
