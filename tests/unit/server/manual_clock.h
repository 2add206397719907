// A clock that a test moves by hand.
#pragma once

#include <condition_variable>
#include <list>
#include <mutex>
#include <vector>

#include "base/clock.h"

namespace tessera::server {

/// Begins some hours after all epochs.
class ManualClock final : public base::Clock {
 public:
  TimePoint now() const override {
    const std::lock_guard lock(mutex_);
    return now_;
  }
  std::chrono::milliseconds wall() const override {
    return std::chrono::duration_cast<std::chrono::milliseconds>(now().time_since_epoch());
  }

  /// Moves on. Whoever waited for a time that has come, has left that wait when this returns.
  void advance(std::chrono::milliseconds by) {
    std::unique_lock own(mutex_);
    now_ += by;
    const std::vector<Waiter> waiters(waiters_.begin(), waiters_.end());
    own.unlock();
    for (const Waiter& waiter : waiters) {
      // Whoever is about to wait does so before this.
      { const std::lock_guard theirs(*waiter.mutex); }
      waiter.changed->notify_all();
    }
    own.lock();
    waiting_changed_.wait(own, [&] { return due() == 0; });
  }

  /// Moves on, and lets the one thread that lives by this clock do what is due: it waits for a later time
  /// before and after.
  void live_through(std::chrono::milliseconds by) {
    wait_for_waiter();
    advance(by);
    wait_for_waiter();
  }

 private:
  struct Waiter {
    std::mutex* mutex;
    base::Condition* changed;
    TimePoint deadline;
  };

  void wait(base::Condition& changed, std::unique_lock<std::mutex>& lock, const std::stop_token& stop,
            TimePoint deadline, base::Place where) override {
    if (deadline == kNever) return Clock::wait(changed, lock, stop, kNever, where);
    std::list<Waiter>::iterator place;
    {
      const std::lock_guard own(mutex_);
      if (deadline <= now_) return;
      place = waiters_.insert(waiters_.end(), {lock.mutex(), &changed, deadline});
      waiting_changed_.notify_all();
    }
    Clock::wait(changed, lock, stop, kNever, where);
    const std::lock_guard own(mutex_);
    waiters_.erase(place);
    waiting_changed_.notify_all();
  }

  std::size_t due() const {
    std::size_t due = 0;
    for (const Waiter& waiter : waiters_) due += waiter.deadline <= now_;
    return due;
  }

  void wait_for_waiter() {
    std::unique_lock own(mutex_);
    waiting_changed_.wait(own, [&] { return !waiters_.empty(); });
  }

  mutable std::mutex mutex_;
  std::condition_variable waiting_changed_;
  TimePoint now_ = TimePoint{} + std::chrono::hours{5};
  std::list<Waiter> waiters_;
};

}  // namespace tessera::server
