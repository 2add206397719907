#include "scheduler/spot_table.h"

#include <algorithm>
#include <utility>

namespace tessera::server {

const SpotCheck* SpotTable::find(std::uint32_t unit) const {
  const auto found = checks_.find(unit);
  return found == checks_.end() ? nullptr : &found->second;
}

void SpotTable::put(std::uint32_t unit, SpotCheck check) {
  checks_[unit] = std::move(check);
  waiting_.insert(unit);
}

void SpotTable::erase(std::uint32_t unit) {
  checks_.erase(unit);
  waiting_.erase(unit);
}

void SpotTable::clear() {
  checks_.clear();
  waiting_.clear();
}

void SpotTable::take(std::uint32_t unit, Time now) {
  checks_.at(unit).since = now;
  waiting_.erase(unit);
}

void SpotTable::ask(std::uint32_t unit, std::string checker, Time now) {
  SpotCheck& check = checks_.at(unit);
  check.checker = std::move(checker);
  check.since = now;
}

void SpotTable::give_back(std::uint32_t unit, const std::string& identity) {
  const auto found = checks_.find(unit);
  if (found == checks_.end()) return;
  found->second.silent.insert(identity);
  waiting_.insert(unit);
}

void Standing::add(Result result) {
  unconfirmed_ += result.units;
  open_.push_back(std::move(result));
}

void Standing::confirm(std::uint32_t up_to) {
  ++confirmations_;
  unanswered_checks = 0;
  std::erase_if(open_, [&](const Result& result) {
    if (result.sequence > up_to) return false;
    unconfirmed_ -= result.units;
    return true;
  });
}

void Standing::forget(std::uint32_t sequence) {
  std::erase_if(open_, [&](const Result& result) {
    if (result.sequence != sequence) return false;
    unconfirmed_ -= result.units;
    return true;
  });
}

}  // namespace tessera::server
