#include "service/farm/dispatcher.h"

#include <iterator>
#include <utility>

namespace tessera::server {
namespace {

constexpr std::chrono::milliseconds kTick{250};
// After so many parked calls in a row that found nothing, the others will hardly find more: they are tried
// next time.
constexpr int kMaxVainTries = 512;
constexpr std::chrono::milliseconds kNewsInterval{900};  // below the second that watchers are promised

}  // namespace

Dispatcher::Dispatcher(base::Clock& clock, std::function<void()> tick)
    : clock_(clock),
      tick_(std::move(tick)),
      wake_(clock),
      thread_(clock.start("dispatcher", [this](std::stop_token) { run(); })) {}

Dispatcher::~Dispatcher() { stop(); }

void Dispatcher::park(const std::string& worker, TimePoint deadline, std::function<bool(bool)> attempt) {
  std::unique_lock lock(mutex_);
  if (stop_) {
    lock.unlock();
    attempt(true);
    return;
  }
  Queue one;
  one.push_back({worker, deadline, std::move(attempt)});
  append(one);
  called_.insert(worker);  // a hand may have become free since the caller looked
  lock.unlock();
  wake_.notify_one();
}

void Dispatcher::append(Queue& parked) {
  for (auto it = parked.begin(); it != parked.end(); ++it) by_worker_.emplace(it->worker, it);
  parked_.splice(parked_.end(), parked);
}

void Dispatcher::subscribe(std::function<bool()> wake) {
  {
    const std::lock_guard lock(mutex_);
    if (!stop_) {
      subscribers_.push_back(std::move(wake));
      return;
    }
  }
  wake();
}

void Dispatcher::notify_work() {
  {
    const std::lock_guard lock(mutex_);
    work_ = true;
  }
  wake_.notify_one();
}

void Dispatcher::notify_worker(const std::string& worker) {
  {
    const std::lock_guard lock(mutex_);
    // Calls that it parks later are tried once anyway; one that is being tried may have looked before.
    if (!trying_ && !by_worker_.contains(worker)) return;
    called_.insert(worker);
  }
  wake_.notify_one();
}

void Dispatcher::notify_news() {
  {
    const std::lock_guard lock(mutex_);
    news_ = true;
  }
  wake_.notify_one();
}

void Dispatcher::stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  std::call_once(joined_, [this] { thread_.join(); });
}

void Dispatcher::run() {
  TimePoint next_tick = clock_.now();
  TimePoint next_news = next_tick;
  while (true) {
    bool work, news, stopping;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_until(lock, {}, next_tick, [this] { return stop_ || work_ || news_ || !called_.empty(); });
      work = std::exchange(work_, false);
      news = std::exchange(news_, false);
      stopping = stop_;
    }
    const TimePoint now = clock_.now();
    if (now >= next_tick) {
      tick_();
      next_tick = now + kTick;
      work = true;
    }
    if (now >= next_news) {
      news = true;
      next_news = now + kNewsInterval;
    }
    try_called();
    if (work || stopping) try_parked(stopping);
    if (news || stopping) wake_subscribers();
    if (stopping) return;
  }
}

// None of these holds the mutex while it calls out: what it calls may park or subscribe again.

void Dispatcher::try_called() {
  Queue trying;
  {
    const std::lock_guard lock(mutex_);
    for (const std::string& worker : called_) {
      const auto [first, last] = by_worker_.equal_range(worker);
      for (auto it = first; it != last; ++it) trying.splice(trying.end(), parked_, it->second);
      by_worker_.erase(first, last);
    }
    called_.clear();
    trying_ = true;
  }
  const TimePoint now = clock_.now();
  std::erase_if(trying, [now](Parked& parked) { return parked.attempt(now >= parked.deadline); });
  const std::lock_guard lock(mutex_);
  trying_ = false;
  append(trying);
}

void Dispatcher::try_parked(bool last) {
  Queue trying;
  {
    const std::lock_guard lock(mutex_);
    trying.swap(parked_);
    by_worker_.clear();
    trying_ = true;
  }
  const TimePoint now = clock_.now();
  Queue vain, untried;
  int vain_tries = 0;
  while (!trying.empty()) {
    Parked& parked = trying.front();
    const bool due = last || now >= parked.deadline;
    if (vain_tries >= kMaxVainTries && !due) {
      untried.splice(untried.end(), trying, trying.begin());
    } else if (parked.attempt(due)) {
      vain_tries = 0;
      trying.pop_front();
    } else {
      ++vain_tries;
      vain.splice(vain.end(), trying, trying.begin());
    }
  }
  // First those that had no turn, then those that came meanwhile.
  const std::lock_guard lock(mutex_);
  trying_ = false;
  untried.splice(untried.end(), parked_);
  untried.splice(untried.end(), vain);
  by_worker_.clear();
  append(untried);
}

void Dispatcher::wake_subscribers() {
  std::vector<std::function<bool()>> waking;
  {
    const std::lock_guard lock(mutex_);
    waking = std::exchange(subscribers_, {});
  }
  std::erase_if(waking, [](const std::function<bool()>& wake) { return !wake(); });
  const std::lock_guard lock(mutex_);
  subscribers_.insert(subscribers_.begin(), std::make_move_iterator(waking.begin()),
                      std::make_move_iterator(waking.end()));
}

}  // namespace tessera::server
