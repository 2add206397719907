// The units of a job that come before its picture: parts of its phases, and what merges them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "scheduler/unit_ledger.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

/// Tells the results that a unit reads from others of the same units: LeaseToken.inputs. The order counts.
std::uint64_t inputs_key(const std::vector<ResultFingerprint>& inputs);

/// Unit indices ascend from phase to phase, and within one from its parts over the levels of the tree that
/// merges them to its root. The units of one level need nothing of each other: they are a step. What comes
/// next is a step too, so indices from unit_count() on, the picture's, are the last one.
class PhasePlan {
 public:
  PhasePlan() = default;

  /// InvalidArgument for phases that are unsound or exceed the caps of wire/limits.h.
  static absl::StatusOr<PhasePlan> make(const v1::JobSpec& spec);

  std::uint32_t unit_count() const { return unit_count_; }

  /// Same spec and index, same unit. `index` must be below unit_count().
  v1::WorkUnit unit(std::uint32_t index) const;

  /// End of the step that begins at this index, which must be below unit_count().
  std::uint32_t step_end(std::uint32_t first) const;

  /// First index of the step that the unit is in: all that it needs comes before.
  std::uint32_t step_begin(std::uint32_t unit) const;

  /// Units whose blobs the unit reads, in the order in which it reads them.
  std::vector<std::uint32_t> inputs(std::uint32_t unit) const;

  /// Units of phases whose results are in what the unit reads, ascending.
  std::vector<std::uint32_t> sources(std::uint32_t unit) const;

  /// The unit that merges the blob of this one with others; none where that is a phase's own.
  std::optional<std::uint32_t> reader(std::uint32_t unit) const;

  /// Index of the phase that the unit is in; none for the picture's.
  std::optional<std::uint32_t> phase_of(std::uint32_t unit) const;

  /// End of the phase that the unit is in: everything from there on reads what the phase makes.
  std::uint32_t phase_end(std::uint32_t unit) const;

  /// Units that make the blob of a phase, which later phases and the picture read.
  const std::vector<std::uint32_t>& roots() const { return roots_; }

 private:
  struct Step {
    std::uint32_t first = 0, count = 0;
    std::uint32_t phase = 0, level = 0;  // level of the merge tree; level 0 makes parts
    std::uint32_t merge_width = 0;
    std::uint32_t end() const { return first + count; }
  };
  /// That the unit is in; null for the picture's.
  const Step* step_of(std::uint32_t unit) const;

  std::vector<Step> steps_;
  std::vector<std::uint32_t> roots_;
  std::uint32_t unit_count_ = 0;
};

}  // namespace tessera::server
