// Changes in the scheduler that must outlive the coordinator, besides the jobs and results themselves.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tessera::server {

/// One durable change. The caller journals events in the order in which they come, before it answers the call
/// that caused them, and gives those of a job that has not ended to Scheduler::restore after a restart.
struct FarmEvent {
  /// Journaled as numbers: never renumber.
  enum class Kind : std::int32_t {
    kBound = 1,        // text: the arithmetic class; before protocol 2, the ISA alone
    kEnded = 2,        // value: v1::JobState; text: why
    kReopened = 3,     // an incomplete job goes on, its set-aside units and failures forgotten
    kUnitFailed = 4,   // unit, host, value: the grant (grant_id); text: the worker's message
    kUnitLost = 5,     // unit, host, value: the grant; the worker died, or went silent
    kUnitFound = 6,    // unit, host, value: the grant; it had only been silent
    kRevoked = 7,      // unit, host, value: sequence number of the result that does not count any more
    kPaused = 8,       // value: 1, or 0 for resumed
    kPriority = 9,     // value
    kDistrusted = 10,  // host, or an identity (identity.h); text: why. Of the whole farm: no job
    kTrusted = 11,     // host or identity. Of the whole farm
    kNote = 12,        // text, for people
    kAdopted =
        13,  // value: number of units taken over when the job was new; text: the job that they are from
    // unit, value: sequence number of its result, host: who was asked for a second opinion. text: empty when
    // it was asked; else the opinion, as a number, where hosts disagree.
    kAudit = 14,
    kSceneFault = 18,  // like kUnitFailed; the worker says that the scene is at fault
    kClassNoted =
        17,  // host, value: number of the first result from which on its are of the class; text: the class
    kUnconfirmed = 26,  // value: number of units that rest on identities which no other confirmed, at its end
    kClassConfirmed = 22,  // host: an identity that computes in a class, as another one has shown; text: the
                           // class. Of the whole farm
    // unit: the first of a run, value: how many units it has, host, text: as of one. None of them is to blame
    // alone.
    kRunFailed = 20,
    kRunLost = 21,
    kInputsFailed = 23,  // like kUnitFailed; the worker could not read what the unit is made of
    kDisputed = 24,      // unit, host: one of those who disagree on what it makes; text: who
  };

  Kind kind = Kind::kNote;
  std::string job;  // empty: of the whole farm
  std::uint32_t unit = 0;
  std::int64_t value = 0;
  std::string host;
  std::string text;
  std::vector<std::string> log = {};  // failures only: the worker's log, which is not journaled
};

}  // namespace tessera::server
