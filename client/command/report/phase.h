// Tells what goes on before there is anything to count.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <iosfwd>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "command/report/progress.h"

namespace tessera::client {

/// "cornell-box: reading, 0:06", or with a detail "kitchen: uploading, 12.3 of 40.1 MB, 0:02".
std::string format_phase(const std::string& label, const std::string& what, const std::string& detail,
                         double seconds);

/// "12.3 of 40.1 MB".
std::string format_bytes(std::uint64_t done, std::uint64_t total);

/// Shows one phase from its construction to its destruction, from a thread of its own: in a line that is
/// redrawn, or, where it takes long, in lines. Leaves a clean line behind.
class Phase {
 public:
  Phase(ProgressMode mode, std::ostream& out, std::string label, std::string what);
  ~Phase();
  Phase(const Phase&) = delete;
  Phase& operator=(const Phase&) = delete;

  /// Thread-safe.
  void detail(std::string text);

 private:
  void run(std::stop_token stop);

  const ProgressMode mode_;
  std::ostream& out_;
  const std::string label_, what_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::string detail_;
  std::jthread thread_;
};

}  // namespace tessera::client
