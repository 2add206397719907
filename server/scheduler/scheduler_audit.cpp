// Second opinions: whether the pixels that a host returns are right. The image of one ISA has the same bits wherever it
// is rendered, so two results of one unit that differ prove that one of two hosts is at fault.
#include <algorithm>
#include <map>
#include <set>

#include "absl/strings/str_cat.h"
#include "scheduler/scheduler.h"

namespace tessera::server {
namespace {

// Audits of one job that may wait at a time.
constexpr std::size_t kMaxAudits = 256;

// Audits of one job that are made, or made again, after a restart.
constexpr std::size_t kRestoredAudits = 32;

/// The same choice after a restart, and for every order of results.
bool chosen(const std::string& job, std::uint32_t unit, std::uint32_t one_in) {
  std::uint64_t x = 0xcbf29ce484222325u;
  for (const char letter : job) x = (x ^ static_cast<unsigned char>(letter)) * 0x100000001b3u;  // FNV-1a
  x += unit * 0x9e3779b97f4a7c15u;  // and the finisher of splitmix64 [Steele2014]
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return one_in != 0 && (x ^ (x >> 31)) % one_in == 0;
}

}  // namespace

/// Which audits were waiting is not journaled. They are asked for first of all, so they are among those of the latest
/// results.
void Scheduler::restore_audits(Job& job) {
  if (!job.open()) return;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> latest;  // sequence number, unit
  for (std::uint32_t unit = 0; unit < job.units.count(); ++unit) {
    if (job.units.state(unit) != UnitState::kDone || !chosen(job.request.id, unit, options_.audit_one_in)) continue;
    latest.emplace_back(job.units.result(unit).sequence, unit);
  }
  std::sort(latest.rbegin(), latest.rend());
  if (latest.size() > kRestoredAudits) latest.resize(kRestoredAudits);
  for (const auto& [sequence, unit] : latest) {
    const AcceptedResult& accepted = job.units.result(unit);
    if (accepted.host >= hosts_.size() || distrusted_.contains(hosts_[accepted.host])) continue;
    job.audits[unit] = {.opinions = {{hosts_[accepted.host], accepted.fingerprint}}, .out = false};
  }
  if (!job.audits.empty()) auditing_.insert(job.number);
}

bool Scheduler::audit_wanted(const Job& job, std::uint32_t unit, const std::string& host) const {
  return chosen(job.request.id, unit, options_.audit_one_in) && job.audits.size() < kMaxAudits &&
         anyone_can_audit(job, {.opinions = {{host, 0}}, .out = false});
}

bool Scheduler::can_audit(const Worker& worker, const Job& job, const Audit& audit) const {
  return may_work_on(worker, job, worker.last_seen) &&
         std::none_of(audit.opinions.begin(), audit.opinions.end(),
                      [&](const auto& opinion) { return opinion.first == worker.info.host; });
}

bool Scheduler::anyone_can_audit(const Job& job, const Audit& audit) const {
  return std::any_of(workers_.begin(), workers_.end(),
                     [&](const auto& entry) { return can_audit(entry.second, job, audit); });
}

/// A result of a unit that is done.
absl::StatusOr<CompleteDecision> Scheduler::second_result(Job& job, const Worker& worker, std::uint32_t unit,
                                                          ResultFingerprint result) {
  const AcceptedResult& accepted = job.units.result(unit);
  const bool equal = accepted.fingerprint == result;
  const std::string& maker = accepted.host < hosts_.size() ? hosts_[accepted.host] : worker.info.host;
  const absl::Status differs = absl::AlreadyExistsError(absl::StrCat(
      "unit ", unit, " of job ", job.request.id, " is done, with a different result: one of two workers is at fault"));
  const auto found = job.audits.find(unit);
  const bool counts = job.open() && worker.info.host != maker && !distrusted_.contains(worker.info.host) &&
                      worker.supports(job.request.isa);
  // A copy that agrees is no news where nobody asked.
  if (counts && (found != job.audits.end() || !equal)) {
    Audit& audit = job.audits[unit];
    if (audit.opinions.empty()) audit.opinions.emplace_back(maker, accepted.fingerprint);
    const bool heard = std::any_of(audit.opinions.begin(), audit.opinions.end(),
                                   [&](const auto& opinion) { return opinion.first == worker.info.host; });
    if (!heard) audit.opinions.emplace_back(worker.info.host, result);
    auditing_.insert(job.number);
    adjudicate(job, unit);
    settle(job);
  }
  if (equal) return CompleteDecision{.duplicate = true};
  return differs;
}

/// Decides by majority of hosts; without one, the audit goes on.
void Scheduler::adjudicate(Job& job, std::uint32_t unit) {
  const auto found = job.audits.find(unit);
  const std::vector<std::pair<std::string, ResultFingerprint>> opinions = found->second.opinions;
  std::map<ResultFingerprint, std::size_t> votes;
  for (const auto& [host, result] : opinions) ++votes[result];
  const auto winner =
      std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (2 * winner->second <= opinions.size()) return;
  job.audits.erase(found);
  if (job.audits.empty()) auditing_.erase(job.number);
  for (const LeaseId lease : leases_.of_unit(job.number, unit)) drop_lease(lease);
  for (const auto& [host, result] : opinions) {
    if (result == winner->first) continue;
    const std::string why = absl::StrCat("its result of unit ", unit, " of job ", job.request.id,
                                         " differs from that of ", winner->second, " other hosts");
    note(job, absl::StrCat("host ", host, " is in quarantine: ", why));
    distrust(host, why);
  }
}

void Scheduler::distrust(const std::string& host, const std::string& why) {
  if (!distrusted_.emplace(host, why).second) return;
  FarmEvent& event = record(FarmEvent::Kind::kDistrusted, "");
  event.host = host;
  event.text = why;
  std::vector<std::string> its_workers;
  for (const auto& [id, worker] : workers_) {
    if (worker.info.host == host) its_workers.push_back(id);
  }
  std::sort(its_workers.begin(), its_workers.end());  // the same order in every run
  for (const std::string& worker : its_workers) {
    for (const LeaseId lease : leases_.of_worker(worker)) drop_lease(lease);
  }
  for (const auto& [number, job] : jobs_) {
    if (job->open()) revoke_results(*job, host);
  }
}

/// Everything that the host did for an open job is done again.
void Scheduler::revoke_results(Job& job, const std::string& host) {
  const std::vector<std::uint32_t> units = job.units.done_by(number_of_host(host));
  for (auto audit = job.audits.begin(); audit != job.audits.end();) {
    auto& opinions = audit->second.opinions;
    std::erase_if(opinions, [&](const auto& opinion) { return opinion.first == host; });
    audit = opinions.empty() ? job.audits.erase(audit) : std::next(audit);
  }
  for (const std::uint32_t unit : units) revoke(job, unit);
  if (job.audits.empty()) auditing_.erase(job.number);
  if (units.empty()) return;
  note(job, absl::StrCat(units.size(), " units of host ", host, " are done again"));
}

/// The unit, which is done, is to be done again.
void Scheduler::revoke(Job& job, std::uint32_t unit) {
  job.audits.erase(unit);
  for (const LeaseId lease : leases_.of_unit(job.number, unit)) drop_lease(lease);
  FarmEvent& event = record(FarmEvent::Kind::kRevoked, job.request.id);
  const AcceptedResult& revoked = job.units.result(unit);
  event.unit = unit;
  event.value = revoked.sequence;
  if (revoked.host < hosts_.size()) event.host = hosts_[revoked.host];
  job.units.put_back(unit);
  ++job.revision;
}

absl::Status Scheduler::revoke_result(std::string_view id, std::uint32_t unit, std::uint64_t sequence,
                                      const std::string& why) {
  const absl::StatusOr<Job*> found = find_job(id);
  if (!found.ok()) return found.status();
  Job& job = **found;
  if (!job.open() && job.state != v1::DONE && job.state != v1::INCOMPLETE) {
    return absl::FailedPreconditionError(absl::StrCat("job ", job.request.id, " failed or was cancelled"));
  }
  if (unit >= job.units.count() || job.units.state(unit) != UnitState::kDone ||
      job.units.result(unit).sequence != sequence) {
    return absl::OkStatus();
  }
  if (!job.open()) {
    record(FarmEvent::Kind::kReopened, job.request.id);
    reopen(job);
  }
  revoke(job, unit);
  if (job.audits.empty()) auditing_.erase(job.number);
  note(job, absl::StrCat("unit ", unit, " is done again: ", why));
  return absl::OkStatus();
}

void Scheduler::trust_host(const std::string& host) {
  if (distrusted_.erase(host) > 0) record(FarmEvent::Kind::kTrusted, "").host = host;
}

}  // namespace tessera::server
