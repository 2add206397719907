#include "scheduler/policy/checks.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

constexpr int kTries = 4;  // of results that may have been audited before
constexpr Time kLeastPatience{60'000}, kMostPatience{600'000};

/// A number that nobody can tell who does not have the key.
std::uint64_t secret_number(const SchedulerOptions& options, const FarmJob& job, std::uint64_t of) {
  const std::string digest =
      wire::sha256_hex(absl::StrCat(options.audit_key, " check ", job.request.id, " ", of));
  return std::stoull(digest.substr(0, 13), nullptr, 16);  // 52 bits
}

constexpr double kNumbers = static_cast<double>(std::uint64_t{1} << 52);

}  // namespace

bool Checks::is_proven(const std::string& host) const { return identity_of(host) != host; }

std::string Checks::maker_of(const AcceptedResult& accepted) const {
  return accepted.host < state_.hosts_by_number.size() ? identity_of(state_.hosts_by_number[accepted.host])
                                                       : "";
}

double Checks::allowance(const FarmJob& job) const {
  return std::max(1.0, state_.options.unconfirmed_share * job.units.count());
}

bool Checks::is_chosen(const FarmJob& job, const Standing::Result& result) const {
  if (result.spot.number == 0) return false;
  const auto drawn = static_cast<double>(secret_number(state_.options, job, result.sequence)) / kNumbers;
  return drawn * result.spot.share < state_.options.spot_work;
}

void Checks::note(FarmJob& job, const AcceptedResult& accepted, const Spot& spot, bool doubtful, Time now) {
  if (state_.options.audit_one_in == 0 || !is_proven(state_.hosts_by_number[accepted.host]) ||
      !job.request.plan->is_of_picture(accepted.units.first)) {
    return;
  }
  const std::string identity = maker_of(accepted);
  Standing& standing = job.standing_by_identity[identity];
  const Standing::Result result{.first = accepted.units.first,
                                .units = accepted.units.count,
                                .sequence = accepted.sequence,
                                .spot = spot};
  standing.add(result);
  if (doubtful || is_chosen(job, result)) {
    ask(job, identity, result, now);
  } else if (static_cast<double>(standing.unconfirmed()) >= standing.ask_from && !is_asked(job, standing) &&
             (standing.confirmations() == 0 ||
              static_cast<double>(standing.unconfirmed()) > allowance(job))) {
    // The very first is known to be looked at; which of the later ones is not.
    const bool asked = standing.open().size() == 1 ? ask(job, identity, result, now)
                                                   : ask_for_any(job, identity, standing, now);
    if (!asked) standing.ask_from = static_cast<double>(standing.unconfirmed()) + allowance(job);
  }
}

bool Checks::is_asked(const FarmJob& job, const Standing& standing) const {
  return standing.asked &&
         (job.spots.find(*standing.asked) != nullptr || job.audits.find(*standing.asked) != nullptr);
}

bool Checks::is_able(const FarmWorker& worker, const FarmJob& job, const SpotCheck& check) const {
  const std::string identity = identity_of(worker.info.host);
  if (identity == check.maker || !is_proven(worker.info.host) || check.silent.contains(identity))
    return false;
  const std::string* const own = classes_.class_for(worker, job);
  if (own == nullptr || *own != check.arithmetic_class) return false;
  const auto standing = job.standing_by_identity.find(identity);
  return (standing == job.standing_by_identity.end() || standing->second.false_alarms < kMostFalseAlarms) &&
         eligibility_.may_work_on(worker, job, worker.last_seen);
}

bool Checks::can_make(const FarmWorker& worker, const FarmJob& job, const SpotCheck& check) const {
  return identity_of(worker.info.host) == check.checker && is_able(worker, job, check);
}

/// The identity that is to make the check; empty when nobody can.
std::string Checks::draw(const FarmJob& job, std::uint32_t unit, const SpotCheck& check) const {
  if (state_.workers_by_identity.size() < 2) return "";
  return audits_.draw(job, unit, [&](const FarmWorker& worker) { return is_able(worker, job, check); });
}

/// Asks for a check of one of an identity's results. Whether somebody can make it.
bool Checks::ask(FarmJob& job, const std::string& identity, const Standing::Result& result, Time now) {
  const AcceptedResult& accepted = job.units.result(result.first);
  Standing& standing = job.standing_by_identity[identity];
  const auto covers = [&] { return standing.open().empty() ? 0 : standing.open().back().sequence; };
  if (result.spot.number != 0 && job.spots.find(result.first) == nullptr) {
    SpotCheck check{.spot = result.spot,
                    .maker = identity,
                    .checker = "",
                    .arithmetic_class = classes_.class_of_result(job, accepted),
                    .covers = covers(),
                    .silent = {},
                    .since = now};
    check.checker = draw(job, result.first, check);
    if (job.spots.size() >= kMostSpotsPerJob || check.checker.empty()) return false;
    job.spots.put(result.first, std::move(check));
    state_.checking.insert(job.number);
  } else if (!audits_.ask_again(job, accepted)) {
    return false;
  }
  standing.asked = result.first;
  standing.asked_at = now;
  standing.covers = covers();
  return true;
}

bool Checks::ask_for_any(FarmJob& job, const std::string& identity, const Standing& standing, Time now) {
  for (int i = 0; i < kTries && !standing.open().empty(); ++i) {
    const std::uint64_t drawn = secret_number(
        state_.options, job,
        std::uint64_t{standing.open().back().sequence} << 32 | (standing.unanswered_checks * kTries + i));
    const Standing::Result result = standing.open()[drawn % standing.open().size()];
    if (ask(job, identity, result, now)) return true;
  }
  return false;
}

