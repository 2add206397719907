#include "command/report/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ostream>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace tessera::client {
namespace {

using std::chrono::duration;
using std::chrono::milliseconds;

constexpr milliseconds kBarInterval(100);
constexpr milliseconds kLineInterval(2000);
// Rates over less than this say nothing.
constexpr double kMinRateSeconds = 0.2;
constexpr char kClearLine[] = "\r\x1b[K";

bool done(const ProgressState& state) { return state.share >= 1; }

int percent(const ProgressState& state) {
  // Rounded down, so that 100 % means done.
  return static_cast<int>(100.0 * std::clamp(state.share, 0.0, 1.0));
}

std::string time_text(const ProgressState& state) {
  if (done(state)) return absl::StrCat("in ", format_duration(state.elapsed_seconds));
  return state.seconds_left > 0 ? absl::StrCat(format_duration(state.seconds_left), " left") : "";
}

/// "33.4M of 64.0M samples".
std::string counts_text(const ProgressState& state) {
  const std::string taken = format_count(static_cast<double>(state.samples_done));
  if (state.samples_total == 0) return absl::StrCat(taken, " samples");
  return absl::StrCat(taken, " of ", format_count(static_cast<double>(state.samples_total)), " samples");
}

bool waits(const ProgressState& state) { return state.share == 0 && !state.waits_for.empty(); }

}  // namespace

ProgressMode progress_mode(int file_descriptor, bool quiet) {
  if (quiet) return ProgressMode::kSilent;
  const char* terminal = std::getenv("TERM");
  const bool can_redraw = terminal != nullptr && std::string_view(terminal) != "dumb";
  return can_redraw && isatty(file_descriptor) ? ProgressMode::kBar : ProgressMode::kLines;
}

int terminal_columns(int file_descriptor) {
  winsize size{};
  return ioctl(file_descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string format_count(double count) {
  constexpr const char* kMultipliers[] = {"", "k", "M", "G", "T", "P"};
  std::size_t i = 0;
  while (count >= 999.5 && i + 1 < std::size(kMultipliers)) {
    count /= 1000;
    ++i;
  }
  if (i == 0) return absl::StrFormat("%.0f", count);
  // Three digits; what rounds up to the next number of digits has one decimal less.
  const int decimals = count < 9.995 ? 2 : count < 99.95 ? 1 : 0;
  return absl::StrFormat("%.*f%s", decimals, count, kMultipliers[i]);
}

std::string format_duration(double seconds) {
  constexpr double kMax = 1e9, kRounding = 1e-6;  // kRounding: error of the arithmetic before
  const auto whole = static_cast<std::int64_t>(std::ceil(std::clamp(seconds - kRounding, 0.0, kMax)));
  const std::int64_t hours = whole / 3600, minutes = whole / 60 % 60;
  if (hours > 0) return absl::StrFormat("%d:%02d:%02d", hours, minutes, whole % 60);
  return absl::StrFormat("%d:%02d", minutes, whole % 60);
}

std::string format_bar(const ProgressState& state, int columns) {
  constexpr int kMaxBar = 30, kMinBar = 8;
  std::string text = waits(state)
                         ? absl::StrCat(state.label, "  ", state.waits_for)
                         : absl::StrFormat("%s  %3d%%  %s", state.label, percent(state), counts_text(state));
  if (state.samples_per_second > 0)
    absl::StrAppend(&text, "  ", format_count(state.samples_per_second), "/s");
  if (const std::string time = time_text(state); !time.empty()) absl::StrAppend(&text, "  ", time);
  if (waits(state)) absl::StrAppend(&text, "  ", format_duration(state.elapsed_seconds));

  // " [", "]" and one free column at the end of the line, where some terminals would wrap.
  const int room = std::min(columns - 1 - static_cast<int>(text.size()) - 3, kMaxBar);
  if (room >= kMinBar) {
    const int filled = room * percent(state) / 100;
    std::string bar(static_cast<std::size_t>(filled), '=');
    if (filled < room) bar += '>';
    bar.resize(static_cast<std::size_t>(room), ' ');
    text.insert(state.label.size(), absl::StrCat(" [", bar, "]"));
  }
  text.resize(std::min(text.size(), static_cast<std::size_t>(std::max(columns - 1, 1))));
  return text;
}

std::string format_line(const ProgressState& state) {
  if (waits(state)) return absl::StrCat(state.label, ": ", state.waits_for);
  std::string text = absl::StrFormat("%s: %d%% (%s)", state.label, percent(state), counts_text(state));
  if (state.samples_per_second > 0)
    absl::StrAppend(&text, ", ", format_count(state.samples_per_second), " samples/s");
  if (const std::string time = time_text(state); !time.empty()) absl::StrAppend(&text, ", ", time);
  return text;
}

Progress::Progress(ProgressMode mode, std::ostream& out, std::string label, std::uint64_t samples_total,
                   TimePoint now, int columns)
    : mode_(mode), out_(out), columns_(columns), start_(now) {
  state_.label = std::move(label);
  state_.samples_total = samples_total;
}

void Progress::update(std::uint64_t samples_done, TimePoint now) {
  const std::uint64_t total = state_.samples_total;
  const double share = total == 0 ? 1 : static_cast<double>(samples_done) / static_cast<double>(total);
  update(WorkDone{share, samples_done}, now);
}

void Progress::update(const WorkDone& done, TimePoint now, const std::string& waits_for) {
  if (!baseline_) baseline_ = Point{done, now};
  const bool same = drawn_ && waits_for == told_;
  state_.share = done.share;
  state_.samples_done = done.samples;
  state_.waits_for = waits_for;
  if (mode_ == ProgressMode::kSilent) return;
  const milliseconds interval = mode_ == ProgressMode::kBar ? kBarInterval : kLineInterval;
  if (mode_ == ProgressMode::kLines && waits(state_) && (same || now - start_ < interval)) return;
  if (!drawn_ || now - drawn_->time >= interval) draw(now);
}

void Progress::finish(TimePoint now) {
  if (mode_ == ProgressMode::kSilent) return;
  const bool said_already = mode_ == ProgressMode::kLines && drawn_ && drawn_->done.share == state_.share &&
                            drawn_->done.samples == state_.samples_done;
  if (!said_already) draw(now);
  if (mode_ == ProgressMode::kBar) out_ << '\n' << std::flush;
  bar_shown_ = false;
}

void Progress::clear() {
  if (!bar_shown_) return;
  out_ << kClearLine << std::flush;
  bar_shown_ = false;
  drawn_.reset();
}

void Progress::draw(TimePoint now) {
  state_.elapsed_seconds = duration<double>(now - start_).count();
  if (baseline_) {
    const double seconds = duration<double>(now - baseline_->time).count();
    const auto samples =
        static_cast<double>(state_.samples_done - std::min(state_.samples_done, baseline_->done.samples));
    const double share = state_.share - baseline_->done.share;
    if (seconds >= kMinRateSeconds) state_.samples_per_second = samples / seconds;
    if (seconds >= kMinRateSeconds && share > 0) state_.seconds_left = seconds * (1 - state_.share) / share;
  }
  if (mode_ == ProgressMode::kBar) {
    out_ << kClearLine << format_bar(state_, columns_) << std::flush;
    bar_shown_ = true;
  } else {
    out_ << format_line(state_) << '\n' << std::flush;
  }
  told_ = state_.waits_for;
  drawn_ = Point{{state_.share, state_.samples_done}, now};
}

}  // namespace tessera::client
