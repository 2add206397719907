#include "agent/lease_table.h"

#include <algorithm>
#include <utility>

namespace tessera::agent {
namespace {

std::uint32_t ranges_of(const v1::LeaseToken& token) { return std::max(token.ranges(), 1u); }

bool same_token(const v1::LeaseToken& a, const v1::LeaseToken& b) {
  return a.job_id() == b.job_id() && a.generation() == b.generation() && a.unit_index() == b.unit_index() &&
         a.attempt() == b.attempt() && a.epoch() == b.epoch() && ranges_of(a) == ranges_of(b);
}

}  // namespace

LeaseTable::Key LeaseTable::key_of(const HeldUnit& unit) {
  return {unit.job_id, unit.job_generation, unit.unit.index(), unit.ranges, unit.inputs, unit.spot};
}

void LeaseTable::add(const v1::Lease& lease, std::shared_ptr<const v1::JobSpec> spec,
                     std::uint64_t asked_at) {
  auto held = std::make_shared<HeldUnit>();
  held->unit = lease.unit();
  held->job_id = lease.token().job_id();
  held->job_generation = lease.token().generation();
  held->attempt = lease.token().attempt();
  held->ranges = ranges_of(lease.token());
  held->inputs = lease.token().inputs();
  held->spot = lease.token().spot();
  held->spec = std::move(spec);

  std::unique_lock lock{mutex_};
  if (closed_) return;
  Key key = key_of(*held);
  if (const auto before = delivered_.find(key); before != delivered_.end() && before->second > asked_at)
    return;
  if (const auto found = entries_.find(key); found != entries_.end()) {
    const bool on_its_way_out = found->second.given_up || found->second.held->stop.stop_requested();
    if (!on_its_way_out) {
      found->second.token = lease.token();
      return;
    }
    entries_.erase(found);
  }
  entries_.emplace(key, Entry{std::move(held), lease.token()});
  queue_.push_back(std::move(key));
  lock.unlock();
  granted_.notify_one();
}

std::shared_ptr<HeldUnit> LeaseTable::next(std::stop_token stop) {
  std::unique_lock lock{mutex_};
  if (!granted_.wait(lock, stop, [this] { return !queue_.empty(); })) return nullptr;
  if (stop.stop_requested()) return nullptr;
  Entry& entry = entries_.at(queue_.front());
  queue_.pop_front();
  entry.begun = true;
  std::shared_ptr<HeldUnit> held = entry.held;
  end_change(std::move(lock));
  return held;
}

void LeaseTable::wait_until_hungry(std::stop_token stop) {
  std::unique_lock lock{mutex_};
  hungry_.wait(lock, stop, [&] { return queue_.empty() && asked_ == 0; });
}

std::size_t LeaseTable::ask(std::size_t full) {
  std::lock_guard lock{mutex_};
  const std::size_t expected = queue_.size() + asked_;
  if (closed_ || expected > full / 2) return 0;
  asked_ += full - expected;
  return full - expected;
}

void LeaseTable::answered(std::size_t asked) {
  std::unique_lock lock{mutex_};
  asked_ -= asked;
  end_change(std::move(lock));
}

v1::LeaseToken LeaseTable::token(const HeldUnit& unit) const {
  std::lock_guard lock{mutex_};
  const auto found = entries_.find(key_of(unit));
  if (found != entries_.end() && found->second.held.get() == &unit) return found->second.token;
  v1::LeaseToken token;  // released meanwhile, or granted anew: only the unit's name is left
  token.set_job_id(unit.job_id);
  token.set_generation(unit.job_generation);
  token.set_unit_index(unit.unit.index());
  token.set_ranges(unit.ranges);
  token.set_inputs(unit.inputs);
  token.set_spot(unit.spot);
  return token;
}

void LeaseTable::delivered(const HeldUnit& unit) {
  // Answers that were asked for before can tell of no more.
  constexpr std::size_t kRemembered = 4096;
  std::lock_guard lock{mutex_};
  delivered_[key_of(unit)] = ++deliveries_;
  if (delivered_.size() <= 2 * kRemembered) return;
  std::erase_if(delivered_, [&](const auto& one) { return one.second + kRemembered <= deliveries_; });
}

std::uint64_t LeaseTable::deliveries() const {
  std::lock_guard lock{mutex_};
  return deliveries_;
}

void LeaseTable::give_up(const HeldUnit& unit) {
  std::lock_guard lock{mutex_};
  const auto found = entries_.find(key_of(unit));
  if (found != entries_.end() && found->second.held.get() == &unit) found->second.given_up = true;
}

std::vector<v1::LeaseToken> LeaseTable::tokens() const {
  std::lock_guard lock{mutex_};
  std::vector<v1::LeaseToken> tokens;
  tokens.reserve(entries_.size());
  for (const auto& [key, entry] : entries_) tokens.push_back(entry.token);
  return tokens;
}

std::size_t LeaseTable::revoke(std::span<const v1::LeaseToken> tokens) {
  std::unique_lock lock{mutex_};
  std::size_t revoked = 0;
  for (const v1::LeaseToken& token : tokens) {
    const auto found = entries_.find(Key{token.job_id(), token.generation(), token.unit_index(),
                                         ranges_of(token), token.inputs(), token.spot()});
    if (found == entries_.end() || !same_token(found->second.token, token)) continue;
    found->second.held->stop.request_stop();
    forget_if_queued(found);
    ++revoked;
  }
  end_change(std::move(lock));
  return revoked;
}

void LeaseTable::revoke_all() {
  std::unique_lock lock{mutex_};
  for (auto& [key, entry] : entries_) entry.held->stop.request_stop();
  std::erase_if(entries_, [](const auto& item) { return !item.second.begun; });
  queue_.clear();
  end_change(std::move(lock));
}

std::size_t LeaseTable::drop_queued() {
  std::unique_lock lock{mutex_};
  closed_ = true;
  const std::size_t dropped = queue_.size();
  std::erase_if(entries_, [](const auto& item) { return !item.second.begun; });
  queue_.clear();
  end_change(std::move(lock));
  return dropped;
}

void LeaseTable::release(const HeldUnit& unit) {
  std::unique_lock lock{mutex_};
  const auto found = entries_.find(key_of(unit));
  // A revoked unit may have been granted anew; that grant is not this one's to release.
  if (found != entries_.end() && found->second.held.get() == &unit) entries_.erase(found);
  end_change(std::move(lock));
}

void LeaseTable::end_change(std::unique_lock<std::mutex> lock) {
  const bool hungry = queue_.empty() && asked_ == 0, empty = entries_.empty();
  lock.unlock();
  if (hungry) hungry_.notify_all();
  if (empty) empty_.notify_all();
}

bool LeaseTable::wait_until_empty(std::chrono::milliseconds timeout) {
  std::unique_lock lock{mutex_};
  return empty_.wait_until(lock, {}, clock_.now() + timeout, [this] { return entries_.empty(); });
}

void LeaseTable::forget_if_queued(std::map<Key, Entry>::iterator entry) {
  if (entry->second.begun) return;
  std::erase(queue_, entry->first);
  entries_.erase(entry);
}

}  // namespace tessera::agent
