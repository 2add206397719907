#include "scheduler/turn_order.h"

#include <utility>

namespace tessera::server {

std::tuple<std::int64_t, TurnOrder::JobNumber, std::string> TurnOrder::key(const std::string& name, const User& user) {
  return {user.load_ms, user.jobs.empty() ? 0 : user.jobs.begin()->second, name};
}

void TurnOrder::change_user(const Place& place, const std::function<void(User&)>& change) {
  Level& level = levels_[place.priority];
  User& user = level.users[place.user];
  level.order.erase(key(place.user, user));
  change(user);
  if (!user.jobs.empty()) {
    level.order.insert(key(place.user, user));
    return;
  }
  level.users.erase(place.user);
  if (level.users.empty()) levels_.erase(place.priority);
}

void TurnOrder::add(JobNumber job, std::int32_t priority, const std::string& user, std::int64_t load_ms) {
  const Place& place = places_.emplace(job, Place{priority, user, load_ms}).first->second;
  change_user(place, [&](User& owner) {
    owner.load_ms += load_ms;
    owner.jobs.emplace(load_ms, job);
  });
}

void TurnOrder::remove(JobNumber job) {
  const auto found = places_.find(job);
  if (found == places_.end()) return;
  const Place place = found->second;
  places_.erase(found);
  change_user(place, [&](User& owner) {
    owner.load_ms -= place.load_ms;
    owner.jobs.erase({place.load_ms, job});
  });
}

void TurnOrder::charge(JobNumber job, std::int64_t delta_ms) {
  const auto found = places_.find(job);
  if (found == places_.end()) return;
  Place& place = found->second;
  change_user(place, [&](User& owner) {
    owner.jobs.erase({place.load_ms, job});
    place.load_ms += delta_ms;
    owner.load_ms += delta_ms;
    owner.jobs.emplace(place.load_ms, job);
  });
}

std::optional<TurnOrder::Turn> TurnOrder::turn_of(JobNumber job) const {
  const auto found = places_.find(job);
  if (found == places_.end()) return std::nullopt;
  const Place& place = found->second;
  return Turn{.job = job,
              .priority = place.priority,
              .user_load_ms = levels_.at(place.priority).users.at(place.user).load_ms,
              .job_load_ms = place.load_ms};
}

bool TurnOrder::comes_before(JobNumber a, JobNumber b) const {
  const Place &one = places_.at(a), &other = places_.at(b);
  if (one.priority != other.priority) return one.priority > other.priority;
  if (one.user == other.user) return std::pair{one.load_ms, a} < std::pair{other.load_ms, b};
  const auto& users = levels_.at(one.priority).users;
  return key(one.user, users.at(one.user)) < key(other.user, users.at(other.user));
}

void TurnOrder::for_each(const std::function<bool(const Turn&)>& visit) const {
  for (const auto& [priority, level] : levels_) {
    for (const auto& [load, first, name] : level.order) {
      const User& user = level.users.at(name);
      for (const auto& [job_load, job] : user.jobs) {
        if (!visit({.job = job, .priority = priority, .user_load_ms = user.load_ms, .job_load_ms = job_load})) return;
      }
    }
  }
}

}  // namespace tessera::server
