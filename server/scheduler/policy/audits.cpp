#include "scheduler/policy/audits.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "base/nearest_name.h"
#include "scheduler/identity.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

// Audits of one job that may wait at a time.
constexpr std::size_t kMaxAudits = 256;

// Identities among which one is drawn, in order from a random one.
constexpr std::size_t kMostDrawn = 512;

// Votes that decide in any case, for they are asked one after the other. Up to 13 identities, that is the
// majority of all.
constexpr std::size_t kMostVotes = 7;

// Audits of one job that are made, or made again, after a restart.
constexpr std::size_t kRestoredAudits = 32;

// The same of units of phases. More parts than that are small, and what one of them can spoil, too.
constexpr std::size_t kMaxPhaseAudits = 65'536;

/// The same choice after a restart, and for every order of results; who does not have the key cannot tell it.
bool chosen(const SchedulerOptions& options, const std::string& job, std::uint32_t unit,
            std::uint32_t one_in) {
  if (options.audit_one_in == 0 || one_in == 0) return false;
  const std::string digest = wire::sha256_hex(absl::StrCat(options.audit_key, " ", job, " ", unit));
  return std::stoull(digest.substr(0, 15), nullptr, 16) % one_in == 0;
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

/// Returns what all identities say, or more than half of them and at least `needed`; none when there is no
/// such thing.
std::optional<Verdict> verdict_of(const Opinions& opinions, std::size_t needed) {
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
  if (votes.size() > 1 && winner->second < needed) return std::nullopt;
  verdict.result = winner->first;
  verdict.votes = winner->second;
  return verdict;
}

}  // namespace

void Audits::ask(FarmJob& job, const AcceptedResult& accepted) {
  if (!wanted(job, accepted)) return;
  Audit audit = first_opinion(job, accepted);
  audit.asked_of = drawn_for(job, accepted.units.first, audit);
  job.audits.put(accepted.units.first, std::move(audit));
  state_.auditing.insert(job.number);
}

std::string Audits::draw(const FarmJob& job, std::uint32_t unit,
                         const std::function<bool(const FarmWorker&)>& can) const {
  const auto& identities = state_.workers_by_identity;
  if (identities.empty()) return "";
  const std::string digest = wire::sha256_hex(
      absl::StrCat(state_.options.audit_key, " draw ", job.request.id, " ", unit, " ", job.attempts));
  const auto first =
      static_cast<std::ptrdiff_t>(std::stoull(digest.substr(0, 15), nullptr, 16) % identities.size());
  auto identity = std::next(identities.begin(), first);
  for (std::size_t tries = 0; tries < std::min(identities.size(), kMostDrawn); ++tries) {
    const bool able = std::any_of(identity->second.begin(), identity->second.end(),
                                  [&](const std::string& worker) { return can(state_.workers.at(worker)); });
    if (able) return identity->first;
    if (++identity == identities.end()) identity = identities.begin();
  }
  return "";
}

/// Whose opinion is asked for, where identities are proven; names are for everybody to choose.
std::string Audits::drawn_for(const FarmJob& job, std::uint32_t unit, const Audit& audit) const {
  const std::string& maker = audit.opinions.front().first;
  if (identity_of(maker) == maker) return "";
  return draw(job, unit, [&](const FarmWorker& worker) { return can_make(worker, job, audit); });
}

bool Audits::ask_again(FarmJob& job, const AcceptedResult& accepted) {
  const std::uint32_t unit = accepted.units.first;
  if (job.audits.find(unit) != nullptr) return true;
  Audit audit = first_opinion(job, accepted);
  if (job.audited.contains(unit) || job.audits.size() >= kMaxAudits || !anyone_can_make(job, audit))
    return false;
  audit.asked_of = drawn_for(job, unit, audit);
  job.audits.put(unit, std::move(audit));
  state_.auditing.insert(job.number);
  return true;
}

bool Audits::ask_who_doubts(FarmJob& job, const AcceptedResult& accepted, const std::string& identity) {
  const std::uint32_t unit = accepted.units.first;
  // Somebody is at it; that comes to an end first (Checks::confirm).
  if (job.audits.find(unit) != nullptr && !job.audits.waits(unit)) return true;
  Audit audit = first_opinion(job, accepted);
  if (job.audits.find(unit) != nullptr) audit = *job.audits.find(unit);
  audit.asked_of = identity;
  if (!anyone_can_make(job, audit)) return false;
  job.audits.put(unit, std::move(audit));
  state_.auditing.insert(job.number);
  return true;
}

