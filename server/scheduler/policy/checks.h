// Checks by identity: how much of a job's picture may rest on an identity (identity.h) that no other has
// confirmed. Audits are chosen by chance, whoever made a result; these see to it that nobody's first results,
// nor a share of the picture, go unseen [docs/decisions/0009-scheduling.md].
#pragma once

#include <string>

#include "scheduler/farm_state.h"
#include "scheduler/policy/audits.h"
#include "scheduler/policy/classes.h"
#include "scheduler/policy/eligibility.h"
#include "scheduler/policy/lease_book.h"

namespace tessera::server {

/// Where results have spots (spot.h), these are checked: a sixteenth or less of the work, by which whoever
/// returns a wrong tile is found. A spot that differs is no verdict: the whole result is audited then.
/// Everything here is about identities that are proven by certificates; names are not worth counting.
class Checks {
 public:
  // Whoever was asked so often in vain is asked no more, and their part of the picture is marked.
  static constexpr std::uint32_t kMostUnansweredChecks = 4;
  // An identity whose spots differ so often from results that turn out to be right is not asked any more.
  static constexpr std::uint32_t kMostFalseAlarms = 4;
  static constexpr std::size_t kMostSpotsPerJob = 256;  // waiting and under way

  Checks(FarmState& state, Classes& classes, const Eligibility& eligibility, LeaseBook& book, Audits& audits)
      : state_(state), classes_(classes), eligibility_(eligibility), book_(book), audits_(audits) {}

  /// A result was accepted, `doubtful` where it came too fast.
  void note(FarmJob& job, const AcceptedResult& accepted, const Spot& spot, bool doubtful, Time now);
  bool can_make(const FarmWorker& worker, const FarmJob& job, const SpotCheck& check) const;
  /// The spot of an accepted result, as this worker has it. Whether it is the same.
  bool compare(FarmJob& job, const FarmWorker& worker, std::uint32_t unit, ResultFingerprint result);
  /// Another identity's host has the same result.
  void confirm(FarmJob& job, const AcceptedResult& accepted, const std::string& host);
  /// Whether the worker gets nothing more of the job until somebody has looked at what it returned.
  bool withholds(const FarmWorker& worker, const FarmJob& job) const;
  /// Gives up what waits and nobody can make, and what somebody has for too long, and asks in its place.
  void review(FarmJob& job, Time now);
  /// Units of the picture that rest on identities beyond what they may hold unconfirmed.
  std::uint32_t unconfirmed_units(const FarmJob& job) const;
  /// After a restart. Spots are not journaled: all results of a job that goes on are unconfirmed, and may be
  /// audited as a whole.
  void restored(FarmJob& job);

 private:
  bool is_proven(const std::string& host) const;
  std::string maker_of(const AcceptedResult& accepted) const;
  double allowance(const FarmJob& job) const;
  bool is_asked(const FarmJob& job, const Standing& standing) const;
  bool is_able(const FarmWorker& worker, const FarmJob& job, const SpotCheck& check) const;
  std::string draw(const FarmJob& job, std::uint32_t unit, const SpotCheck& check) const;
  bool is_chosen(const FarmJob& job, const Standing::Result& result) const;
  bool ask(FarmJob& job, const std::string& identity, const Standing::Result& result, Time now);
  bool ask_for_any(FarmJob& job, const std::string& identity, const Standing& standing, Time now);

  FarmState& state_;
  Classes& classes_;
  const Eligibility& eligibility_;
  LeaseBook& book_;
  Audits& audits_;
};

}  // namespace tessera::server
