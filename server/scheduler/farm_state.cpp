#include "scheduler/farm_state.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace tessera::server {

void LatestCosts::add(const std::string& identity, double unit_ms) {
  const std::size_t who = std::hash<std::string>{}(identity);
  const auto is_its = [who](const auto& entry) { return entry.first == who; };
  if (static_cast<std::size_t>(std::count_if(latest_.begin(), latest_.end(), is_its)) >= kKeptOfOne)
    latest_.erase(std::find_if(latest_.begin(), latest_.end(), is_its));
  if (latest_.size() == kKept) latest_.erase(latest_.begin());
  latest_.emplace_back(who, unit_ms);
}

std::optional<double> LatestCosts::of_others(const std::string& identity) const {
  const std::size_t who = std::hash<std::string>{}(identity);
  std::vector<double> costs;
  for (const auto& [maker, cost] : latest_) {
    if (maker != who) costs.push_back(cost);
  }
  if (costs.size() < kFewest) return std::nullopt;
  const auto middle = costs.begin() + static_cast<std::ptrdiff_t>(costs.size() / 2);
  std::nth_element(costs.begin(), middle, costs.end());
  return *middle;
}

FarmEvent& FarmState::record(FarmEvent::Kind kind, const std::string& job) {
  FarmEvent& event = events.emplace_back();
  event.kind = kind;
  event.job = job;
  return event;
}

void FarmState::note(FarmJob& job, std::string text) {
  if (job.notes.size() >= kMaxListed) return;
  record(FarmEvent::Kind::kNote, job.request.id).text = text;
  job.notes.push_back(std::move(text));
}

HostNumber FarmState::number_of_host(const std::string& host) {
  const auto [found, added] = host_numbers.emplace(host, static_cast<HostNumber>(hosts_by_number.size()));
  if (added) hosts_by_number.push_back(host);
  return found->second;
}

}  // namespace tessera::server
