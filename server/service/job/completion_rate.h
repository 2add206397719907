// How fast a job goes, for people who wait for it.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "scheduler/lease_table.h"

namespace tessera::server {

/// Counts what was done within the last two minutes. Never reads a clock: every call says what time it is.
class CompletionRate {
 public:
  static constexpr Time kWindow{120'000};
  static constexpr Time kStep{2'000};  // time between the points that are kept

  /// So many units are done now.
  void note(std::uint64_t units_done, Time now);
  /// How long `left` more units will take; nothing while it is not known.
  std::optional<Time> time_for(std::uint64_t left, Time now) const;

 private:
  struct Point {
    Time time;
    std::uint64_t units = 0;
  };
  std::deque<Point> points_;  // the oldest first; the first one may lie before the window
  std::uint64_t units_ = 0;
};

}  // namespace tessera::server
