// Which fields of a job's spec decide about what: the one list, from which keys follow.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "tessera/v1/job.pb.h"

namespace tessera::wire {

enum class JobPart : std::uint8_t {
  kScene,    // what is built of the scene, for any number of views
  kView,     // what else a sample depends on: film, sampler, depth, layers
  kSamples,  // how many are taken
  kUnits,    // how the work is cut
  kBuild,    // of the programs
  kKernels,  // the ISA
  kFarm      // whose job it is, and who may work on it; or follows from other fields
};

/// The fields of JobSpec and of its RenderSettings, each in its part.
struct JobField {
  std::string_view message, name;
  JobPart part;
};
std::span<const JobField> job_fields();

/// The spec without the fields of all other parts: equal where these are.
v1::JobSpec parts_of(const v1::JobSpec& spec, std::span<const JobPart> parts);

}  // namespace tessera::wire
