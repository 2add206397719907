// Programs that a test starts.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace tessera::support {

/// How a program ended.
struct ExitStatus {
  int code = -1;   // exit code; -1 when a signal ended it
  int signal = 0;  // the signal that ended it; 0: none did
};

/// A running program; its output is collected. Killed (SIGKILL) and reaped at the latest in the destructor,
/// and also when the test itself dies. When a sanitizer has reported something on its stderr the test fails.
/// Thread-safe.
class Process {
 public:
  /// Throws std::system_error when it cannot be started. `environment`, "NAME=VALUE", goes before the test's
  /// own.
  explicit Process(std::vector<std::string> command, std::vector<std::string> environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t id() const { return pid_; }

  void send_signal(int signal);
  void kill() { send_signal(SIGKILL); }

  /// Waits for its end; nothing when it goes on for longer than `patience`.
  std::optional<ExitStatus> wait(std::chrono::milliseconds patience);

  /// Waits for a line of stdout that begins with `prefix`, and returns the rest of it; nothing when none
  /// comes within `patience` or the program ends without.
  std::optional<std::string> wait_for_line(const std::string& prefix, std::chrono::milliseconds patience);

  /// Waits until stderr holds `text`; false when it does not within `patience` or the program ends without.
  bool wait_for_err(const std::string& text, std::chrono::milliseconds patience);

  /// Output so far; of stderr the part behind the first `from` bytes.
  std::string out() const;
  std::string err(std::size_t from = 0) const;

 private:
  void collect(int descriptor, std::string& into);
  void reap();

  pid_t pid_ = -1;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::string out_;
  std::string err_;
  int open_pipes_ = 2;
  std::optional<ExitStatus> ended_;
  std::vector<std::jthread> threads_;
};

/// Runs to the end, at most `patience`; a program that takes longer is killed and has the signal SIGKILL.
struct Finished {
  ExitStatus status;
  std::string out;
  std::string err;
};
Finished run_program(std::vector<std::string> command, std::chrono::milliseconds patience,
                     std::vector<std::string> environment = {});

}  // namespace tessera::support
