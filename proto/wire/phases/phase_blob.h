// Blobs that the phases of jobs make, as coordinators check them when a result names one
// [docs/decisions/0026-phases.md]. Their layouts are in this folder, with the readers that renderers use.
// Nothing here knows messages: kernels link it.
#pragma once

#include <cstdint>
#include <string_view>

namespace tessera::wire {

/// Describes the blob that a part or a merge of one of a job's phases makes, as far as the job says.
struct PhaseBlob {
  std::uint32_t first_part = 0, end_part = 1;  // parts that are in it
  std::uint32_t parts = 1;                     // parts of the phase
  struct {
    std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  } crop;                          // pixels of the picture
  std::uint32_t glossy_bands = 0;  // IrradianceCache.glossy_bands
  std::uint64_t memory_limit = 0;  // RadiositySettings.memory_limit, bytes

  std::uint64_t part_count() const { return std::uint64_t{end_part} - first_part; }
};

/// Check of one kind of blobs, by what can be told without the scene.
struct PhaseBlobCheck {
  /// The largest that an honest worker makes, bytes: a larger one need not be read.
  std::uint64_t (*most_bytes)(const PhaseBlob& blob);
  /// Names what is wrong with the bytes; null where nothing is.
  const char* (*fault)(std::string_view bytes, const PhaseBlob& blob);
};

extern const PhaseBlobCheck kIrradianceRecordsCheck, kGuideSumsCheck;
// Radiosity's phases make links between whole sides, links between patches, and the solution.
extern const PhaseBlobCheck kEstimateLinksCheck, kPatchLinksCheck, kRadiositySolutionCheck;
extern const PhaseBlobCheck kNoisePilotCheck;  // noise_pilot_blob.cpp

}  // namespace tessera::wire
