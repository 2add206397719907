// Tells people how far a render is.
#pragma once

#include <chrono>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>

namespace tessera::client {

enum class ProgressMode {
  kBar,    // a terminal: one line, redrawn in place
  kLines,  // a pipe or a log file: a plain line now and then
  kSilent
};

/// kSilent when `quiet`, else kBar when `file_descriptor` is a terminal that can redraw a line, else kLines.
ProgressMode progress_mode(int file_descriptor, bool quiet);

/// Width of the terminal behind `file_descriptor`; 80 when it does not tell.
int terminal_columns(int file_descriptor);

struct ProgressState {
  std::string label;  // "cornell-box"
  double share = 0;   // part of the work that is done, 0 to 1
  std::uint64_t samples_done = 0;
  std::uint64_t samples_total = 0;  // 0: not known, for the noise decides
  double elapsed_seconds = 0;
  double samples_per_second = 0;  // 0: not known yet
  double seconds_left = 0;        // 0: not known
  std::string waits_for = "";     // reason why nothing is done yet
};

/// "cornell-box [=====>    ]  52%  33.4M of 64.0M samples  12.3M/s  0:02 left", without end of line, at most
/// `columns` characters wide: parts are left out from the right, the bar first.
std::string format_bar(const ProgressState& state, int columns);

/// "cornell-box: 52% (33.4M of 64.0M samples), 12.3M samples/s, 0:02 left", or for a finished one the time
/// that it took.
std::string format_line(const ProgressState& state);

/// Work that is done.
struct WorkDone {
  double share = 0;           // 0 to 1
  std::uint64_t samples = 0;  // taken
};

/// 950 -> "950", 33400000 -> "33.4M": three digits and a decimal multiplier.
std::string format_count(double count);
/// 7.2 -> "0:07", 4000 -> "1:06:40".
std::string format_duration(double seconds);

/// Draws to a stream. Never reads a clock: every call says what time it is.
class Progress {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// `samples_total`: 0 where nobody knows, for the noise decides.
  Progress(ProgressMode mode, std::ostream& out, std::string label, std::uint64_t samples_total,
           TimePoint now, int columns = 80);

  /// Draws when it is time: a bar at most ten times a second, lines at most every two seconds; while nothing
  /// is done yet, and that takes long, a line only when `waits_for`, what goes on meanwhile, is another.
  void update(const WorkDone& done, TimePoint now, const std::string& waits_for = "");
  /// The same where the share is that of all samples.
  void update(std::uint64_t samples_done, TimePoint now);

  /// Draws the last state and ends the line. Without this call, nothing after the last drawn update is shown.
  void finish(TimePoint now);

  /// Clears a bar so that other output (a warning) starts on a clean line; the next update draws it again.
  void clear();

 private:
  struct Point {
    WorkDone done;
    TimePoint time;
  };
  void draw(TimePoint now);

  ProgressMode mode_;
  std::ostream& out_;
  int columns_;
  ProgressState state_;
  TimePoint start_;
  std::optional<Point> baseline_;  // state when we began to look: not part of the rate
  std::optional<Point> drawn_;     // last
  std::string told_;               // ProgressState::waits_for as last drawn
  bool bar_shown_ = false;
};

}  // namespace tessera::client
