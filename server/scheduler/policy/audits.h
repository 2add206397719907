// Second opinions: whether the pixels that a host returns are right. Results of one arithmetic class have the
// same bits wherever they are rendered, so two of one unit that differ prove that one of two hosts is at
// fault. Results of two classes say nothing of each other.
#pragma once

#include <functional>
#include <string>

#include "scheduler/farm_state.h"
#include "scheduler/policy/classes.h"
#include "scheduler/policy/eligibility.h"
#include "scheduler/policy/lease_book.h"
#include "scheduler/policy/steps.h"
#include "scheduler/policy/trust.h"

namespace tessera::server {

class Audits {
 public:
  Audits(FarmState& state, const Trust& trust, Classes& classes, const Eligibility& eligibility,
         LeaseBook& book, Steps& steps, Faults& faults)
      : state_(state),
        trust_(trust),
        classes_(classes),
        eligibility_(eligibility),
        book_(book),
        steps_(steps),
        faults_(faults) {}

  /// Asks for a second opinion on an accepted result, if it was chosen for one and somebody can give it.
  void ask(FarmJob& job, const AcceptedResult& accepted);
  /// The same, whether or not it was chosen. False where nobody can give it, or it was asked for before.
  bool ask_again(FarmJob& job, const AcceptedResult& accepted);
  /// The same of this identity, which has reason to doubt the result, whatever was asked before.
  bool ask_who_doubts(FarmJob& job, const AcceptedResult& accepted, const std::string& identity);
  /// An identity by chance, each as likely, of those with a worker that `can`; empty when there is none.
  /// Whoever comes first would be whoever hurries: those who conspire would look at each other's results.
  std::string draw(const FarmJob& job, std::uint32_t unit,
                   const std::function<bool(const FarmWorker&)>& can) const;
  bool can_make(const FarmWorker& worker, const FarmJob& job, const Audit& audit) const;
  /// Gives up those that wait and that nobody can make. Where two disagree on a unit of a phase, all of the
  /// picture would be in doubt: it is set aside.
  void give_up(FarmJob& job);

  /// Somebody could not read what the unit is made of: whoever made it is suspected first. Asks for second
  /// opinions on all results that are in it, and closes the unit's step until they are there. False where
  /// there is nobody, or nothing, to ask any more.
  bool suspect_inputs(FarmJob& job, std::uint32_t unit, const std::string& why);
  /// Opens the steps that waited for opinions, when all of them are there or will not come.
  void release(FarmJob& job);

  /// A result of the units of an accepted one, beside it.
  struct Comparison {
    bool same_class = false;
    bool equal = false;
    bool heard = false;      // it counts as an opinion: the job may be over with it
    bool confirmed = false;  // equal, by another identity, and both are trusted
  };
  /// Takes it as an opinion where one is wanted; who is in the minority goes into quarantine.
  Comparison compare(FarmJob& job, const FarmWorker& worker, const AcceptedResult& accepted,
                     ResultFingerprint result);

  /// Scheduler::trust_host.
  absl::Status trust(const std::string& text);

  /// An audit as it was journaled. Of a result that was revoked since, nothing is to be known any more.
  void restore(FarmJob& job, const FarmEvent& event);
  /// After the last of these. Which audits were waiting is not journaled, but which were asked for, and what
  /// came of it where hosts disagree. They are asked for first of all, so those that were waiting are among
  /// those of the latest results.
  void restored(FarmJob& job);

 private:
  Audit first_opinion(const FarmJob& job, const AcceptedResult& accepted) const;
  std::string drawn_for(const FarmJob& job, std::uint32_t unit, const Audit& audit) const;
  bool wanted(const FarmJob& job, const AcceptedResult& accepted) const;
  bool may_speak(const Audit& audit, const std::string& host) const;
  bool anyone_can_make(const FarmJob& job, const Audit& audit) const;
  std::size_t votes_needed(const FarmJob& job, const Audit& audit) const;
  bool is_asked_for(const FarmJob& job, std::uint32_t unit, bool of_one_identity) const;
  void adjudicate(FarmJob& job, std::uint32_t unit);
  void set_disputed_aside(FarmJob& job, std::uint32_t unit);
  void distrust(const std::string& subject, const std::string& why);
  void revoke_results(FarmJob& job, const std::string& subject);

  FarmState& state_;
  const Trust& trust_;
  Classes& classes_;
  const Eligibility& eligibility_;
  LeaseBook& book_;
  Steps& steps_;
  Faults& faults_;
};

}  // namespace tessera::server
