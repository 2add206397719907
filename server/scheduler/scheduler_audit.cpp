// Second opinions: whether the pixels that a host returns are right. Results of one arithmetic class have the
// same bits wherever they are rendered, so two of one unit that differ prove that one of two hosts is at
// fault. Results of two classes say nothing of each other.
#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "base/nearest_name.h"
#include "scheduler/identity.h"
#include "scheduler/scheduler.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

// Audits of one job that may wait at a time.
constexpr std::size_t kMaxAudits = 256;

// Audits of one job that are made, or made again, after a restart.
constexpr std::size_t kRestoredAudits = 32;

/// The same choice after a restart, and for every order of results; who does not have the key cannot tell it.
bool chosen(const SchedulerOptions& options, const std::string& job, std::uint32_t unit) {
  if (options.audit_one_in == 0) return false;
  const std::string digest = wire::sha256_hex(absl::StrCat(options.audit_key, " ", job, " ", unit));
  return std::stoull(digest.substr(0, 15), nullptr, 16) % options.audit_one_in == 0;
}

/// Whether all opinions are of one identity.
bool is_of_one(const Opinions& opinions) {
  return std::all_of(opinions.begin(), opinions.end(), [&](const auto& opinion) {
    return identity_of(opinion.first) == identity_of(opinions.front().first);
  });
}

struct Verdict {
  ResultFingerprint result = 0;
  std::size_t votes = 0;
  std::map<std::string, ResultFingerprint> voters;  // identities, or hosts where all are of one
};

/// Returns what more than half of the identities say; none when there is no such thing.
std::optional<Verdict> verdict_of(const Opinions& opinions) {
  const bool by_host = is_of_one(opinions);
  Verdict verdict;
  // An identity has its first opinion only.
  for (const auto& [host, result] : opinions)
    verdict.voters.emplace(by_host ? host : identity_of(host), result);
  std::map<ResultFingerprint, std::size_t> votes;
  for (const auto& [voter, result] : verdict.voters) ++votes[result];
  const auto winner = std::max_element(votes.begin(), votes.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (winner == votes.end() || 2 * winner->second <= verdict.voters.size()) return std::nullopt;
  verdict.result = winner->first;
  verdict.votes = winner->second;
  return verdict;
}

}  // namespace

/// Which audits were waiting is not journaled, but which were asked for, and what came of it where hosts
/// disagree. They are asked for first of all, so those that were waiting are among those of the latest
/// results.
void Scheduler::restore_audits(Job& job) {
  if (!job.open()) return;
  job.audits.drop_opinions([&](const std::string& host) { return !trusts(host); });
  job.audits.erase_if([](std::uint32_t, const Audit& audit) {
    return audit.opinions.size() < 2 || verdict_of(audit.opinions);
  });
  std::vector<AcceptedResult> latest = job.units.results();
  std::erase_if(latest, [&](const AcceptedResult& result) {
    return !chosen(options_, job.request.id, result.units.first) || job.audited.contains(result.units.first);
  });
  if (latest.size() > kRestoredAudits) latest.erase(latest.begin(), latest.end() - kRestoredAudits);
  for (const AcceptedResult& accepted : latest) {
    if (accepted.host >= hosts_.size() || !trusts(hosts_[accepted.host])) continue;
    job.audits.put(accepted.units.first, first_opinion(job, accepted));
  }
  if (!job.audits.empty()) auditing_.insert(job.number);
}

/// The opinion of whoever rendered the accepted result.
Audit Scheduler::first_opinion(const Job& job, const AcceptedResult& accepted) const {
  return {.opinions = {{hosts_[accepted.host], accepted.fingerprint}},
          .arithmetic_class = class_of_result(job, accepted)};
}

bool Scheduler::audit_wanted(const Job& job, const AcceptedResult& accepted) const {
  return chosen(options_, job.request.id, accepted.units.first) && job.audits.size() < kMaxAudits &&
         anyone_can_audit(job, first_opinion(job, accepted));
}

/// Whether the opinion of this host would be a new one: of an identity that has not spoken, for it has one
/// vote only. Where the whole farm is one identity, its hosts watch over each other: that finds machines that
/// are broken.
bool Scheduler::may_speak(const Audit& audit, const std::string& host) const {
  const bool by_host = is_of_one_identity() && is_of_one(audit.opinions);
  return std::none_of(audit.opinions.begin(), audit.opinions.end(), [&](const auto& opinion) {
    return opinion.first == host || (!by_host && identity_of(opinion.first) == identity_of(host));
  });
}

