// Results against those of an earlier run, which a file of --json has.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "bench/analysis.h"
#include "bench/machine.h"
#include "bench/measure.h"

namespace tessera::client {

/// How many times as efficient a scene's rendering is as it was: efficiency is 1 / (relMSE without the worst
/// 0.1 % x CPU seconds), compared by seed.
struct BenchChange {
  std::string name;  // name of the scene, and of the variant where it has one
  Interval ratio;
  /// The same, with CPU seconds in units of what the same run took to trace the rays alone: other machines
  /// and other work slow both.
  Interval by_rays;
};

struct BenchChanges {
  std::string earlier_version, earlier_machine;
  /// Both runs were on processors of one model without other work: `ratio` counts, else `by_rays`.
  bool same_machine = false;
  std::vector<BenchChange> changes;
  std::vector<std::string> missing;  // scenes that the earlier run does not have with these settings
};

/// The text of a file of --json. NotFound when it cannot be read, InvalidArgument beyond 64 MiB.
absl::StatusOr<std::string> read_results(const std::string& path);

/// `json`: the text of the file. InvalidArgument when it is none of a bench.
absl::StatusOr<BenchChanges> changes_since(const std::string& json,
                                           const std::vector<BenchSceneResult>& scenes,
                                           const Machine& machine);

/// A change of less than 3 % is none.
inline constexpr double kNotableChange = 0.03;

/// A line for each scene, with the word REGRESSION where it is slower beyond doubt.
std::string to_text(const BenchChanges& changes);

}  // namespace tessera::client
