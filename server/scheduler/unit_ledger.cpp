#include "scheduler/unit_ledger.h"

#include <cassert>

namespace tessera::server {

UnitLedger::UnitLedger(std::uint32_t count)
    : states_(count, UnitState::kPending), results_(count, 0), pending_(count) {}

std::optional<std::uint32_t> UnitLedger::next_pending() {
  while (!returned_.empty()) {
    const std::uint32_t unit = returned_.top();
    returned_.pop();
    if (states_[unit] == UnitState::kPending) return unit;
  }
  while (first_untouched_ < count()) {
    const std::uint32_t unit = first_untouched_++;
    if (states_[unit] == UnitState::kPending) return unit;
  }
  return std::nullopt;
}

std::optional<std::uint32_t> UnitLedger::take_pending(const std::function<bool(std::uint32_t)>& suits) {
  std::vector<std::uint32_t> set_aside;
  std::optional<std::uint32_t> unit = next_pending();
  while (unit && !suits(*unit)) {
    set_aside.push_back(*unit);
    unit = next_pending();
  }
  for (const std::uint32_t aside : set_aside) returned_.push(aside);
  if (unit) take(*unit);
  return unit;
}

void UnitLedger::take(std::uint32_t unit) {
  assert(states_[unit] == UnitState::kPending);
  states_[unit] = UnitState::kLeased;
  --pending_;
}

void UnitLedger::put_back(std::uint32_t unit) {
  assert(states_[unit] == UnitState::kLeased);
  states_[unit] = UnitState::kPending;
  ++pending_;
  if (unit < first_untouched_) returned_.push(unit);
}

void UnitLedger::finish(std::uint32_t unit, ResultFingerprint result) {
  assert(states_[unit] != UnitState::kDone);
  if (states_[unit] == UnitState::kPending) --pending_;
  states_[unit] = UnitState::kDone;
  results_[unit] = result;
  ++done_;
}

}  // namespace tessera::server
