// The phase that comes before a picture whose noise decides how many samples it takes: a pilot over all of
// its blocks of pixels, with the job's own algorithm [docs/decisions/0060-noise-phase.md].
#pragma once

#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "render/film/noise_target.h"
#include "render/film/sample_counts.h"
#include "render/integrator/integrator.h"

namespace tessera::render {

/// The data that units of the picture read.
struct NoisePrepared final : Prepared {
  std::shared_ptr<const Prepared> algorithm;  // made by the algorithm's own phases, if it has any
  SampleCounts counts;
};

/// Makes one part, of the film where `crop` is empty. False when stopped.
bool make_noise_pilot(const Algorithm& algorithm, const IntegratorContext& context, const PartRequest& part,
                      const FilmRect& crop, const NoiseTarget& target, bool scatters, PixelGroup group,
                      std::stop_token stop, std::string& blob);
/// Merges neighbouring blobs. False where they are not the phase's.
bool merge_noise_pilots(std::span<const std::string_view> blobs, std::string& merged);
/// InvalidArgument where `blob` is no pilot of blocks of the film.
absl::StatusOr<std::shared_ptr<const Prepared>> prepare_noise(std::string_view blob,
                                                              std::shared_ptr<const Prepared> algorithm,
                                                              const NoiseTarget& target,
                                                              const SceneTables& scene, bool scatters);

}  // namespace tessera::render
