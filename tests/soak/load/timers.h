// Things to do later, on one thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <queue>
#include <stop_token>
#include <thread>
#include <vector>

namespace tessera::load {

/// Thread-safe. What is still to come when it goes away is dropped.
class Timers {
 public:
  using Clock = std::chrono::steady_clock;

  Timers() : thread_([this](std::stop_token stop) { run(stop); }) {}

  void after(Clock::duration delay, std::function<void()> action) {
    const std::lock_guard lock(mutex_);
    const Clock::time_point due = Clock::now() + delay;
    const bool first = waiting_.empty() || due < waiting_.top().due;
    waiting_.push({due, std::move(action)});
    if (first) wake_.notify_one();
  }

  /// No action is run once it returns. Not to be called from an action.
  void stop() {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
  }

 private:
  struct Entry {
    Clock::time_point due;
    std::function<void()> action;
    bool operator<(const Entry& other) const { return due > other.due; }  // the earliest on top
  };

  void run(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      const Clock::time_point next =
          waiting_.empty() ? Clock::now() + std::chrono::hours(1) : waiting_.top().due;
      wake_.wait_until(lock, stop, next, [&] { return !waiting_.empty() && waiting_.top().due < next; });
      std::vector<std::function<void()>> due;
      while (!waiting_.empty() && waiting_.top().due <= Clock::now()) {
        due.push_back(waiting_.top().action);
        waiting_.pop();
      }
      lock.unlock();
      for (const auto& action : due) action();
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::priority_queue<Entry> waiting_;
  std::jthread thread_;
};

}  // namespace tessera::load
