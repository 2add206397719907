// Time, and the threads that live by it. Whatever waits, sleeps, starts a thread or reads the time, and
// decides something by it, is given a clock; a test gives it one on which time costs nothing.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

namespace tessera::base {

class Condition;
class Thread;

/// A place in the source: where a thread waits.
struct Place {
  const char* file;
  int line;

  static constexpr Place here(const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    return {file, line};
  }
};

/// Tells the time, lets threads wait for it and for each other, and starts them. Waiting and starting is what
/// the machine does, unless a test's clock has it otherwise. Safe to use from any number of threads.
class Clock {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  static constexpr TimePoint kNever = TimePoint::max();

  virtual ~Clock() = default;
  /// Monotonic.
  virtual TimePoint now() const = 0;
  /// Time on the wall, which somebody may set; since 1970.
  virtual std::chrono::milliseconds wall() const = 0;

  /// Starts a thread; std::system_error where the machine has none left. `name` is for people.
  virtual Thread start(std::string name, std::function<void(std::stop_token)> run);

 protected:
  friend class Condition;
  /// Waits until `changed` is notified, `stop` is requested, it is `deadline`, or for no reason. `lock` holds
  /// the mutex that goes with `changed`.
  virtual void wait(Condition& changed, std::unique_lock<std::mutex>& lock, const std::stop_token& stop,
                    TimePoint deadline, Place where);
  /// Wakes one that waits, or all.
  virtual void notify(Condition& changed, bool all);
};

/// The machine's.
Clock& machine_clock();

/// A condition variable whose waits live by a clock, which must outlive it. The predicates are called with
/// the lock held.
class Condition {
 public:
  using TimePoint = Clock::TimePoint;

  explicit Condition(Clock& clock) : clock_(clock) {}

  /// Waits until `is_over`.
  template <class Predicate>
  void wait(std::unique_lock<std::mutex>& lock, Predicate is_over, Place where = Place::here()) {
    wait_until(lock, std::stop_token{}, Clock::kNever, std::move(is_over), where);
  }
  /// Waits until `is_over`, or `stop` is requested; whether it is over.
  template <class Predicate>
  bool wait(std::unique_lock<std::mutex>& lock, const std::stop_token& stop, Predicate is_over,
            Place where = Place::here()) {
    return wait_until(lock, stop, Clock::kNever, std::move(is_over), where);
  }
  /// The same with a deadline.
  template <class Predicate>
  bool wait_until(std::unique_lock<std::mutex>& lock, const std::stop_token& stop, TimePoint deadline,
                  Predicate is_over, Place where = Place::here()) {
    while (!is_over()) {
      if (stop.stop_requested() || (deadline != Clock::kNever && clock_.now() >= deadline)) return false;
      clock_.wait(*this, lock, stop, deadline, where);
    }
    return true;
  }

  void notify_one() { clock_.notify(*this, /*all=*/false); }
  void notify_all() { clock_.notify(*this, /*all=*/true); }

 private:
  friend class Clock;

  Clock& clock_;
  std::condition_variable_any on_machine_;
};

/// A thread that a clock started: it is asked to stop, and joined, before this goes away.
class Thread {
 public:
  Thread() = default;
  /// `wait_for_end`: what joining does before it joins `thread`; empty: nothing.
  explicit Thread(std::jthread thread, std::function<void()> wait_for_end = {})
      : thread_(std::move(thread)), wait_for_end_(std::move(wait_for_end)) {}
  Thread(Thread&&) = default;
  Thread& operator=(Thread other) {
    std::swap(thread_, other.thread_);
    std::swap(wait_for_end_, other.wait_for_end_);
    return *this;
  }
  ~Thread() {
    if (!joinable()) return;
    request_stop();
    join();
  }

  bool joinable() const { return thread_.joinable(); }
  void request_stop() { thread_.request_stop(); }
  void join() {
    if (wait_for_end_) wait_for_end_();
    thread_.join();
  }

 private:
  std::jthread thread_;
  std::function<void()> wait_for_end_;
};

/// Sleeps for `delay`, or until `stop` is requested: then false.
bool pause(Clock& clock, std::chrono::nanoseconds delay, const std::stop_token& stop,
           Place where = Place::here());

}  // namespace tessera::base
