// How much more memory this process had at a time than before.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>

namespace tessera::support {

/// Measures from its construction on, by what Linux notes of the process's resident memory. Memory that was
/// freed before, and that the allocator still holds, counts for nothing when it is used again.
class PeakMemory {
 public:
  PeakMemory() {
    std::ofstream{"/proc/self/clear_refs"} << "5" << std::flush;  // the peak is what is resident now
    begin_ = peak();
  }

  /// In bytes; absent where Linux does not say it, or the note could not be set back.
  std::optional<std::uint64_t> growth() const {
    const std::optional<std::uint64_t> resident = status("VmRSS:"), end = peak();
    if (!begin_ || !end || !resident) return std::nullopt;
    return *end - *begin_;
  }

 private:
  static std::optional<std::uint64_t> peak() { return status("VmHWM:"); }
  static std::optional<std::uint64_t> status(const std::string& name) {
    std::ifstream in{"/proc/self/status"};
    std::string word;
    while (in >> word) {
      std::uint64_t kilobytes = 0;
      if (word == name && in >> kilobytes) return kilobytes << 10;
    }
    return std::nullopt;
  }

  std::optional<std::uint64_t> begin_;
};

}  // namespace tessera::support
