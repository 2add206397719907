#include "support/sequencer.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace tessera::test {
namespace {

// A world that takes so many turns goes round in circles.
constexpr std::uint64_t kMostTurns = 2'000'000;

constexpr base::Clock::TimePoint kBegin{std::chrono::hours{5}};

}  // namespace

thread_local Sequencer::Seat* Sequencer::own_seat_ = nullptr;

Sequencer::Sequencer(std::uint64_t seed, std::chrono::nanoseconds limit, std::string replay)
    : random_(seed), limit_(kBegin + limit), replay_(std::move(replay)), now_(kBegin) {
  own_seat_ = &add_seat("main");
}

Sequencer::~Sequencer() {
  if (present_.size() > 1) give_up("threads outlive their clock");
  own_seat_ = nullptr;
}

Sequencer::Seat& Sequencer::add_seat(std::string name) {
  Seat& seat = seats_.emplace_back();
  seat.name = std::move(name);
  seat.number = seats_.size();
  present_.push_back(&seat);
  return seat;
}

base::Thread Sequencer::start(std::string name, std::function<void(std::stop_token)> run) {
  Seat& seat = add_seat(std::move(name));
  std::jthread thread{[this, &seat, body = std::move(run)](std::stop_token stop) mutable {
    seat.turn.acquire();
    own_seat_ = &seat;
    // The function and its captures are destroyed while it is this thread's turn.
    std::exchange(body, {})(std::move(stop));
    leave(seat);
  }};
  return base::Thread{std::move(thread), [this, &seat] { join(seat); }};
}

void Sequencer::leave(Seat& seat) {
  seat.ended = true;
  std::erase(present_, &seat);
  wake(&seat);
  choose_next().turn.release();
}

void Sequencer::join(Seat& seat) {
  while (!seat.ended) {
    own_seat_->ready = false;
    hand_on(&seat, kNever, {seat.name.c_str(), 0});
  }
}

void Sequencer::wait(base::Condition& changed, std::unique_lock<std::mutex>& lock,
                     const std::stop_token& stop, TimePoint deadline, base::Place where) {
  Seat& seat = *own_seat_;
  seat.ready = false;
  {
    const std::stop_callback wake_up{stop, [&seat] { seat.ready = true; }};
    lock.unlock();
    hand_on(&changed, deadline, where);
  }
  lock.lock();
}

void Sequencer::notify(base::Condition& changed, bool all) {
  if (all) return wake(&changed);
  std::vector<Seat*> waiting;
  for (Seat* const seat : present_) {
    if (seat->waits_for == &changed && !seat->ready) waiting.push_back(seat);
  }
  if (!waiting.empty()) waiting[random_() % waiting.size()]->ready = true;
}

void Sequencer::wake(const void* waited_for) {
  for (Seat* const seat : present_) seat->ready |= seat->waits_for == waited_for;
}

void Sequencer::hand_on(const void* waits_for, TimePoint deadline, base::Place where) {
  Seat& seat = *own_seat_;
  seat.waits_for = waits_for;
  seat.deadline = deadline;
  seat.where = where;
  Seat& next = choose_next();
  if (&next != &seat) {
    next.turn.release();
    seat.turn.acquire();
  }
  seat.waits_for = nullptr;
  seat.deadline = kNever;
}

Sequencer::Seat& Sequencer::choose_next() {
  while (true) {
    ready_.clear();
    TimePoint next_deadline = kNever;
    for (Seat* const seat : present_) {
      if (seat->ready) ready_.push_back(seat);
      next_deadline = std::min(next_deadline, seat->deadline);
    }
    if (!ready_.empty()) break;
    if (next_deadline == kNever) give_up("all wait for each other");
    if (next_deadline > limit_) give_up("it does not end");
    now_ = std::max(now_, next_deadline);
    for (Seat* const seat : present_) seat->ready = seat->deadline <= now_;
  }
  if (++turns_ > kMostTurns) give_up("it takes turns without end");
  Seat& next = *ready_[random_() % ready_.size()];
  for (const std::uint64_t number :
       {next.number, static_cast<std::uint64_t>(now_.time_since_epoch().count())})
    digest_ = (digest_ ^ number) * 0x100000001b3;
  return next;
}

std::string Sequencer::who_waits() const {
  std::string lines;
  for (const Seat* const seat : present_) {
    lines += "  " + seat->name + " #" + std::to_string(seat->number);
    if (seat->waits_for != nullptr)
      lines += " waits at " + std::string(seat->where.file) + ":" + std::to_string(seat->where.line);
    if (seat->deadline != kNever) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(seat->deadline - now_);
      lines += ", for " + std::to_string(left.count()) + " ms";
    }
    lines += seat->ready ? ", is ready\n" : "\n";
  }
  return lines;
}

void Sequencer::give_up(const char* why) const {
  std::fprintf(
      stderr, "%s, %lld s after the beginning:\n%sagain: %s\n", why,
      static_cast<long long>(std::chrono::duration_cast<std::chrono::seconds>(now_ - kBegin).count()),
      who_waits().c_str(), replay_.c_str());
  std::abort();
}

}  // namespace tessera::test
