#include "scheduler/turn_order.h"

#include <utility>

namespace tessera::server {
namespace {

template <class Sums, class Key>
std::int64_t sum_of(const Sums& sums, const Key& key) {
  const auto found = sums.find(key);
  return found == sums.end() ? 0 : found->second;
}

template <class Sums, class Key>
void add_to(Sums& sums, const Key& key, std::int64_t delta) {
  const auto found = sums.try_emplace(key, 0).first;
  found->second += delta;
  if (found->second == 0) sums.erase(found);
}

}  // namespace

std::int64_t TurnOrder::used_by(JobNumber job, const Place& place) const {
  return place.load_ms + sum_of(done_by_job_, job);
}

TurnOrder::JobRank TurnOrder::rank_of(JobNumber job, const Place& place) const {
  if (order_ == JobOrder::kFirstCome) return {0, 0, job};
  return {used_by(job, place), place.last_turn, job};
}

TurnOrder::UserRank TurnOrder::rank_of(const UserKey& name, const User& user) const {
  return {user.load_ms + sum_of(done_by_user_, name), user.last_turn, name.second};
}

void TurnOrder::change_user(const UserKey& name, const std::function<void(User&)>& change) {
  Level& level = levels_[name.first];
  User& user = level.users[name.second];
  if (!user.jobs.empty()) level.order.erase(rank_of(name, user));
  change(user);
  if (!user.jobs.empty()) {
    level.order.insert(rank_of(name, user));
    return;
  }
  level.users.erase(name.second);
  if (level.users.empty()) levels_.erase(name.first);
}

void TurnOrder::add(JobNumber job, std::int32_t priority, const std::string& user, std::int64_t load_ms) {
  const Place& place = places_.emplace(job, Place{{priority, user}, load_ms, ++turns_}).first->second;
  change_user(place.user, [&](User& owner) {
    if (owner.jobs.empty()) owner.last_turn = turns_;
    owner.load_ms += load_ms;
    owner.jobs.insert(rank_of(job, place));
  });
}

void TurnOrder::remove(JobNumber job) {
  const auto found = places_.find(job);
  if (found == places_.end()) return;
  const Place place = found->second;
  places_.erase(found);
  change_user(place.user, [&](User& owner) {
    owner.load_ms -= place.load_ms;
    owner.jobs.erase(rank_of(job, place));
  });
}

void TurnOrder::charge(JobNumber job, std::int64_t delta_ms) {
  const auto found = places_.find(job);
  if (found == places_.end()) return;
  Place& place = found->second;
  change_user(place.user, [&](User& owner) {
    owner.jobs.erase(rank_of(job, place));
    place.load_ms += delta_ms;
    owner.load_ms += delta_ms;
    if (delta_ms > 0) place.last_turn = owner.last_turn = ++turns_;
    owner.jobs.insert(rank_of(job, place));
  });
}

void TurnOrder::change_done(const Done& done, std::int64_t delta_ms) {
  // Places in the order depend on the sums, which change while nobody's place is taken.
  change_user(done.user, [&](User&) { add_to(done_by_user_, done.user, delta_ms); });
  const auto found = places_.find(done.job);
  if (found == places_.end()) return add_to(done_by_job_, done.job, delta_ms);
  const Place& place = found->second;
  change_user(place.user, [&](User& owner) {
    owner.jobs.erase(rank_of(done.job, place));
    add_to(done_by_job_, done.job, delta_ms);
    owner.jobs.insert(rank_of(done.job, place));
  });
}

void TurnOrder::remember(JobNumber job, std::int64_t ms, Time now) {
  const auto found = places_.find(job);
  if (found == places_.end()) return;
  done_.push_back({.until = now + kMemory, .job = job, .user = found->second.user, .ms = ms});
  change_done(done_.back(), ms);
}

void TurnOrder::advance(Time now) {
  while (!done_.empty() && done_.front().until <= now) {
    change_done(done_.front(), -done_.front().ms);
    done_.pop_front();
  }
}

void TurnOrder::for_each(const std::function<Next(const Turn&)>& visit) const {
  for (const auto& [priority, level] : levels_) {
    for (const auto& [used, turn, name] : level.order) {
      for (const auto& [job_used, job_turn, job] : level.users.at(name).jobs) {
        const Next next = visit({.job = job,
                                 .priority = priority,
                                 .user_used_ms = used,
                                 .job_used_ms = used_by(job, places_.at(job))});
        if (next == Next::kStop) return;
        if (next == Next::kUser) break;
      }
    }
  }
}

}  // namespace tessera::server
