#include "service/dispatcher.h"

#include <iterator>
#include <utility>

namespace tessera::server {
namespace {

constexpr std::chrono::milliseconds kTick{250};
// After so many parked calls in a row that found nothing, the others will hardly find more: they are tried next time.
constexpr int kMaxVainTries = 512;
constexpr std::chrono::milliseconds kNewsInterval{900};  // below the second that watchers are promised

}  // namespace

Dispatcher::Dispatcher(std::function<void()> tick) : tick_(std::move(tick)), thread_([this] { run(); }) {}

Dispatcher::~Dispatcher() { stop(); }

void Dispatcher::park(Clock::time_point deadline, std::function<bool(bool)> attempt) {
  {
    const std::lock_guard lock(mutex_);
    if (!stop_) {
      parked_.push_back({deadline, std::move(attempt)});
      return;
    }
  }
  attempt(true);
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
  Clock::time_point next_tick = Clock::now();
  Clock::time_point next_news = next_tick;
  while (true) {
    bool work, news, stopping;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_until(lock, next_tick, [this] { return stop_ || work_ || news_; });
      work = std::exchange(work_, false);
      news = std::exchange(news_, false);
      stopping = stop_;
    }
    const Clock::time_point now = Clock::now();
    if (now >= next_tick) {
      tick_();
      next_tick = now + kTick;
      work = true;
    }
    if (now >= next_news) {
      news = true;
      next_news = now + kNewsInterval;
    }
    if (work || stopping) try_parked(stopping);
    if (news || stopping) wake_subscribers();
    if (stopping) return;
  }
}

// Neither holds the mutex while it calls out: what it calls may park or subscribe again.

void Dispatcher::try_parked(bool last) {
  std::vector<Parked> trying;
  {
    const std::lock_guard lock(mutex_);
    trying = std::exchange(parked_, {});
  }
  const Clock::time_point now = Clock::now();
  std::vector<Parked> untried, vain;
  int vain_tries = 0;
  for (Parked& parked : trying) {
    const bool due = last || now >= parked.deadline;
    if (vain_tries >= kMaxVainTries && !due) {
      untried.push_back(std::move(parked));
    } else if (parked.attempt(due)) {
      vain_tries = 0;
    } else {
      ++vain_tries;
      vain.push_back(std::move(parked));
    }
  }
  const std::lock_guard lock(mutex_);
  untried.insert(untried.end(), std::make_move_iterator(parked_.begin()), std::make_move_iterator(parked_.end()));
  untried.insert(untried.end(), std::make_move_iterator(vain.begin()), std::make_move_iterator(vain.end()));
  parked_ = std::move(untried);
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
