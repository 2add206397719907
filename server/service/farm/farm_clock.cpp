#include "service/farm/farm_clock.h"

namespace tessera::server {
namespace {

class MachineClock final : public FarmClock {
 public:
  TimePoint now() const override { return std::chrono::steady_clock::now(); }
  std::chrono::milliseconds wall() const override {
    using namespace std::chrono;
    return duration_cast<milliseconds>(system_clock::now().time_since_epoch());
  }
  void wait_until(std::unique_lock<std::mutex>& lock, std::condition_variable& changed,
                  TimePoint deadline) override {
    changed.wait_until(lock, deadline);
  }
};

}  // namespace

FarmClock& machine_clock() {
  static MachineClock clock;
  return clock;
}

}  // namespace tessera::server
