#include "agent/time_limit.h"

#include <algorithm>
#include <utility>

namespace tessera::agent {

TimeLimit::TimeLimit(base::Clock& clock, std::chrono::milliseconds limit) : clock_(clock), limit_(limit) {
  if (limit_ > limit_.zero())
    thread_ = clock_.start("time limit", [this](std::stop_token stop) { run(stop); });
}

TimeLimit::Watch::Watch(TimeLimit& limit, std::stop_token stop)
    : limit_(limit), at_(limit.add(work_)), outer_(std::move(stop), Forward{work_}) {}

TimeLimit::Watch::~Watch() {
  std::lock_guard lock{limit_.mutex_};
  limit_.watches_.erase(at_);
}

bool TimeLimit::Watch::expired() const {
  std::lock_guard lock{limit_.mutex_};
  return at_->second.expired;
}

TimeLimit::Watches::iterator TimeLimit::add(std::stop_source work) {
  std::lock_guard lock{mutex_};
  changed_.notify_all();
  return watches_.emplace(clock_.now() + limit_, Watched{std::move(work), false});
}

TimeLimit::Watches::iterator TimeLimit::next() {
  return std::ranges::find_if(watches_, [](const auto& watch) { return !watch.second.expired; });
}

void TimeLimit::run(std::stop_token stop) {
  std::unique_lock lock{mutex_};
  while (changed_.wait(lock, stop, [this] { return next() != watches_.end(); })) {
    if (const base::Clock::TimePoint end = next()->first; clock_.now() < end) {
      changed_.wait_until(lock, stop, end, [] { return false; });
      continue;  // it may have ended meanwhile
    }
    Watched& overdue = next()->second;
    overdue.expired = true;
    // The callbacks may end the watch.
    std::stop_source source = overdue.stop;
    lock.unlock();
    source.request_stop();
    lock.lock();
  }
}

}  // namespace tessera::agent
