#include "service/job/completion_rate.h"

#include <algorithm>

namespace tessera::server {

void CompletionRate::note(std::uint64_t units_done, Time now) {
  units_ = units_done;
  if (points_.empty() || now - points_.back().time >= kStep) points_.push_back({now, units_done});
  while (points_.size() > 2 && now - points_[1].time > kWindow) points_.pop_front();
}

std::optional<Time> CompletionRate::time_for(std::uint64_t left, Time now) const {
  if (points_.empty()) return std::nullopt;
  const Point& begin = points_.front();
  const std::uint64_t done = units_ - std::min(units_, begin.units);
  const auto span = static_cast<double>((now - begin.time).count());
  if (done == 0 || span <= 0) return std::nullopt;
  return Time{static_cast<Time::rep>(span * static_cast<double>(left) / static_cast<double>(done))};
}

}  // namespace tessera::server