/// An audit as it was journaled. Of a result that was revoked since, nothing is to be known any more.
void Scheduler::restore_audit(Job& job, const FarmEvent& event) {
  if (job.units.state(event.unit) != UnitState::kDone) return;
  const AcceptedResult& accepted = job.units.result(event.unit);
  const bool same = accepted.units.first == event.unit && accepted.sequence == event.value;
  if (!same || accepted.host >= hosts_.size()) return;
  job.audited.insert(event.unit);
  ResultFingerprint opinion = 0;
  if (!absl::SimpleAtoi(event.text, &opinion)) return;
  if (job.audits.find(event.unit) == nullptr) job.audits.put(event.unit, first_opinion(job, accepted));
  job.audits.add_opinion(event.unit, event.host, opinion);
}

bool Scheduler::can_audit(const Worker& worker, const Job& job, const Audit& audit) const {
  const std::string* const own = class_for(worker, job);
  return !audit.is_over() && own != nullptr && *own == audit.arithmetic_class &&
         may_work_on(worker, job, worker.last_seen) && may_speak(audit, worker.info.host);
}

bool Scheduler::anyone_can_audit(const Job& job, const Audit& audit) const {
  return std::any_of(workers_.begin(), workers_.end(),
                     [&](const auto& entry) { return can_audit(entry.second, job, audit); });
}

/// A result of the units of one that was accepted.
absl::StatusOr<CompleteDecision> Scheduler::second_result(Job& job, const Worker& worker,
                                                          const AcceptedResult& accepted,
                                                          ResultFingerprint result) {
  const std::uint32_t unit = accepted.units.first;
  const std::string* const own = class_for(worker, job);
  if (own == nullptr || *own != class_of_result(job, accepted)) return CompleteDecision{.duplicate = true};
  const bool equal = accepted.fingerprint == result;
  const std::string& maker = accepted.host < hosts_.size() ? hosts_[accepted.host] : worker.info.host;
  const absl::Status differs = absl::AlreadyExistsError(
      absl::StrCat("unit ", unit, " of job ", job.request.id,
                   " is done, with a different result: one of two workers is at fault"));
  const bool asked = job.audits.find(unit) != nullptr;
  const bool counts = job.open() && worker.info.host != maker && trusts(worker.info.host);
  // A copy that agrees is no news where nobody asked.
  if (counts && (asked || !equal)) {
    if (!asked) job.audits.put(unit, first_opinion(job, accepted));
    const Audit& audit = *job.audits.find(unit);
    if (may_speak(audit, worker.info.host)) {
      job.audits.add_opinion(unit, worker.info.host, result);
      if (!equal || audit.opinions.size() > 2) {
        FarmEvent& event = record(FarmEvent::Kind::kAudit, job.request.id);
        event.unit = unit;
        event.value = accepted.sequence;
        event.host = worker.info.host;
        event.text = absl::StrCat(result);
      }
    }
    auditing_.insert(job.number);
    adjudicate(job, unit);
    settle(job);
  }
  if (equal) return CompleteDecision{.duplicate = true};
  return differs;
}

/// Decides by majority of identities, or of hosts where all are of one identity; without a majority, the
/// audit goes on.
void Scheduler::adjudicate(Job& job, std::uint32_t unit) {
  const std::optional<Verdict> verdict = verdict_of(job.audits.find(unit)->opinions);
  if (!verdict) return;
  job.audits.erase(unit);
  if (job.audits.empty()) auditing_.erase(job.number);
  for (const LeaseId lease : leases_.of_unit(job.number, unit)) drop_lease(lease);
  for (const auto& [voter, result] : verdict->voters) {
    if (result == verdict->result) continue;
    const std::string why = absl::StrCat("its result of unit ", unit, " of job ", job.request.id,
                                         " differs from that of ", verdict->votes, " other hosts");
    note(job, absl::StrCat("host ", short_name(voter), " is in quarantine: ", why));
    distrust(voter, why);
  }
}

/// `subject`: a host, or an identity and so all of its hosts.
void Scheduler::distrust(const std::string& subject, const std::string& why) {
  if (!distrusted_.emplace(subject, why).second) return;
  FarmEvent& event = record(FarmEvent::Kind::kDistrusted, "");
  event.host = subject;
  event.text = why;
  std::vector<std::string> its_workers;
  for (auto& [id, worker] : workers_) {
    if (!covers(subject, worker.info.host)) continue;
    its_workers.push_back(id);
    count(worker);
  }
  std::sort(its_workers.begin(), its_workers.end());  // the same order in every run
  for (const std::string& worker : its_workers) {
    for (const LeaseId lease : leases_.of_worker(worker)) drop_lease(lease);
  }
  for (const auto& [number, job] : jobs_) {
    if (job->open()) revoke_results(*job, subject);
  }
}

