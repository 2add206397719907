#include "scheduler/unit_ledger.h"

#include <cassert>

namespace tessera::server {

UnitLedger::UnitLedger(std::uint32_t count) : states_(count, UnitState::kPending), results_(count), pending_(count) {}

std::optional<std::uint32_t> UnitLedger::next_pending() {
  while (!returned_.empty()) {
    const std::uint32_t unit = returned_.top();
    returned_.pop();
    // A unit that was put back twice while it waited here comes up twice in a row.
    while (!returned_.empty() && returned_.top() == unit) returned_.pop();
    if (states_[unit] == UnitState::kPending) return unit;
  }
  while (first_untouched_ < count()) {
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

std::vector<std::uint32_t> UnitLedger::done_by(HostNumber host) const {
  std::vector<std::uint32_t> units;
  for (std::uint32_t unit = 0; unit < count(); ++unit) {
    if (states_[unit] == UnitState::kDone && results_[unit].host == host) units.push_back(unit);
  }
  return units;
}

/// Takes the unit out of the count of its state.
void UnitLedger::leave(std::uint32_t unit) {
  switch (states_[unit]) {
    case UnitState::kPending:
      --pending_;
      return;
    case UnitState::kDone:
      --done_;
      return;
    case UnitState::kSetAside:
      --set_aside_;
      return;
    case UnitState::kLeased:
      return;
  }
}

void UnitLedger::take(std::uint32_t unit) {
  assert(states_[unit] == UnitState::kPending);
  leave(unit);
  states_[unit] = UnitState::kLeased;
}

void UnitLedger::put_back(std::uint32_t unit) {
  assert(states_[unit] != UnitState::kPending);
  leave(unit);
  states_[unit] = UnitState::kPending;
  ++pending_;
  if (unit < first_untouched_) returned_.push(unit);
}

void UnitLedger::finish(std::uint32_t unit, const AcceptedResult& result) {
  assert(states_[unit] != UnitState::kDone);
  leave(unit);
  states_[unit] = UnitState::kDone;
  results_[unit] = result;
  ++done_;
}

void UnitLedger::set_aside(std::uint32_t unit) {
  assert(states_[unit] != UnitState::kDone);
  leave(unit);
  states_[unit] = UnitState::kSetAside;
  ++set_aside_;
}

}  // namespace tessera::server