/// The opinion of whoever rendered the accepted result.
Audit Audits::first_opinion(const FarmJob& job, const AcceptedResult& accepted) const {
  return {.opinions = {{state_.hosts_by_number[accepted.host], accepted.fingerprint}},
          .arithmetic_class = classes_.class_of_result(job, accepted)};
}

bool Audits::wanted(const FarmJob& job, const AcceptedResult& accepted) const {
  const std::size_t most =
      job.request.plan->is_of_picture(accepted.units.first) ? kMaxAudits : kMaxPhaseAudits;
  return is_asked_for(job, accepted.units.first, trust_.is_of_one_identity()) && job.audits.size() < most &&
         anyone_can_make(job, first_opinion(job, accepted));
}

/// Whether chance asks for a second opinion on the result of the unit. All of a picture is made of what its
/// phases make, so these are asked for more often; hosts of one identity have no reason to distrust each
/// other that much.
bool Audits::is_asked_for(const FarmJob& job, std::uint32_t unit, bool of_one_identity) const {
  const bool often = !job.request.plan->is_of_picture(unit) && !of_one_identity;
  return chosen(state_.options, job.request.id, unit,
                often ? state_.options.audit_phases_one_in : state_.options.audit_one_in);
}

/// Whether the opinion of this host would be a new one: of an identity that has not spoken, for it has one
/// vote only. Where the whole farm is one identity, its hosts watch over each other: that finds machines that
/// are broken.
bool Audits::may_speak(const Audit& audit, const std::string& host) const {
  const bool by_host = trust_.is_of_one_identity() && is_of_one(audit.opinions);
  return std::none_of(audit.opinions.begin(), audit.opinions.end(), [&](const auto& opinion) {
    return opinion.first == host || (!by_host && identity_of(opinion.first) == identity_of(host));
  });
}

bool Audits::can_make(const FarmWorker& worker, const FarmJob& job, const Audit& audit) const {
  const std::string* const own = classes_.class_for(worker, job);
  const bool is_asked =
      audit.asked_of.empty() || audit.opinions.size() > 1 || identity_of(worker.info.host) == audit.asked_of;
  return is_asked && !audit.is_over() && own != nullptr && *own == audit.arithmetic_class &&
         eligibility_.may_work_on(worker, job, worker.last_seen) && may_speak(audit, worker.info.host);
}

bool Audits::anyone_can_make(const FarmJob& job, const Audit& audit) const {
  return std::any_of(state_.workers.begin(), state_.workers.end(),
                     [&](const auto& entry) { return can_make(entry.second, job, audit); });
}

void Audits::give_up(FarmJob& job) {
  // Where fewer are left to ask, fewer decide.
  const std::set<std::uint32_t> waiting = job.audits.waiting();
  for (const std::uint32_t unit : waiting) {
    const Audit* const audit = job.audits.find(unit);
    if (!job.open() || audit == nullptr) continue;
    if (audit->opinions.size() > 2) {
      adjudicate(job, unit);
    } else if (!audit->asked_of.empty() && !anyone_can_make(job, *audit)) {
      Audit other = *audit;
      other.asked_of.clear();
      other.asked_of = drawn_for(job, unit, other);
      job.audits.put(unit, std::move(other));
    }
  }
  std::vector<std::uint32_t> disputed;
  job.audits.erase_if([&](std::uint32_t unit, const Audit& audit) {
    if (!job.audits.waits(unit) || anyone_can_make(job, audit)) return false;
    if (audit.opinions.size() > 1 && !job.request.plan->is_of_picture(unit)) {
      disputed.push_back(unit);
      return false;
    }
    if (audit.opinions.size() > 1) {
      state_.note(job, absl::StrCat("unit ", unit, ": ", short_name(audit.opinions[0].first), " and ",
                                    short_name(audit.opinions[1].first),
                                    " disagree, and there is no third host to decide"));
    }
    return true;
  });
  for (const std::uint32_t unit : disputed) {
    // Another one of them may have taken it along.
    if (job.audits.find(unit) != nullptr) set_disputed_aside(job, unit);
  }
}

