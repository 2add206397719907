#include "wire/noise.h"

#include "absl/strings/str_cat.h"
#include "wire/limits.h"

namespace tessera::wire {

absl::Status check_noise(const v1::JobSpec& spec) {
  const double noise = spec.settings().noise();
  if (noise == 0) return absl::OkStatus();
  if (!(noise >= kMinNoise && noise <= kMaxNoise)) {
    return absl::InvalidArgumentError(
        absl::StrCat("settings.noise is ", noise, "; 0 or ", kMinNoise, " to ", kMaxNoise, " was expected"));
  }
  if (spec.settings().spp() < kMinAdaptiveSamples) {
    return absl::InvalidArgumentError(absl::StrCat("settings.spp is ", spec.settings().spp(),
                                                   "; with settings.noise it is the cap, and ",
                                                   kMinAdaptiveSamples, " or more was expected"));
  }
  if (spec.tile_size() % kNoiseBlock != 0) {
    return absl::InvalidArgumentError(absl::StrCat("tile_size is ", spec.tile_size(),
                                                   "; with settings.noise a multiple of ", kNoiseBlock,
                                                   " was expected"));
  }
  if (spec.samples_per_unit() < spec.settings().spp()) {
    return absl::InvalidArgumentError(absl::StrCat("samples_per_unit is ", spec.samples_per_unit(),
                                                   "; with settings.noise a unit takes all ",
                                                   spec.settings().spp(), " samples"));
  }
  return absl::OkStatus();
}

}  // namespace tessera::wire
