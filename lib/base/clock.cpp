#include "base/clock.h"

namespace tessera::base {
namespace {

class MachineClock final : public Clock {
 public:
  TimePoint now() const override { return std::chrono::steady_clock::now(); }
  std::chrono::milliseconds wall() const override {
    using namespace std::chrono;
    return duration_cast<milliseconds>(system_clock::now().time_since_epoch());
  }
};

}  // namespace

Thread Clock::start(std::string, std::function<void(std::stop_token)> run) {
  return Thread{std::jthread{std::move(run)}};
}

void Clock::wait(Condition& changed, std::unique_lock<std::mutex>& lock, const std::stop_token& stop,
                 TimePoint deadline, Place) {
  std::condition_variable_any& variable = changed.on_machine_;
  // Waits are for one wake each: whoever calls looks again.
  const auto has_waited = [waited = false]() mutable { return std::exchange(waited, true); };
  if (!stop.stop_possible()) {
    deadline == kNever ? variable.wait(lock) : static_cast<void>(variable.wait_until(lock, deadline));
  } else if (deadline == kNever) {
    variable.wait(lock, stop, has_waited);
  } else {
    variable.wait_until(lock, stop, deadline, has_waited);
  }
}

void Clock::notify(Condition& changed, bool all) {
  all ? changed.on_machine_.notify_all() : changed.on_machine_.notify_one();
}

Clock& machine_clock() {
  static MachineClock clock;
  return clock;
}

bool pause(Clock& clock, std::chrono::nanoseconds delay, const std::stop_token& stop, Place where) {
  std::mutex mutex;
  Condition never(clock);
  std::unique_lock lock(mutex);
  const auto end = clock.now() + std::chrono::duration_cast<Clock::TimePoint::duration>(delay);
  never.wait_until(
      lock, stop, end, [] { return false; }, where);
  return !stop.stop_requested();
}

}  // namespace tessera::base
