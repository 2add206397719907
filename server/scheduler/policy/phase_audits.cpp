// Audits of phases, of whose results all of a picture is made [docs/decisions/0026-phases.md].
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "scheduler/policy/audits.h"

namespace tessera::server {

void Audits::set_disputed_aside(FarmJob& job, std::uint32_t unit) {
  const Opinions opinions = job.audits.find(unit)->opinions;
  std::vector<std::string> hosts;
  for (const auto& [host, result] : opinions) hosts.push_back(host);
  const std::string message = absl::StrCat(short_name(hosts[0]), " and ", short_name(hosts[1]),
                                           " disagree on what it makes, and there is nobody else to decide");
  steps_.revoke(job, job.units.result(unit));
  if (job.audits.empty()) state_.auditing.erase(job.number);
  // One that lies about one unit may lie about all: people are told once.
  if (!faults_.has_disputes(job)) state_.note(job, absl::StrCat("unit ", unit, ": ", message));
  faults_.set_disputed_aside(job, unit, hosts, message);
}

bool Audits::suspect_inputs(FarmJob& job, std::uint32_t unit, const std::string& why) {
  const PhasePlan& phases = job.request.plan->phases();
  std::vector<std::uint32_t> asked;
  for (const std::uint32_t source : phases.sources(unit)) {
    if (job.confirmed.contains(source) || job.questioned.contains(source)) continue;
    if (job.units.state(source) != UnitState::kDone) continue;
    if (job.audits.find(source) == nullptr) {
      const AcceptedResult& accepted = job.units.result(source);
      if (accepted.host >= state_.hosts_by_number.size()) continue;
      const Audit audit = first_opinion(job, accepted);
      if (!anyone_can_make(job, audit)) continue;
      job.audits.put(source, audit);
    }
    asked.push_back(source);
  }
  if (asked.empty()) return false;
  job.suspected.insert(asked.begin(), asked.end());
  job.questioned.insert(asked.begin(), asked.end());
  state_.auditing.insert(job.number);
  steps_.close(job, phases.step_begin(unit));
  state_.note(job, absl::StrCat("unit ", unit, " could not be made of what it reads, so ", asked.size(),
                                " units of the phases are made again by others: ", why));
  return true;
}

void Audits::release(FarmJob& job) {
  if (job.suspected.empty()) return;
  std::erase_if(job.suspected, [&](std::uint32_t unit) { return job.audits.find(unit) == nullptr; });
  if (job.suspected.empty()) steps_.open(job);
}

}  // namespace tessera::server
