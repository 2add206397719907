// The machine that figures are measured on, and what else it does meanwhile.
#pragma once

#include <chrono>
#include <string>

namespace tessera::client {

struct Machine {
  std::string processor_model;  // the system's name for it; empty: not known
  unsigned processors = 0;      // processors that this process may use
  double load = 0;    // processes that wanted a processor, mean of the minute before the measurement
  double others = 0;  // processors that others kept busy during the measurement, mean

  /// Whether figures are to be marked: a core that is shared with other work is slower, in CPU seconds too.
  bool is_loaded() const { return load > 1 || others > 1; }
};

/// Watches the machine from its construction on.
class MachineWatch {
 public:
  MachineWatch();
  Machine machine() const;

 private:
  struct Times {
    double busy = 0, own = 0;  // seconds of all processors; of this process and its children
    std::chrono::steady_clock::time_point wall;
  };
  static Times now();

  Machine machine_;
  Times start_;
};

/// "MODEL, 2 processors; load 0.31 before, others kept 0.05 processors busy", and whether that is too much.
std::string to_text(const Machine& machine);

}  // namespace tessera::client
