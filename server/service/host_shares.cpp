#include "service/host_shares.h"

#include <algorithm>

namespace tessera::server {

using std::chrono::nanoseconds;

namespace {

// A damaged journal may say more; room for sums is left.
constexpr std::uint64_t kLongestSaved = std::uint64_t{1} << 62;

}  // namespace

HostShares::Share* HostShares::share_of(const std::string& host) {
  if (hosts_.size() >= kMostHosts && !hosts_.contains(host)) return nullptr;
  return &hosts_[host];
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
  if (Share* const share = share_of(host)) {
    ++share->timed_units;
    share->total += taken;
  }
}

HostShares HostShares::restored(const Saved& saved) {
  HostShares shares;
  for (const v1::JobCost::Host& host : saved) {
    if (shares.hosts_.size() >= kMostHosts) break;
    shares.hosts_[host.name()] = {
        .units = host.units(),
        .timed_units = host.timed_units(),
        .total = nanoseconds(static_cast<std::int64_t>(std::min(host.timed_ns(), kLongestSaved)))};
  }
  return shares;
}

void HostShares::save(Saved& saved) const {
  for (const auto& [name, share] : hosts_) {
    v1::JobCost::Host& host = *saved.Add();
    host.set_name(name);
    host.set_units(share.units);
    host.set_timed_units(share.timed_units);
    host.set_timed_ns(static_cast<std::uint64_t>(share.total.count()));
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

nanoseconds HostShares::usual() const {
  std::vector<nanoseconds> means;
  for (const auto& [host, share] : hosts_) {
    if (share.timed_units >= kLeastTimedUnits) means.push_back(share.mean());
  }
  if (means.size() < 2) return nanoseconds{0};
  // Of an even number the lower one: of two hosts, the faster says what is usual.
  const auto middle = means.begin() + static_cast<std::ptrdiff_t>((means.size() - 1) / 2);
  std::nth_element(means.begin(), middle, means.end());
  return *middle;
}

std::vector<HostShare> HostShares::slow() const {
  const nanoseconds least = usual();
  std::vector<HostShare> found;
  if (least <= nanoseconds{0}) return found;
  for (const auto& [host, share] : hosts_) {
    if (share.timed_units >= kLeastTimedUnits && share.mean() >= kSlow * least) {
      found.push_back({.host = host, .units = share.timed_units, .mean = share.mean()});
    }
  }
  std::sort(found.begin(), found.end(), [](const HostShare& a, const HostShare& b) { return a.mean > b.mean; });
  return found;
}

}  // namespace tessera::server
