// The one thread that time and news run on: expiry, calls that wait for work, watchers.
#pragma once

#include <chrono>
#include <functional>
#include <list>
#include <mutex>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/clock.h"

namespace tessera::server {

class Dispatcher {
 public:
  using TimePoint = base::Clock::TimePoint;

  /// `tick` runs before all else, four times a second at least. The clock must outlive the dispatcher.
  Dispatcher(base::Clock& clock, std::function<void()> tick);
  ~Dispatcher();

  /// Calls `attempt` soon, and after notifications of work, of this worker, and ticks, until it returns true;
  /// its argument is true from `deadline` on, when it must. Where hundreds in a row have found nothing, the
  /// rest has its turn the next time.
  void park(const std::string& worker, TimePoint deadline, std::function<bool(bool last)> attempt);

  /// Calls `wake` after each notification of news and every second until it returns false.
  void subscribe(std::function<bool()> wake);

  void notify_work();
  /// This worker has a free hand: what it parked is tried before all others.
  void notify_worker(const std::string& worker);
  void notify_news();

  /// Lets everything parked make its last try, drops watchers after a last wake, and ends the thread. What
  /// comes later is run the same way, at once, by the caller.
  void stop();

 private:
  struct Parked {
    std::string worker;
    TimePoint deadline;
    std::function<bool(bool)> attempt;
  };
  using Queue = std::list<Parked>;

  void run();
  void try_parked(bool last);
  void try_called();
  /// Behind those that are there, in the same order. With mutex_ held.
  void append(Queue& parked);
  void wake_subscribers();

  base::Clock& clock_;
  const std::function<void()> tick_;
  std::mutex mutex_;
  base::Condition wake_;
  Queue parked_;
  std::unordered_multimap<std::string, Queue::iterator> by_worker_;
  std::unordered_set<std::string> called_;  // workers with a free hand
  std::vector<std::function<bool()>> subscribers_;
  bool trying_ = false;  // some of them are not in the lists just now
  bool work_ = false;
  bool news_ = false;
  bool stop_ = false;
  std::once_flag joined_;
  base::Thread thread_;
};

}  // namespace tessera::server
