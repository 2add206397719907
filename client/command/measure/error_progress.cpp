#include "command/measure/error_progress.h"

#include <algorithm>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "base/printable.h"

namespace tessera::client {

namespace {

std::string samples_text(const SamplingProgress& progress) {
  return absl::StrCat(format_count(static_cast<double>(progress.samples)), " samples");
}

/// "within 2.3 %, 1 % is wanted".
std::string within_text(const SamplingProgress& progress, double wanted) {
  std::string text = absl::StrFormat("within %.3g %%", 100 * progress.worst);
  if (wanted > 0) absl::StrAppend(&text, absl::StrFormat(", %.3g %% is wanted", 100 * wanted));
  return text;
}

/// Part of the samples that are needed, by what is known of the worst figure.
double share_of(const SamplingProgress& progress, double wanted) {
  if (!(progress.worst > wanted)) return 1;
  return wanted / progress.worst * (wanted / progress.worst);
}

}  // namespace

std::string format_error_bar(const SamplingProgress& progress, double wanted, int columns) {
  std::string text;
  const bool is_known = progress.rounds > 0;
  if (is_known && wanted > 0) {
    constexpr int kBar = 20;
    const int filled = static_cast<int>(kBar * share_of(progress, wanted));
    std::string bar(static_cast<std::size_t>(filled), '=');
    if (filled < kBar) bar += '>';
    bar.resize(kBar, ' ');
    text = absl::StrCat("[", bar, "] ");
  }
  absl::StrAppend(&text, samples_text(progress));
  if (is_known && !progress.worst_meter.empty())
    absl::StrAppend(&text, "  ", base::printable(progress.worst_meter), ": ", within_text(progress, wanted));
  text.resize(std::min(text.size(), static_cast<std::size_t>(std::max(columns - 1, 1))));
  return text;
}

std::string format_error_line(const SamplingProgress& progress, double wanted) {
  std::string text = samples_text(progress);
  if (progress.worst_meter.empty()) return text + ": all figures are exact";
  absl::StrAppend(&text, ": ", base::printable(progress.worst_meter), " is ", within_text(progress, wanted));
  return text;
}

void ErrorProgress::show(const SamplingProgress& progress) {
  if (mode_ == ProgressMode::kBar) {
    out_ << "\r\x1b[K" << format_error_bar(progress, wanted_, columns_) << std::flush;
    bar_shown_ = true;
  }
  if (mode_ == ProgressMode::kLines && progress.rounds > told_rounds_)
    out_ << format_error_line(progress, wanted_) << std::endl;
  told_rounds_ = progress.rounds;
}

void ErrorProgress::finish() {
  if (bar_shown_) out_ << std::endl;
  bar_shown_ = false;
}

}  // namespace tessera::client
