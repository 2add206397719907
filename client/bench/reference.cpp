#include "bench/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "bench/measure.h"
#include "denoise/denoise.h"
#include "image/exr.h"
#include "image/metrics.h"
#include "wire/colour_channels.h"

namespace tessera::client {
namespace {

constexpr const char* kMse = "tessera.reference_mse";
constexpr const char* kRelmse = "tessera.reference_relmse";
/// Measured images have offsets from 0 up.
constexpr std::uint64_t kSeedOffsets[] = {std::uint64_t{1} << 40, std::uint64_t{2} << 40};

double number(const Image& image, const char* name) {
  const auto found = image.metadata.find(name);
  const float* value = found == image.metadata.end() ? nullptr : std::get_if<float>(&found->second);
  return value != nullptr && std::isfinite(*value) && *value > 0 ? *value : 0;
}

std::string attribute_of(int block) { return absl::StrCat(kRelmse, "_", block, "x", block); }

/// Makes `first` the mean of both and returns the error of that mean.
ReferenceNoise merge_halves(Image& first, const Image& second, int block) {
  ReferenceNoise noise;
  double terms = 0;
  std::array<std::vector<double>, 3> means, errors;
  for (std::size_t c = 0; c < 3; ++c) {
    const char* const name = wire::kColourChannels[c];
    auto& a = std::ranges::find(first.channels, name, &Channel::name)->values;
    const auto& b = second.find(name)->values;
    for (std::size_t i = 0; i < a.size(); ++i) {
      means[c].push_back(0.5 * (double{a[i]} + b[i]));
      errors[c].push_back(0.5 * (double{a[i]} - b[i]));
      const double mean = means[c].back(), variance = errors[c].back() * errors[c].back();
      a[i] = static_cast<float>(mean);
      noise.mse += variance;
      noise.relmse += variance / (mean * mean + CompareOptions{}.epsilon);
      ++terms;
    }
  }
  noise.mse /= terms, noise.relmse /= terms;
  noise.relmse_block = relmse_of_blocks(means, errors, first.data.width(), block, CompareOptions{}.epsilon);
  return noise;
}

}  // namespace

absl::StatusOr<BenchReference> read_reference(const std::string& path, int block) {
  absl::StatusOr<Image> image = read_exr(path);
  if (!image.ok()) return image.status();
  if (is_denoised(*image))
    return absl::InvalidArgumentError(absl::StrCat(path, ": a denoised picture is biased, and no reference"));
  const ReferenceNoise noise{number(*image, kMse), number(*image, kRelmse),
                             number(*image, attribute_of(block).c_str())};
  return BenchReference{*std::move(image), noise, path};
}

absl::StatusOr<BenchReference> make_reference(const BenchVariant& variant, std::uint32_t spp, int threads,
                                              int block, std::stop_token stop) {
  std::optional<Image> image;
  ReferenceNoise noise;
  const std::uint32_t half = std::max(1u, spp / 2);
  for (const std::uint64_t seed_offset : kSeedOffsets) {
    const BenchScene* const scene = variant.scene.get();
    absl::StatusOr<std::vector<BenchRender>> render =
        render_in_turn({&scene, 1}, half, seed_offset, threads, stop);
    if (!render.ok()) return render.status();
    absl::StatusOr<Image> rendered = assemble_image(variant.spec, half, std::move(render->front().tiles));
    if (!rendered.ok()) return rendered.status();
    if (image) {
      noise = merge_halves(*image, *rendered, block);
    } else {
      image = *std::move(rendered);
    }
  }
  return BenchReference{*std::move(image), noise,
                        absl::StrCat("rendered with ", 2 * half, " samples a pixel")};
}

absl::Status write_reference(const BenchReference& reference, int block, const std::string& path) {
  Image image = reference.image;
  std::erase_if(image.channels, [](const Channel& channel) {
    return std::ranges::find(wire::kColourChannels, channel.name) == wire::kColourChannels.end();
  });
  image.metadata[kMse] = static_cast<float>(reference.noise.mse);
  image.metadata[kRelmse] = static_cast<float>(reference.noise.relmse);
  image.metadata[attribute_of(block)] = static_cast<float>(reference.noise.relmse_block);
  return write_exr(image, path);
}

}  // namespace tessera::client