Audits::Comparison Audits::compare(FarmJob& job, const FarmWorker& worker, const AcceptedResult& accepted,
                                   ResultFingerprint result) {
  const std::uint32_t unit = accepted.units.first;
  const std::string* const own = classes_.class_for(worker, job);
  if (own == nullptr || *own != classes_.class_of_result(job, accepted)) return {};
  const bool equal = accepted.fingerprint == result;
  const std::string& maker = accepted.host < state_.hosts_by_number.size()
                                 ? state_.hosts_by_number[accepted.host]
                                 : worker.info.host;
  const bool confirmed = equal && identity_of(maker) != identity_of(worker.info.host) &&
                         trust_.trusts(maker) && trust_.trusts(worker.info.host);
  if (confirmed) classes_.confirm(*own, identity_of(maker), identity_of(worker.info.host));
  const bool asked = job.audits.find(unit) != nullptr;
  const bool may_count = job.open() && worker.info.host != maker && trust_.trusts(worker.info.host);
  // A copy that agrees is no news where nobody asked.
  const bool heard = may_count && (asked || !equal);
  if (heard) {
    if (!asked) job.audits.put(unit, first_opinion(job, accepted));
    const Audit& audit = *job.audits.find(unit);
    if (may_speak(audit, worker.info.host)) {
      job.audits.add_opinion(unit, worker.info.host, result);
      if (!equal || audit.opinions.size() > 2) {
        FarmEvent& event = state_.record(FarmEvent::Kind::kAudit, job.request.id);
        event.unit = unit;
        event.value = accepted.sequence;
        event.host = worker.info.host;
        event.text = absl::StrCat(result);
      }
    }
    state_.auditing.insert(job.number);
    adjudicate(job, unit);
  }
  return {.same_class = true, .equal = equal, .heard = heard, .confirmed = confirmed};
}

/// Votes that decide where opinions differ: the majority of all who have spoken or could, so that a few who
/// happen to be asked first, and conspire, decide nothing.
std::size_t Audits::votes_needed(const FarmJob& job, const Audit& audit) const {
  const bool by_host = is_of_one(audit.opinions);
  const auto voter = [by_host](const std::string& host) { return by_host ? host : identity_of(host); };
  std::set<std::string> voters;
  for (const auto& [host, result] : audit.opinions) voters.insert(voter(host));
  for (const auto& [id, worker] : state_.workers) {
    if (voters.size() >= 2 * kMostVotes) break;
    if (can_make(worker, job, audit)) voters.insert(voter(worker.info.host));
  }
  return std::min(kMostVotes, voters.size() / 2 + 1);
}

/// Decides by majority of identities, or of hosts where all are of one identity; without a majority, the
/// audit goes on.
void Audits::adjudicate(FarmJob& job, std::uint32_t unit) {
  const Audit& audit = *job.audits.find(unit);
  const auto differs = [&](const auto& opinion) { return opinion.second != audit.opinions.front().second; };
  const bool disputed = std::any_of(audit.opinions.begin(), audit.opinions.end(), differs);
  const std::optional<Verdict> verdict = verdict_of(audit.opinions, disputed ? votes_needed(job, audit) : 0);
  if (!verdict) {
    // Until somebody comes who can decide, everything that is made of the blob would be in doubt.
    if (audit.opinions.size() > 1 && !job.request.plan->is_of_picture(unit) && !anyone_can_make(job, audit))
      set_disputed_aside(job, unit);
    return;
  }
  if (verdict->result == job.units.result(unit).fingerprint) job.confirmed.insert(unit);
  job.audits.erase(unit);
  if (job.audits.empty()) state_.auditing.erase(job.number);
  for (const LeaseId lease : state_.leases.of_unit(job.number, unit)) book_.drop(lease);
  for (const auto& [voter, result] : verdict->voters) {
    if (result == verdict->result) continue;
    const std::string why = absl::StrCat("its result of unit ", unit, " of job ", job.request.id,
                                         " differs from that of ", verdict->votes, " other hosts");
    state_.note(job, absl::StrCat("host ", short_name(voter), " is in quarantine: ", why));
    distrust(voter, why);
  }
}

/// `subject`: a host, or an identity and so all of its hosts.
void Audits::distrust(const std::string& subject, const std::string& why) {
  if (!state_.distrusted.emplace(subject, why).second) return;
  FarmEvent& event = state_.record(FarmEvent::Kind::kDistrusted, "");
  event.host = subject;
  event.text = why;
  std::vector<std::string> its_workers;
  for (auto& [id, worker] : state_.workers) {
    if (!covers(subject, worker.info.host)) continue;
    its_workers.push_back(id);
    classes_.count(worker);
  }
  std::sort(its_workers.begin(), its_workers.end());  // the same order in every run
  for (const std::string& worker : its_workers) {
    for (const LeaseId lease : state_.leases.of_worker(worker)) book_.drop(lease);
  }
  for (const auto& [number, job] : state_.jobs_by_number) {
    if (job->open()) revoke_results(*job, subject);
  }
}

