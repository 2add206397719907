// Failures of one unit, counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "scheduler/scheduler_types.h"

namespace tessera::server {

inline constexpr std::uint32_t kMaxFailures = 3;  // failures on different hosts, or reported by any worker
inline constexpr std::uint32_t kMaxLosses = 6;    // failures of any kind on any number of hosts
inline constexpr std::uint32_t kLossesToIsolate = 2;  // After so many losses a unit is a worker's only one.

std::set<std::string> hosts_of(const std::vector<UnitFailure>& failures);
std::size_t losses_in(const std::vector<UnitFailure>& failures);

/// Whether identities disagree on what the unit makes.
bool is_disputed(const std::vector<UnitFailure>& failures);

/// A worker that says what went wrong is believed; one that died may have been killed by something else, so
/// either different hosts must have seen it, or the same few a number of times.
bool failed_too_often(const std::vector<UnitFailure>& failures);

}  // namespace tessera::server
