#include "denoise/denoise.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "denoise/methods.h"
#include "denoise/noisy_picture.h"
#include "wire/colour_channels.h"

namespace tessera::client {
namespace {

constexpr std::pair<const char*, DenoiseMethod> kWords[] = {{"statistical", DenoiseMethod::kStatistical},
                                                            {"regression", DenoiseMethod::kRegression},
                                                            {"oidn", DenoiseMethod::kOidn}};
constexpr const char* kAttribute = "tessera.denoised";

/// No pixel changes by more than its noise explains, four standard errors: at edges that no guide shows, a
/// window may hold light a thousand times the pixel's own.
void keep_within_noise(const denoise::NoisyPicture& picture, denoise::Colours& colours) {
  constexpr float kErrors = 4;
  for (std::size_t c = 0; c < 3; ++c) {
    std::size_t i = 0;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x, ++i) {
        const float raw = 0.5f * (*picture.first[c].at(x, y) + *picture.second[c].at(x, y));
        const float bound = kErrors * std::sqrt(0.5f * *picture.usual[c].at(x, y));
        colours[c][i] = std::clamp(colours[c][i], raw - bound, raw + bound);
      }
    }
  }
}

absl::StatusOr<denoise::Colours> denoised(const denoise::NoisyPicture& picture,
                                          const DenoiseOptions& options) {
  if (options.method == DenoiseMethod::kOidn) return denoise::denoise_by_oidn(picture, options.oidn_library);
  denoise::Colours colours = options.method == DenoiseMethod::kStatistical
                                 ? denoise::denoise_statistically(picture, options.threads)
                                 : denoise::denoise_by_regression(picture, options.threads);
  keep_within_noise(picture, colours);
  return colours;
}

}  // namespace

std::string word_of(DenoiseMethod method) {
  return std::ranges::find(kWords, method, [](const auto& entry) { return entry.second; })->first;
}

absl::StatusOr<std::optional<DenoiseMethod>> parse_denoise_method(std::string_view word) {
  if (word == "off") return std::nullopt;
  for (const auto& [name, method] : kWords) {
    if (word == name) return method;
  }
  return absl::InvalidArgumentError(absl::StrCat("there is no denoiser '", std::string{word},
                                                 "'; there is: off, statistical, regression, oidn"));
}

absl::StatusOr<DenoiseReport> denoise_image(const DenoiseOptions& options, Image& image) {
  const bool again = image.find(wire::colour_channels_of("raw").front()) != nullptr;
  const absl::StatusOr<denoise::NoisyPicture> picture =
      denoise::read_noisy_picture(image, again ? "raw." : "", options.threads);
  if (!picture.ok()) return picture.status();
  absl::StatusOr<denoise::Colours> colours = denoised(*picture, options);
  if (!colours.ok()) return colours.status();
  constexpr auto kNames = wire::kColourChannels;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto own = std::ranges::find(image.channels, kNames[c], &Channel::name);
    if (own == image.channels.end())
      return absl::InvalidArgumentError(absl::StrCat("channel ", kNames[c], " is missing"));
    std::vector<float> raw = std::exchange(own->values, std::move((*colours)[c]));
    if (!again) image.add(absl::StrCat("raw.", kNames[c])).values = std::move(raw);
  }
  image.metadata[kAttribute] = absl::StrCat(word_of(options.method), ", biased");
  mark_biased(image);
  image.metadata["tessera.fireflies_cut"] = static_cast<std::int32_t>(picture->fireflies);
  return DenoiseReport{.fireflies = picture->fireflies, .not_finite = picture->not_finite};
}

std::uint64_t denoise_memory(std::uint64_t pixels, std::size_t planes) {
  // Measured beside the planes: 186 (regression) and 203 (statistical) bytes a pixel; for OIDN as much is
  // made.
  constexpr std::uint64_t kBytes = 208;
  return pixels * (sizeof(float) * planes + kBytes);
}

void mark_biased(Image& image) {
  constexpr const char* kMark = " + denoised";
  if (!is_denoised(image)) return;
  image.metadata["tessera.integrator_kind"] = "biased";
  const auto found = image.metadata.find("tessera.integrator");
  auto* const name = found == image.metadata.end() ? nullptr : std::get_if<std::string>(&found->second);
  if (name != nullptr && !name->ends_with(kMark)) *name += kMark;
}

bool is_denoised(const Image& image) { return image.metadata.contains(kAttribute); }

}  // namespace tessera::client