/// Everything that the host, or the hosts of the identity, did for an open job is done again.
void Audits::revoke_results(FarmJob& job, const std::string& subject) {
  std::vector<AcceptedResult> results = job.units.results();
  std::erase_if(results, [&](const AcceptedResult& result) {
    return result.host >= state_.hosts_by_number.size() ||
           !covers(subject, state_.hosts_by_number[result.host]);
  });
  job.audits.drop_opinions([&](const std::string& host) { return covers(subject, host); });
  job.audits.erase_if([](std::uint32_t, const Audit& audit) { return audit.opinions.empty(); });
  std::erase_if(job.hosts_with_results, [&](HostNumber host) {
    return host < state_.hosts_by_number.size() && covers(subject, state_.hosts_by_number[host]);
  });
  std::uint32_t units = 0;
  for (const AcceptedResult& result : results) {
    units += result.units.count;
    // It may have been made of another one of them.
    if (job.units.state(result.units.first) == UnitState::kDone &&
        job.units.result(result.units.first).sequence == result.sequence) {
      steps_.revoke(job, result);
    }
  }
  if (job.audits.empty()) state_.auditing.erase(job.number);
  if (results.empty()) return;
  state_.note(job, absl::StrCat(units, " units of host ", short_name(subject), " are done again"));
}

absl::Status Audits::trust(const std::string& text) {
  std::set<std::string> known;  // hosts that are meant
  for (const std::string& host : state_.hosts_by_number) {
    if (is_meant(text, host)) known.insert(host);
  }
  for (const auto& [id, worker] : state_.workers) {
    if (is_meant(text, worker.info.host)) known.insert(worker.info.host);
  }
  // An identity in quarantine is also meant by the names of its hosts.
  std::vector<std::string> meant;
  for (const auto& distrusted : state_.distrusted) {
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
    for (const std::string& host : state_.hosts_by_number) names.push_back(host.substr(0, host.find('@')));
    for (const auto& [id, worker] : state_.workers)
      names.push_back(worker.info.host.substr(0, worker.info.host.find('@')));
    for (const auto& [subject, why] : state_.distrusted) names.push_back(short_name(subject));
    return absl::NotFoundError(
        absl::StrCat("no host \"", text, "\" is known", base::did_you_mean(text, names)));
  }
  state_.distrusted.erase(meant.front());
  state_.record(FarmEvent::Kind::kTrusted, "").host = meant.front();
  for (auto& [id, worker] : state_.workers) {
    if (covers(meant.front(), worker.info.host)) classes_.count(worker);
  }
  return absl::OkStatus();
}

void Audits::restore(FarmJob& job, const FarmEvent& event) {
  if (job.units.state(event.unit) != UnitState::kDone) return;
  const AcceptedResult& accepted = job.units.result(event.unit);
  const bool same = accepted.units.first == event.unit && accepted.sequence == event.value;
  if (!same || accepted.host >= state_.hosts_by_number.size()) return;
  job.audited.insert(event.unit);
  ResultFingerprint opinion = 0;
  if (!absl::SimpleAtoi(event.text, &opinion)) return;
  if (job.audits.find(event.unit) == nullptr) job.audits.put(event.unit, first_opinion(job, accepted));
  job.audits.add_opinion(event.unit, event.host, opinion);
}

void Audits::restored(FarmJob& job) {
  if (!job.open()) return;
  job.audits.drop_opinions([&](const std::string& host) { return !trust_.trusts(host); });
  job.audits.erase_if([](std::uint32_t, const Audit& audit) {
    return audit.opinions.size() < 2 || verdict_of(audit.opinions, kMostVotes);
  });
  std::vector<AcceptedResult> latest = job.units.results();
  // No worker is here yet.
  std::set<std::string> identities;
  for (const HostNumber host : job.hosts_with_results) {
    if (host < state_.hosts_by_number.size()) identities.insert(identity_of(state_.hosts_by_number[host]));
  }
  std::erase_if(latest, [&](const AcceptedResult& result) {
    return job.audited.contains(result.units.first) ||
           !is_asked_for(job, result.units.first, identities.size() < 2);
  });
  const auto of_picture = std::stable_partition(latest.begin(), latest.end(), [&](const auto& result) {
    return !job.request.plan->is_of_picture(result.units.first);
  });
  const auto phases = static_cast<std::size_t>(of_picture - latest.begin());
  if (latest.size() - phases > kRestoredAudits) latest.erase(of_picture, latest.end() - kRestoredAudits);
  for (const AcceptedResult& accepted : latest) {
    if (accepted.host >= state_.hosts_by_number.size() ||
        !trust_.trusts(state_.hosts_by_number[accepted.host]))
      continue;
    job.audits.put(accepted.units.first, first_opinion(job, accepted));
  }
  if (!job.audits.empty()) state_.auditing.insert(job.number);
}

}  // namespace tessera::server
