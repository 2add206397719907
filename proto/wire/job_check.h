// Checks of jobs, alike in all three programs, and what follows from a job's algorithm.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "tessera/v1/job.pb.h"
#include "wire/phases/phase_blob.h"

namespace tessera::wire {

/// The check at the door of every program; what is behind it takes a job's settings as they are.
/// InvalidArgument, by name, where the job has a setting that this version does not know, an algorithm that
/// does not exist or cannot do what the job asks for, layers that are none (layers/automaton.h), or noise
/// that is out of range or does not go with the number of samples, the tile size or the samples of a unit;
/// sample_bits that do not go with the sampler; settings of another algorithm; or one that is out of its
/// bounds (settings.h).
absl::Status check_settings(const v1::JobSpec& spec);

/// The word for the bias of pictures that are made so; empty where there is no algorithm of that name.
std::string kind_of(const v1::Algorithms& asked);

/// InvalidArgument where pixels cannot share light in this job (RenderSettings.path_sharing).
absl::Status allows_sharing(const v1::JobSpec& spec);

/// Returns the right JobSpec.View.sample_bits.
std::uint32_t sample_bits_of(const v1::JobSpec& spec);

/// Gives the job the phases of its algorithm, which must exist, and a pilot where noise decides how many
/// samples its crop takes.
void add_phases(v1::JobSpec& spec);

/// The check of a blob that a unit of the job's phases makes, and what the job says of it.
struct ExpectedBlob {
  const PhaseBlobCheck* check;
  PhaseBlob blob;
};
/// Absent where nothing checks blobs of the phase. `unit` is a part or a merge.
std::optional<ExpectedBlob> expected_blob(const v1::JobSpec& spec, const v1::WorkUnit& unit);

/// Whether the job's units are passes. False for unknown algorithms.
bool works_in_passes(const v1::JobSpec& spec);

}  // namespace tessera::wire
