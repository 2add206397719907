#include "service/job/host_shares.h"

#include <algorithm>
#include <cmath>

namespace tessera::server {

using std::chrono::nanoseconds;

namespace {

// A damaged journal may say anything.
constexpr double kMostLogTime = 100;
// The usual pace is made anew after an eighth as many results as there are hosts.
constexpr std::size_t kUnitsPerHost = 8;

}  // namespace

HostShares::Share* HostShares::share_of(const std::string& host) {
  if (const auto found = hosts_.find(host); found != hosts_.end()) return &found->second;
  if (hosts_.size() >= kMostHosts) return nullptr;
  Share& share = hosts_[host];
  share.pace.worker = hosts_.size();
  share.pace.log_time = usual_.log_time;
  return &share;
}

void HostShares::count(const std::string& host, std::uint32_t units) {
  if (Share* const share = share_of(host)) share->units += units;
}

void HostShares::discount(const std::string& host, std::uint32_t units) {
  const auto found = hosts_.find(host);
  if (found != hosts_.end()) found->second.units -= std::min(units, found->second.units);
}

void HostShares::clear_counts() {
  for (auto& [host, share] : hosts_) share.units = 0;
}

void HostShares::time(const std::string& host, nanoseconds taken) {
  if (taken <= nanoseconds{0}) return;
  Share* const share = share_of(host);
  if (share == nullptr) return;
  ++share->timed_units;
  job_.compare(share->pace, usual_, std::log(static_cast<double>(taken.count())));
  // Looking at all hosts with every unit of a large farm would take longer than the rest.
  if (++timed_ * kUnitsPerHost < hosts_.size()) return;
  timed_ = 0;
  usual_ = usual();
}

UsualPace HostShares::usual() const {
  std::vector<const WorkerPace*> paces;
  for (const auto& [host, share] : hosts_) {
    if (share.timed_units > 0) paces.push_back(&share.pace);
  }
  return usual_pace(paces);
}

HostShares HostShares::restored(const Saved& saved) {
  HostShares shares;
  for (const v1::JobCost::Host& host : saved) {
    Share* const share = shares.share_of(host.name());
    if (share == nullptr) break;
    share->units = host.units();
    share->timed_units = host.timed_units();
    // Negated, so that a NaN is refused too.
    if (!(host.pace_variance() > 0) || !(std::abs(host.pace()) <= kMostLogTime)) continue;
    share->pace.log_time = host.pace();
    share->pace.variance = std::min(host.pace_variance(), WorkerPace::kUnknownVariance);
  }
  shares.usual_ = shares.usual();
  return shares;
}

void HostShares::save(Saved& saved) const {
  for (const auto& [name, share] : hosts_) {
    v1::JobCost::Host& host = *saved.Add();
    host.set_name(name);
    host.set_units(share.units);
    host.set_timed_units(share.timed_units);
    host.set_pace(share.pace.log_time);
    host.set_pace_variance(share.pace.variance);
  }
}

std::uint32_t HostShares::units_of(const std::string& host) const {
  const auto found = hosts_.find(host);
  return found == hosts_.end() ? 0 : found->second.units;
}

std::vector<std::string> HostShares::hosts() const {
  std::vector<std::string> names;
  for (const auto& [name, share] : hosts_) {
    if (share.units > 0) names.push_back(name);
  }
  return names;
}

std::vector<HostShare> HostShares::slow() const {
  const UsualPace usual_now = usual();
  std::vector<HostShare> found;
  for (const auto& [host, share] : hosts_) {
    const double slowness = slowness_of(share.pace, usual_now);
    if (share.timed_units > 0 && slowness >= kSlow) {
      found.push_back({.host = host, .timed_units = share.timed_units, .slowness = slowness});
    }
  }
  std::sort(found.begin(), found.end(),
            [](const HostShare& a, const HostShare& b) { return a.slowness > b.slowness; });
  return found;
}

}  // namespace tessera::server
