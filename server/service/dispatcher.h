// The one thread that time and news run on: expiry, calls that wait for work, watchers.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace tessera::server {

class Dispatcher {
 public:
  using Clock = std::chrono::steady_clock;

  /// `tick` runs before all else, four times a second at least.
  explicit Dispatcher(std::function<void()> tick);
  ~Dispatcher();

  /// Calls `attempt` after notifications of work and ticks until it returns true; its argument is true from `deadline`
  /// on, when it must. Where hundreds in a row have found nothing, the rest has its turn the next time.
  void park(Clock::time_point deadline, std::function<bool(bool last)> attempt);

  /// Calls `wake` after each notification of news and every second until it returns false.
  void subscribe(std::function<bool()> wake);

  void notify_work();
  void notify_news();

  /// Lets everything parked make its last try, drops watchers after a last wake, and ends the thread. What comes later
  /// is run the same way, at once, by the caller.
  void stop();

 private:
  struct Parked {
    Clock::time_point deadline;
    std::function<bool(bool)> attempt;
  };

  void run();
  void try_parked(bool last);
  void wake_subscribers();

  const std::function<void()> tick_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<Parked> parked_;
  std::vector<std::function<bool()>> subscribers_;
  bool work_ = false;
  bool news_ = false;
  bool stop_ = false;
  std::once_flag joined_;
  std::thread thread_;
};

}  // namespace tessera::server
