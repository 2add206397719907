// Denoising of what a command has rendered.
#pragma once

#include "command/jobs/follow.h"
#include "command/render_options.h"
#include "denoise/denoise.h"

namespace tessera::client {

/// $TESSERA_OIDN names the library of `kOidn`.
DenoiseOptions denoise_options(DenoiseMethod method, int threads);

/// Tells on standard error what denoising cut and filled.
void tell(const DenoiseReport& report);

/// Bytes of memory that denoising the job's picture takes, with the picture; 0 where that is not asked for.
std::uint64_t denoise_memory(const RenderOptions& options, const v1::JobSpec& spec);

/// OutOfRange where --frame-memory allows fewer bytes than that, with both. Where the machine has fewer to
/// spare, a warning says so (unless quiet).
absl::Status check_denoise_memory(const RenderOptions& options, const v1::JobSpec& spec);

/// Denoises the image of a job that is done, where that is asked for, and takes out the channels that only it
/// needed. Where it fails, or memory is short, the image stays as it is, and FollowedJob::denoised says why.
/// One that is not whole is not denoised, and a warning says so.
void denoise_result(const RenderOptions& options, const v1::JobSpec& spec, FollowedJob& followed);

}  // namespace tessera::client