bool Checks::compare(FarmJob& job, const FarmWorker& worker, std::uint32_t unit, ResultFingerprint result) {
  const SpotCheck check = *job.spots.find(unit);
  job.spots.erase(unit);
  if (job.spots.empty()) state_.checking.erase(job.number);
  const AcceptedResult& accepted = job.units.result(unit);
  const std::string identity = identity_of(worker.info.host);
  if (check.spot.fingerprint == result) {
    job.standing_by_identity[check.maker].confirm(check.covers);
    classes_.confirm(check.arithmetic_class, check.maker, identity);
    return true;
  }
  // Who is right is found by the whole result.
  job.alarms[unit] = identity;
  audits_.ask_who_doubts(job, accepted, identity);
  return false;
}

void Checks::confirm(FarmJob& job, const AcceptedResult& accepted, const std::string& host) {
  if (const auto alarm = job.alarms.find(accepted.units.first); alarm != job.alarms.end()) {
    // Others may be of one mind with whoever made it.
    if (alarm->second != identity_of(host) && audits_.ask_who_doubts(job, accepted, alarm->second)) return;
    ++job.standing_by_identity[alarm->second].false_alarms;
    job.alarms.erase(alarm);
  }
  const auto standing = job.standing_by_identity.find(maker_of(accepted));
  if (standing == job.standing_by_identity.end()) return;
  const bool asked = standing->second.asked == accepted.units.first;
  standing->second.confirm(std::max(accepted.sequence, asked ? standing->second.covers : 0));
}

bool Checks::withholds(const FarmWorker& worker, const FarmJob& job) const {
  if (job.standing_by_identity.empty()) return false;
  const std::string identity = identity_of(worker.info.host);
  const auto found = job.standing_by_identity.find(identity);
  if (found == job.standing_by_identity.end()) return false;
  const Standing& standing = found->second;
  if (standing.confirmations() > 0 || static_cast<double>(standing.unconfirmed()) < allowance(job))
    return false;
  const std::string* const own = classes_.class_for(worker, job);
  return own != nullptr && !state_.class_tally.is_confirmed(*own, identity) && is_asked(job, standing);
}

void Checks::review(FarmJob& job, Time now) {
  const Time patience = std::clamp(8 * job.mean_lease_duration, kLeastPatience, kMostPatience);
  std::vector<std::uint32_t> waiting, stalled;
  for (const auto& [unit, check] : job.spots.all()) {
    if (job.spots.waits(unit)) {
      waiting.push_back(unit);
    } else if (now - check.since >= patience) {
      stalled.push_back(unit);
    }
  }
  for (const std::uint32_t unit : stalled) {
    for (const LeaseId lease : state_.leases.of_unit(job.number, unit)) {
      if (state_.leases.get(lease).spot != 0) book_.drop(lease);
    }
    waiting.push_back(unit);
  }
  for (const std::uint32_t unit : waiting) {
    const SpotCheck* const check = job.spots.find(unit);
    if (now - check->since >= patience) job.spots.give_back(unit, check->checker);
    const auto asked = state_.workers_by_identity.find(check->checker);
    const bool able = asked != state_.workers_by_identity.end() &&
                      std::any_of(asked->second.begin(), asked->second.end(), [&](const std::string& worker) {
                        return can_make(state_.workers.at(worker), job, *check);
                      });
    if (able) continue;
    if (std::string other = draw(job, unit, *check); !other.empty()) {
      job.spots.ask(unit, std::move(other), now);
      continue;
    }
    ++job.standing_by_identity[check->maker].unanswered_checks;
    job.spots.erase(unit);
  }
  for (auto& [identity, standing] : job.standing_by_identity) {
    // The same of whole results that are asked for in place of spots.
    if (standing.asked && job.audits.waits(*standing.asked) && now - standing.asked_at >= patience) {
      job.audits.erase(*standing.asked);
      ++standing.unanswered_checks;
    }
    if (static_cast<double>(standing.unconfirmed()) <= allowance(job) || is_asked(job, standing)) continue;
    if (standing.unanswered_checks < kMostUnansweredChecks && !ask_for_any(job, identity, standing, now)) {
      ++standing.unanswered_checks;
    }
  }
  if (job.spots.empty()) state_.checking.erase(job.number);
}

std::uint32_t Checks::unconfirmed_units(const FarmJob& job) const {
  std::uint64_t units = 0;
  for (const auto& [identity, standing] : job.standing_by_identity) {
    if (static_cast<double>(standing.unconfirmed()) > allowance(job)) units += standing.unconfirmed();
  }
  return static_cast<std::uint32_t>(units);
}

void Checks::restored(FarmJob& job) {
  if (state_.options.audit_one_in == 0 || !job.open()) return;
  for (const AcceptedResult& accepted : job.units.results()) {
    if (accepted.host >= state_.hosts_by_number.size() || !is_proven(state_.hosts_by_number[accepted.host]) ||
        !job.request.plan->is_of_picture(accepted.units.first)) {
      continue;
    }
    job.standing_by_identity[maker_of(accepted)].add({.first = accepted.units.first,
                                                      .units = accepted.units.count,
                                                      .sequence = accepted.sequence,
                                                      .spot = {}});
  }
}

}  // namespace tessera::server
