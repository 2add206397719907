#include "service/farm/lived_time.h"

#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/private_file.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

constexpr char kHeading[] = "tessera lived-time 1";

}  // namespace

LivedTime::LivedTime(std::filesystem::path file) : file_(std::move(file)) {
  if (file_.empty() || !std::filesystem::exists(file_)) return;
  if (absl::Status status = read(); !status.ok()) {
    spdlog::error("{}; jobs that are over are kept as if they ended now", std::string(status.message()));
    lived_ = Time{0};
    ends_.clear();
  }
}

absl::Status LivedTime::read() {
  std::ifstream in(file_);
  std::string line, job;
  std::int64_t milliseconds = 0;
  const auto damaged = [&] { return absl::DataLossError(absl::StrCat(file_.string(), " cannot be read")); };
  if (!std::getline(in, line) || line != kHeading || !(in >> milliseconds) || milliseconds < 0)
    return damaged();
  lived_ = Time{milliseconds};
  while (in >> job) {
    if (!(in >> milliseconds) || milliseconds < 0 || Time{milliseconds} > lived_) return damaged();
    ends_[job] = Time{milliseconds};
  }
  return in.eof() ? absl::OkStatus() : damaged();
}

LivedTime::Time LivedTime::advance(Time steady, Time wall) {
  const Time lived = steady_ ? steady - *steady_ : Time{0};
  const Time set = wall_ ? wall - *wall_ - lived : Time{0};
  lived_ += lived;
  steady_ = steady;
  wall_ = wall;
  return set;
}

LivedTime::Time LivedTime::since_end_of(const std::string& job) {
  return lived_ - ends_.emplace(job, lived_).first->second;
}

std::string LivedTime::to_text() const {
  if (file_.empty()) return "";
  std::string text = absl::StrCat(kHeading, "\n", lived_.count(), "\n");
  for (const auto& [job, end] : ends_) absl::StrAppend(&text, job, " ", end.count(), "\n");
  return text;
}

absl::Status LivedTime::save(const std::filesystem::path& file, const std::string& text) {
  return file.empty() ? absl::OkStatus() : base::replace_file(file, 0600, text);
}

}  // namespace tessera::server
