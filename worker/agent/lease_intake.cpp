#include "agent/lease_intake.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "telemetry/log.h"

namespace tessera::agent {

LeaseIntake::LeaseIntake(LeaseTable& leases, Loaded loaded, std::string address, std::size_t full)
    : leases_(leases), loaded_(std::move(loaded)), address_(std::move(address)), full_(full) {}

LeaseIntake::Ask LeaseIntake::ask(v1::LeaseRequest& request) {
  Ask ask{.units = leases_.ask(full_), .known_specs = known(), .deliveries = leases_.deliveries()};
  if (ask.units == 0) return ask;
  request.set_max_units(static_cast<std::uint32_t>(ask.units));
  for (std::string& digest : loaded_.scene_digests()) request.add_loaded_scene_digests(std::move(digest));
  for (const auto& [job_id, spec] : *ask.known_specs) request.add_known_job_ids(job_id);
  return ask;
}

void LeaseIntake::answered(const Ask& ask, const v1::LeaseResponse* response) {
  if (response != nullptr) take(ask, *response);
  leases_.answered(ask.units);
}

void LeaseIntake::take(const Ask& ask, const v1::LeaseResponse& response) {
  const Specs& known = *ask.known_specs;
  Specs sent;
  for (const auto& [job_id, spec] : response.specs())
    sent.emplace(job_id, std::make_shared<const v1::JobSpec>(spec));
  for (const std::string& job_id : know(sent)) loaded_.forget_job(job_id);
  for (const std::string& job_id : response.over_job_ids()) {
    forget(job_id);
    loaded_.forget_job(job_id);
  }
  for (const v1::Lease& lease : response.leases()) {
    const v1::LeaseToken& token = lease.token();
    auto spec = known.find(token.job_id());
    const bool is_known = spec != known.end();
    if (!is_known) spec = sent.find(token.job_id());
    if (!is_known && spec == sent.end()) {
      // The lease runs out.
      telemetry::log(
          spdlog::level::err, {.job = token.job_id(), .unit = token.unit_index(), .attempt = token.attempt()},
          "{} leased unit {} of job {} without the job's spec", address_, token.unit_index(), token.job_id());
      continue;
    }
    leases_.add(lease, spec->second, ask.deliveries);
    spdlog::debug("unit {} of job {} leased", token.unit_index(), token.job_id());
  }
}

std::shared_ptr<const LeaseIntake::Specs> LeaseIntake::known() {
  const std::lock_guard lock{mutex_};
  return recent_specs_;
}

void LeaseIntake::forget(const std::string& job_id) {
  const std::lock_guard lock{mutex_};
  auto specs = std::make_shared<Specs>(*recent_specs_);
  specs->erase(job_id);
  std::erase(recent_job_ids_, job_id);
  recent_specs_ = std::move(specs);
}

std::vector<std::string> LeaseIntake::know(const Specs& sent) {
  std::vector<std::string> forgotten;
  if (sent.empty()) return forgotten;
  const std::lock_guard lock{mutex_};
  // A copy: whoever has asked goes by what was known then.
  auto specs = std::make_shared<Specs>(*recent_specs_);
  for (const auto& [job_id, spec] : sent) {
    if (!specs->emplace(job_id, spec).second) continue;
    recent_job_ids_.push_back(job_id);
    if (recent_job_ids_.size() <= kKnownJobs) continue;
    specs->erase(recent_job_ids_.front());
    forgotten.push_back(std::move(recent_job_ids_.front()));
    recent_job_ids_.pop_front();
  }
  recent_specs_ = std::move(specs);
  return forgotten;
}

}  // namespace tessera::agent
