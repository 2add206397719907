#include "scheduler/farm_state.h"

#include <utility>

namespace tessera::server {

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
  const auto [found, added] = host_numbers.emplace(host, static_cast<HostNumber>(hosts.size()));
  if (added) hosts.push_back(host);
  return found->second;
}

}  // namespace tessera::server
