// The denoisers.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "denoise/noisy_picture.h"

namespace tessera::client::denoise {

/// R, G and B, `width * height` values each.
using Colours = std::array<std::vector<float>, 3>;

/// Averages pixels that look at alike things and whose light cannot be told apart by a test of equality
/// [Sakai et al. 2024]; what differs significantly is kept.
Colours denoise_statistically(const NoisyPicture& picture, int threads);

/// First-order fits of colour to features, in windows weighted by NL-means, of two bandwidths and the picture
/// as it is, mixed by their estimated errors [Bitterli et al. 2016].
Colours denoise_by_regression(const NoisyPicture& picture, int threads);

/// Denoises with Intel's Open Image Denoise, which is looked for at run time: `library`, or where the loader
/// looks when that is empty. NotFound where there is none; Internal with what it says.
absl::StatusOr<Colours> denoise_by_oidn(const NoisyPicture& picture, const std::string& library);

}  // namespace tessera::client::denoise
