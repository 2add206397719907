// Whole processes against each other: from the command to the file.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "bench/analysis.h"
#include "bench/measure.h"
#include "bench/process.h"

namespace tessera::client {

/// A program that renders the scene.
struct WholeSide {
  std::string name;
  /// The command that writes the EXR `output`.
  std::function<absl::StatusOr<std::vector<std::string>>(std::uint32_t spp, std::uint64_t seed,
                                                         const std::string& output)>
      command;
  const BenchReference* reference = nullptr;  // its own, of the same size as its pictures
};

/// Renders with every sample count and seed, the sides taking turns (A B, B A, ...). One result a side.
absl::StatusOr<std::vector<WholeResult>> measure_whole(
    std::span<const WholeSide> sides, const BenchPlan& plan,
    const std::function<void(const std::string&)>& progress, std::stop_token stop);

/// A picture of `side` with `spp` samples a pixel and a seed that no measured one has.
absl::StatusOr<BenchReference> make_reference(const WholeSide& side, std::uint32_t spp, std::stop_token stop);

/// How many times as efficient the first is as the second, seed by seed, for one sample count.
Interval whole_ratio(const WholeResult& a, const WholeResult& b, std::uint32_t spp,
                     double (WholeRun::*efficiency)() const = &WholeRun::efficiency);

/// A table of all sides, and how the first compares with the others.
std::string to_text(const std::vector<WholeResult>& results);

}  // namespace tessera::client
