// Pictures without their noise, from what was rendered along with them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "image/image.h"

namespace tessera::client {

enum class DenoiseMethod { kStatistical, kRegression, kOidn };

/// "statistical", "regression" or "oidn".
std::string word_of(DenoiseMethod method);
/// InvalidArgument, with the words that there are. "off" is none.
absl::StatusOr<std::optional<DenoiseMethod>> parse_denoise_method(std::string_view word);

struct DenoiseOptions {
  DenoiseMethod method = DenoiseMethod::kRegression;
  int threads = 0;           // 0: one a core
  std::string oidn_library;  // empty: where the loader looks
};

/// Findings besides noise.
struct DenoiseReport {
  std::size_t fireflies = 0;   // pixels whose light was cut down to that of their neighbours
  std::size_t not_finite = 0;  // pixels that were filled from their neighbours
};

/// Replaces R, G and B by denoised ones, the same bits for any number of threads, and keeps what they were as
/// raw.R, raw.G and raw.B; where those are there already, they are what is denoised. Alpha and layers stay as
/// they are. Sets the attributes "tessera.denoised" ("regression, biased"), "tessera.integrator_kind"
/// ("biased") and "tessera.fireflies_cut", and adds " + denoised" to the integrator's name. InvalidArgument,
/// with the AOVs that are missing (noisy_picture.h); NotFound and Internal of `kOidn`.
absl::StatusOr<DenoiseReport> denoise_image(const DenoiseOptions& options, Image& image);

/// Bytes of memory that denoise_image() takes, about, with the picture's own planes, of which there are so
/// many: it needs the whole picture at once. What OIDN takes itself comes on top.
std::uint64_t denoise_memory(std::uint64_t pixels, std::size_t planes);

/// Says that of a denoised picture again, where what it says of its making was set anew.
void mark_biased(Image& image);

/// Whether the picture was denoised: then it is biased, and no reference.
bool is_denoised(const Image& image);

}  // namespace tessera::client
