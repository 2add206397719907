// Steps of jobs: which units may be given out, and what follows for those that read a result that counts no
// more [docs/decisions/0026-phases.md].
#pragma once

#include <cstdint>
#include <optional>

#include "scheduler/farm_state.h"
#include "scheduler/policy/faults.h"
#include "scheduler/policy/lease_book.h"

namespace tessera::server {

class Steps {
 public:
  Steps(FarmState& state, LeaseBook& book, Faults& faults) : state_(state), book_(book), faults_(faults) {}

  /// Opens the steps whose units have all that they read.
  static void open(FarmJob& job);
  /// LeaseToken.inputs of the unit; none where something that it reads is not there.
  static std::optional<std::uint64_t> inputs_of(const FarmJob& job, std::uint32_t unit);
  /// FailedPrecondition where the lease was of units that read other results than those that count now.
  static absl::Status check_inputs(const FarmJob& job, const v1::LeaseToken& token);

  /// The units of a result that counts are to be done again, and all that was made of it.
  void revoke(FarmJob& job, const AcceptedResult& result);
  /// Everything that counts is to be done again.
  void revoke_all(FarmJob& job);
  /// Nobody may begin with units from `begin` on, the first of a step, until open() finds that they may be;
  /// results that are there stay.
  void close(FarmJob& job, std::uint32_t begin);
  /// After a restart: results of steps that come after one that is not done, as a damaged journal may have
  /// them.
  void revoke_orphans(FarmJob& job);

 private:
  void revoke_alone(FarmJob& job, const AcceptedResult& result);
  void revoke_dependents(FarmJob& job, std::uint32_t source);
  void begin_anew(FarmJob& job, std::uint32_t unit);

  FarmState& state_;
  LeaseBook& book_;
  Faults& faults_;
};

}  // namespace tessera::server
