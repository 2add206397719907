// SIGINT and SIGTERM.
#pragma once

#include <atomic>
#include <stop_token>
#include <thread>

namespace tessera::client {

/// Make one at the start of main, before any other thread. A signal ends the program at once, with exit code
/// 130, until a command takes charge with token(): then the first signal requests a stop, and the next one
/// ends the program.
class Interrupt {
 public:
  Interrupt();

  std::stop_token token();

  /// While there is one, a signal ends the program at once whoever is in charge: for work that leaves nothing
  /// behind.
  class AtOnce {
   public:
    AtOnce() { ++Interrupt::at_once_; }
    ~AtOnce() { --Interrupt::at_once_; }
    AtOnce(const AtOnce&) = delete;
    AtOnce& operator=(const AtOnce&) = delete;
  };

 private:
  void wait(std::stop_token done);

  static inline std::atomic<int> at_once_{0};
  std::atomic<bool> in_charge_{false};
  std::stop_source stop_;
  std::jthread thread_;
};

}  // namespace tessera::client
