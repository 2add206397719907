#include "scheduler/unit_ledger.h"

#include <algorithm>
#include <cassert>

namespace tessera::server {

UnitLedger::UnitLedger(std::uint32_t count) : states_(count, UnitState::kPending), sequences_(count) {}

void UnitLedger::open_until(std::uint32_t end) {
  assert(end >= open_end_ && end <= count());
  for (; open_end_ < end; ++open_end_) {
    if (states_[open_end_] == UnitState::kPending) ++pending_;
  }
}

void UnitLedger::close_from(std::uint32_t end) {
  while (open_end_ > end) {
    const UnitState state = states_[--open_end_];
    assert(state == UnitState::kPending || state == UnitState::kDone);
    if (state == UnitState::kPending) --pending_;
  }
  first_untouched_ = std::min(first_untouched_, open_end_);
}

std::optional<std::uint32_t> UnitLedger::next_pending() {
  while (!returned_.empty()) {
    const std::uint32_t unit = returned_.top();
    returned_.pop();
    // A unit that was put back twice while it waited here comes up twice in a row.
    while (!returned_.empty() && returned_.top() == unit) returned_.pop();
    // Those that were closed meanwhile come when they are open again.
    if (unit < open_end_ && states_[unit] == UnitState::kPending) return unit;
  }
  while (first_untouched_ < open_end_) {
    const std::uint32_t unit = first_untouched_++;
    if (states_[unit] == UnitState::kPending) return unit;
  }
  return std::nullopt;
}

std::optional<std::uint32_t> UnitLedger::take_pending(const std::function<bool(std::uint32_t)>& suits) {
  std::vector<std::uint32_t> unsuitable;
  std::optional<std::uint32_t> unit = next_pending();
  while (unit && !suits(*unit)) {
    unsuitable.push_back(*unit);
    unit = next_pending();
  }
  for (const std::uint32_t other : unsuitable) returned_.push(other);
  if (unit) take(*unit);
  return unit;
}

std::vector<AcceptedResult> UnitLedger::results() const {
  std::vector<AcceptedResult> counting;
  for (const AcceptedResult& result : results_) {
    const std::uint32_t unit = result.units.first;
    if (result.sequence != 0 && states_[unit] == UnitState::kDone && sequences_[unit] == result.sequence) {
      counting.push_back(result);
    }
  }
  return counting;
}

/// Takes the unit out of the count of its state.
void UnitLedger::leave(std::uint32_t unit) {
  switch (states_[unit]) {
    case UnitState::kPending:
      if (unit < open_end_) --pending_;
      return;
    case UnitState::kDone:
      --done_;
      return;
    case UnitState::kSetAside:
      --set_aside_;
      return;
    case UnitState::kLeased:
      --leased_;
      return;
  }
}

void UnitLedger::take(std::uint32_t unit) {
  assert(unit < open_end_ && states_[unit] == UnitState::kPending);
  leave(unit);
  states_[unit] = UnitState::kLeased;
  ++leased_;
}

void UnitLedger::put_back(std::uint32_t unit) {
  assert(states_[unit] != UnitState::kPending);
  leave(unit);
  states_[unit] = UnitState::kPending;
  if (unit < open_end_) ++pending_;
  if (unit < first_untouched_) returned_.push(unit);
}

void UnitLedger::finish(const AcceptedResult& result) {
  if (results_.size() < result.sequence) results_.resize(result.sequence);
  assert(result.sequence > 0 && results_[result.sequence - 1].sequence == 0);
  results_[result.sequence - 1] = result;
  for (const std::uint32_t unit : result.units) {
    assert(states_[unit] != UnitState::kDone);
    leave(unit);
    states_[unit] = UnitState::kDone;
    sequences_[unit] = result.sequence;
    ++done_;
  }
}

void UnitLedger::set_aside(std::uint32_t unit) {
  assert(states_[unit] != UnitState::kDone);
  leave(unit);
  states_[unit] = UnitState::kSetAside;
  ++set_aside_;
}

}  // namespace tessera::server
