// A clock on which time costs nothing, and on which threads take turns as a seed says.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <list>
#include <random>
#include <semaphore>
#include <string>
#include <vector>

#include "base/clock.h"

namespace tessera::test {

/// Lets one thread run at a time: of those that it started, and the one that made it. A thread hands on its
/// turn where it waits, and nowhere else, to one that the seed chooses; when all wait, it is the next
/// deadline at once. As long as all that these threads wait for, and everything random, comes from here and
/// the seed, what they do follows from the seed: nobody waits with another's mutex in hand, so none is ever
/// contended.
///
/// Ends the process, after a list of who waits where, when all wait for each other, and when they go on
/// beyond `limit` of this time.
class Sequencer final : public base::Clock {
 public:
  /// Begins some hours after all epochs. `replay` is how to see the same again, for the message of a hang.
  Sequencer(std::uint64_t seed, std::chrono::nanoseconds limit, std::string replay);
  /// On the thread that made it, when all others have been joined.
  ~Sequencer() override;

  TimePoint now() const override { return now_; }
  std::chrono::milliseconds wall() const override {
    return std::chrono::duration_cast<std::chrono::milliseconds>(now_.time_since_epoch());
  }
  base::Thread start(std::string name, std::function<void(std::stop_token)> run) override;

  /// How often a turn was given.
  std::uint64_t turns() const { return turns_; }
  /// Tells one course of turns from another.
  std::uint64_t digest() const { return digest_; }
  /// Who waits where, a line each.
  std::string who_waits() const;

 private:
  struct Seat {
    std::string name;
    std::uint64_t number = 0;
    std::binary_semaphore turn{0};
    bool ready = true, ended = false;
    const void* waits_for = nullptr;  // a condition, or a seat whose thread is to end
    TimePoint deadline = kNever;
    base::Place where{"", 0};
  };

  void wait(base::Condition& changed, std::unique_lock<std::mutex>& lock, const std::stop_token& stop,
            TimePoint deadline, base::Place where) override;
  void notify(base::Condition& changed, bool all) override;

  Seat& add_seat(std::string name);
  /// Waits until somebody has made the calling thread ready.
  void hand_on(const void* waits_for, TimePoint deadline, base::Place where);
  Seat& choose_next();
  void wake(const void* waited_for);
  void leave(Seat& seat);
  void join(Seat& seat);
  [[noreturn]] void give_up(const char* why) const;

  /// The calling thread's.
  static thread_local Seat* own_seat_;

  std::mt19937_64 random_;
  const TimePoint limit_;
  const std::string replay_;
  TimePoint now_;
  std::list<Seat> seats_;
  std::vector<Seat*> present_;  // those whose threads have not ended
  std::vector<Seat*> ready_;    // for choose_next() alone
  std::uint64_t turns_ = 0;
  std::uint64_t digest_ = 0xcbf29ce484222325;
};

}  // namespace tessera::test
