#include "scheduler/unit_ledger.h"

#include <algorithm>
#include <cassert>

namespace tessera::server {

UnitLedger::UnitLedger(std::uint32_t count)
    : count_(count), pages_((std::size_t{count} + kPageUnits - 1) / kPageUnits) {}

UnitLedger::Page& UnitLedger::page_of(std::uint32_t unit) {
  const std::uint32_t number = unit / kPageUnits;
  std::unique_ptr<Page>& page = pages_[number];
  if (page == nullptr) page = std::make_unique<Page>(std::min(kPageUnits, count_ - number * kPageUnits));
  return *page;
}

void UnitLedger::open_until(std::uint32_t end) {
  assert(end >= open_end_ && end <= count());
  while (open_end_ < end) {
    const std::uint32_t number = open_end_ / kPageUnits;
    const std::uint32_t page_end = std::min(end, (number + 1) * kPageUnits);
    std::uint32_t pending = page_end - open_end_;
    if (const Page* const page = pages_[number].get(); page != nullptr) {
      const auto first = page->states.begin() + open_end_ % kPageUnits;
      pending = static_cast<std::uint32_t>(std::count(first, first + pending, UnitState::kPending));
    }
    pending_ += pending;
    open_end_ = page_end;
  }
}

void UnitLedger::close_from(std::uint32_t end) {
  while (open_end_ > end) {
    const UnitState state = this->state(--open_end_);
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
    // Units that were closed meanwhile come when they are open again.
    if (unit < open_end_ && state(unit) == UnitState::kPending) return unit;
  }
  while (first_untouched_ < open_end_) {
    const std::uint32_t unit = first_untouched_++;
    if (state(unit) == UnitState::kPending) return unit;
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
  for (const AcceptedResult& result : results_by_sequence_) {
    const std::uint32_t unit = result.units.first;
    if (result.sequence != 0 && state(unit) == UnitState::kDone && sequence_of(unit) == result.sequence) {
      counting.push_back(result);
    }
  }
  return counting;
}

/// Takes the unit out of the count of its state.
void UnitLedger::leave(std::uint32_t unit) {
  switch (state(unit)) {
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
  assert(unit < open_end_ && state(unit) == UnitState::kPending);
  leave(unit);
  set(unit, UnitState::kLeased);
  ++leased_;
}

void UnitLedger::put_back(std::uint32_t unit) {
  assert(state(unit) != UnitState::kPending);
  leave(unit);
  set(unit, UnitState::kPending);
  if (unit < open_end_) ++pending_;
  if (unit < first_untouched_) returned_.push(unit);
}

void UnitLedger::finish(const AcceptedResult& result) {
  if (results_by_sequence_.size() < result.sequence) results_by_sequence_.resize(result.sequence);
  assert(result.sequence > 0 && results_by_sequence_[result.sequence - 1].sequence == 0);
  results_by_sequence_[result.sequence - 1] = result;
  for (const std::uint32_t unit : result.units) {
    assert(state(unit) != UnitState::kDone);
    leave(unit);
    set(unit, UnitState::kDone);
    page_of(unit).result_sequences[unit % kPageUnits] = result.sequence;
    ++done_;
  }
}

void UnitLedger::set_aside(std::uint32_t unit) {
  assert(state(unit) != UnitState::kDone);
  leave(unit);
  set(unit, UnitState::kSetAside);
  ++set_aside_;
}

}  // namespace tessera::server
