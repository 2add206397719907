#include "command/jobs/job_news.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "base/printable.h"

namespace tessera::client {
namespace {

std::string text_of(const v1::FailedUnit& failed) {
  const v1::UnitFailure& failure = failed.failure();
  const std::string host = base::printable(failure.host()), unit = name_of(failed);
  if (failure.lost()) return absl::StrCat(unit, " was lost with a worker on ", host);
  return absl::StrCat(unit, " failed on ", host, ": ", base::printable(failure.message()));
}

}  // namespace

std::string name_of(const v1::FailedUnit& failed) {
  if (failed.ranges() <= 1) return absl::StrCat("unit ", failed.unit_index());
  return absl::StrCat("the run of ", failed.ranges(), " units from ", failed.unit_index());
}

std::vector<std::string> JobNews::lines(const v1::JobStatus& status) {
  std::vector<std::string> lines;
  if (status.paused() != paused_) {
    paused_ = status.paused();
    lines.push_back(paused_ ? absl::StrCat("job ", status.job_id(),
                                           " is paused; it goes on after: tessera resume ", status.job_id())
                            : absl::StrCat("job ", status.job_id(), " goes on"));
  }
  if (!status.left_out().empty() && status.left_out() != left_out_) {
    left_out_ = status.left_out();
    lines.push_back(absl::StrCat("warning: left out: ", base::printable(left_out_)));
  }
  // A coordinator that was started again counts from 0.
  const std::uint64_t more = status.failures() - std::min(failures_, status.failures());
  failures_ = status.failures();
  const int listed = status.latest_failures_size();
  const int told =
      static_cast<int>(std::min<std::uint64_t>({more, kMostFailures, static_cast<std::uint64_t>(listed)}));
  if (more > static_cast<std::uint64_t>(told)) {
    lines.push_back(absl::StrCat(more - static_cast<std::uint64_t>(told),
                                 " units failed before; tessera job ", status.job_id(),
                                 " tells what is known"));
  }
  for (int i = listed - told; i < listed; ++i) lines.push_back(text_of(status.latest_failures(i)));
  return lines;
}

}  // namespace tessera::client