/// Everything that the host, or the hosts of the identity, did for an open job is done again.
void Scheduler::revoke_results(Job& job, const std::string& subject) {
  std::vector<AcceptedResult> results = job.units.results();
  std::erase_if(results, [&](const AcceptedResult& result) {
    return result.host >= hosts_.size() || !covers(subject, hosts_[result.host]);
  });
  job.audits.drop_opinions([&](const std::string& host) { return covers(subject, host); });
  job.audits.erase_if([](std::uint32_t, const Audit& audit) { return audit.opinions.empty(); });
  std::erase_if(job.renderers,
                [&](HostNumber host) { return host < hosts_.size() && covers(subject, hosts_[host]); });
  std::uint32_t units = 0;
  for (const AcceptedResult& result : results) {
    units += result.units.count;
    // It may have been made of another one of them.
    if (job.units.state(result.units.first) == UnitState::kDone &&
        job.units.result(result.units.first).sequence == result.sequence) {
      revoke(job, result);
    }
  }
  if (job.audits.empty()) auditing_.erase(job.number);
  if (results.empty()) return;
  note(job, absl::StrCat(units, " units of host ", short_name(subject), " are done again"));
}

/// The units of a result that counts are to be done again, and all that was made of it.
void Scheduler::revoke(Job& job, const AcceptedResult& result) {
  revoke_dependents(job, result.units.first);
  revoke_alone(job, result);
}

void Scheduler::revoke_alone(Job& job, const AcceptedResult& result) {
  job.audits.erase(result.units.first);
  job.audited.erase(result.units.first);
  for (const LeaseId lease : leases_.of_unit(job.number, result.units.first)) drop_lease(lease);
  FarmEvent& event = record(FarmEvent::Kind::kRevoked, job.request.id);
  event.unit = result.units.first;
  event.value = result.sequence;
  if (result.host < hosts_.size()) event.host = hosts_[result.host];
  for (const std::uint32_t unit : result.units) job.units.put_back(unit);
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
  revoke(job, job.units.result(unit));
  if (job.audits.empty()) auditing_.erase(job.number);
  note(job, absl::StrCat("unit ", unit, " is done again: ", why));
  return absl::OkStatus();
}

/// Whether all workers that are trusted are of one identity, so that only its hosts can be told apart.
bool Scheduler::is_of_one_identity() const {
  std::size_t trusted = 0;
  for (const auto& [identity, workers] : identities_) {
    if (!distrusted_.contains(identity) && ++trusted > 1) return false;
  }
  return true;
}

std::optional<std::string> Scheduler::why_distrusted(const std::string& host) const {
  if (distrusted_.empty()) return std::nullopt;
  for (const std::string& subject : {host, identity_of(host)}) {
    if (const auto found = distrusted_.find(subject); found != distrusted_.end()) return found->second;
  }
  return std::nullopt;
}

absl::Status Scheduler::trust_host(const std::string& text) {
  std::set<std::string> known;  // hosts that are meant
  for (const std::string& host : hosts_) {
    if (is_meant(text, host)) known.insert(host);
  }
  for (const auto& [id, worker] : workers_) {
    if (is_meant(text, worker.info.host)) known.insert(worker.info.host);
  }
  // An identity in quarantine is also meant by the names of its hosts.
  std::vector<std::string> meant;
  for (const auto& distrusted : distrusted_) {
    const std::string& subject = distrusted.first;
    const auto is_its_host = [&](const std::string& host) { return covers(subject, host); };
    if (is_meant(text, subject) || std::any_of(known.begin(), known.end(), is_its_host))
      meant.push_back(subject);
  }
  if (meant.size() > 1) {
    return absl::FailedPreconditionError(absl::StrCat("\"", text, "\" may be ", short_name(meant[0]), " or ",
                                                      short_name(meant[1]), ": name one of them"));
  }
  if (meant.empty()) {
    if (!known.empty()) return absl::OkStatus();
    std::vector<std::string> names;
    for (const std::string& host : hosts_) names.push_back(host.substr(0, host.find('@')));
    for (const auto& [id, worker] : workers_)
      names.push_back(worker.info.host.substr(0, worker.info.host.find('@')));
    for (const auto& [subject, why] : distrusted_) names.push_back(short_name(subject));
    return absl::NotFoundError(
        absl::StrCat("no host \"", text, "\" is known", base::did_you_mean(text, names)));
  }
  distrusted_.erase(meant.front());
  record(FarmEvent::Kind::kTrusted, "").host = meant.front();
  for (auto& [id, worker] : workers_) {
    if (covers(meant.front(), worker.info.host)) count(worker);
  }
  return absl::OkStatus();
}

}  // namespace tessera::server
