// Stops work that takes too long.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <stop_token>

#include "base/clock.h"

namespace tessera::agent {

/// One clock for all units of a worker. Thread-safe.
class TimeLimit {
  struct Watched {
    std::stop_source stop;
    bool expired = false;
  };
  using Watches = std::multimap<base::Clock::TimePoint, Watched>;  // keys: times at which they end

 public:
  /// Zero: no limit.
  TimeLimit(base::Clock& clock, std::chrono::milliseconds limit);

  /// Work that goes on for as long as this lives. Must not outlive the limit.
  class Watch {
   public:
    /// `stop`: why the work may have to end besides. The limit does not request it: whoever sees that it was
    /// requested knows that it was not for the time.
    Watch(TimeLimit& limit, std::stop_token stop);
    ~Watch();
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

    /// Requested when the time is over, and with `stop`.
    std::stop_token token() const { return work_.get_token(); }

    /// Whether the time is over.
    bool expired() const;

   private:
    struct Forward {
      std::stop_source to;
      void operator()() { to.request_stop(); }
    };

    TimeLimit& limit_;
    std::stop_source work_;
    Watches::iterator at_;
    std::stop_callback<Forward> outer_;
  };

 private:
  void run(std::stop_token stop);
  Watches::iterator add(std::stop_source work);
  /// The one that ends next; the limit is the same for all, so those that have ended are at the front.
  Watches::iterator next();

  base::Clock& clock_;
  const std::chrono::milliseconds limit_;
  mutable std::mutex mutex_;
  base::Condition changed_{clock_};
  Watches watches_;
  base::Thread thread_;  // none without a limit
};

}  // namespace tessera::agent
