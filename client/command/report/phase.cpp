#include "command/report/phase.h"

#include <chrono>
#include <ostream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace tessera::client {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// A phase that is over before is not worth a line.
constexpr milliseconds kBarBegins(300), kBarRedrawn(200);
constexpr milliseconds kLineBegins(2000), kLineRepeated(5000);

}  // namespace

std::string format_phase(const std::string& label, const std::string& what, const std::string& detail,
                         double seconds) {
  return absl::StrCat(label, ": ", what, detail.empty() ? "" : ", ", detail, ", ", format_duration(seconds));
}

std::string format_bytes(std::uint64_t done, std::uint64_t total) {
  const bool large = total >= 1'000'000'000;
  const double unit = large ? 1e9 : 1e6;
  return absl::StrFormat("%.1f of %.1f %s", static_cast<double>(done) / unit,
                         static_cast<double>(total) / unit, large ? "GB" : "MB");
}

Phase::Phase(ProgressMode mode, std::ostream& out, std::string label, std::string what)
    : mode_(mode), out_(out), label_(std::move(label)), what_(std::move(what)) {
  if (mode_ != ProgressMode::kSilent)
    thread_ = std::jthread{[this](std::stop_token stop) { run(std::move(stop)); }};
}

Phase::~Phase() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void Phase::detail(std::string text) {
  const std::lock_guard lock{mutex_};
  detail_ = std::move(text);
}

void Phase::run(std::stop_token stop) {
  const bool bar = mode_ == ProgressMode::kBar;
  const Clock::time_point start = Clock::now();
  Clock::time_point next = start + (bar ? kBarBegins : kLineBegins);
  bool shown = false;
  std::unique_lock lock{mutex_};
  while (!wake_.wait_until(lock, stop, next, [] { return false; }) && !stop.stop_requested()) {
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    const std::string text = format_phase(label_, what_, detail_, seconds);
    out_ << (bar ? "\r\x1b[K" : "") << text << (bar ? "" : "\n") << std::flush;
    shown = true;
    next = Clock::now() + (bar ? kBarRedrawn : kLineRepeated);
  }
  if (bar && shown) out_ << "\r\x1b[K" << std::flush;
}

}  // namespace tessera::client
