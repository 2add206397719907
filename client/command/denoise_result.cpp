#include "command/denoise_result.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "absl/strings/str_format.h"
#include "base/available_memory.h"
#include "wire/aov_channels.h"

namespace tessera::client {
namespace {

/// Takes out channels of AOVs that were not asked for.
void keep_wanted(const JobSettings& job, Image& image) {
  std::vector<v1::AOV> own = {v1::AOV_VARIANCE, v1::AOV_ALBEDO, v1::AOV_NORMAL, v1::AOV_DEPTH,
                              v1::AOV_HALVES};
  std::vector<std::string> unwanted;
  for (const wire::ChannelDesc& channel : wire::channels_for_aovs(own)) unwanted.push_back(channel.name);
  const std::vector<wire::ChannelDesc> wanted = wire::channels_for_aovs(job.aovs);
  std::erase_if(image.channels, [&](const Channel& channel) {
    return std::ranges::find(unwanted, channel.name) != unwanted.end() &&
           std::ranges::find(wanted, channel.name, &wire::ChannelDesc::name) == wanted.end();
  });
}

double gibibytes(std::uint64_t bytes) { return static_cast<double>(bytes) / (1 << 30); }

/// "denoising 8192x4096 pixels takes about 9.6 GiB of memory"
std::string demand(std::uint64_t bytes, const v1::JobSpec& spec) {
  const v1::PixelRect& crop = spec.cut().crop();
  return absl::StrFormat("denoising %dx%d pixels takes about %.3g GiB of memory", crop.x1() - crop.x0(),
                         crop.y1() - crop.y0(), gibibytes(bytes));
}

/// Puts the planes of a picture into memory.
absl::Status read_planes(Rows& rows, Image& image) {
  const auto width = static_cast<std::size_t>(image.data.width());
  for (std::size_t c = 0; c < image.channels.size(); ++c) {
    std::vector<float>& values = image.channels[c].values;
    values.resize(image.pixel_count());
    for (std::int32_t y = 0; y < image.data.height(); ++y) {
      const std::span<float> row = std::span(values).subspan(static_cast<std::size_t>(y) * width, width);
      if (absl::Status status = rows.read(c, y, row); !status.ok()) return status;
    }
  }
  return absl::OkStatus();
}

/// Puts the picture into memory, if it is elsewhere and there is memory to denoise it.
absl::Status make_whole(std::uint64_t needed, const v1::JobSpec& spec, FollowedImage& followed) {
  if (!followed.rows) return absl::OkStatus();
  if (const std::uint64_t available = base::available_memory(); needed > available) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("%s, and %.3g are free", demand(needed, spec), gibibytes(available)));
  }
  Image whole = followed.image;
  if (absl::Status status = read_planes(*followed.rows, whole); !status.ok()) return status;
  followed.image = std::move(whole);
  followed.rows.reset();
  return absl::OkStatus();
}

}  // namespace

std::uint64_t denoise_memory(const RenderOptions& options, const v1::JobSpec& spec) {
  if (!options.job.denoise) return 0;
  const v1::PixelRect& crop = spec.cut().crop();
  const std::uint64_t pixels = std::uint64_t{crop.x1() - crop.x0()} * (crop.y1() - crop.y0());
  constexpr std::size_t kNoisyChannels = 3;  // R, G and B before denoising
  return denoise_memory(pixels, wire::channels_of(spec.view()).size() + kNoisyChannels);
}

absl::Status check_denoise_memory(const RenderOptions& options, const v1::JobSpec& spec) {
  const std::uint64_t needed = denoise_memory(options, spec);
  if (const auto& allowed = options.exr.frame_memory; allowed && needed > *allowed) {
    return absl::OutOfRangeError(
        absl::StrFormat("%s, for it needs the whole picture; --frame-memory allows %.3g GiB",
                        demand(needed, spec), gibibytes(*allowed)));
  }
  if (const std::uint64_t available = base::available_memory(); needed > available && !options.quiet) {
    std::cerr << absl::StrFormat(
        "warning: %s, and %.3g are free; if that is so at the end, too, the picture is written as it was "
        "rendered\n",
        demand(needed, spec), gibibytes(available));
  }
  return absl::OkStatus();
}

DenoiseOptions denoise_options(DenoiseMethod method, int threads) {
  const char* const library = std::getenv("TESSERA_OIDN");
  return {.method = method, .threads = threads, .oidn_library = library != nullptr ? library : ""};
}

void tell(const DenoiseReport& report) {
  if (report.fireflies > 0)
    std::cerr << "denoising: " << report.fireflies
              << " lone bright pixels were cut down to their neighbours\n";
  if (report.not_finite > 0) {
    std::cerr << "denoising: " << report.not_finite
              << " pixels were not finite and are filled from their neighbours\n";
  }
}

void denoise_result(const RenderOptions& options, const v1::JobSpec& spec, FollowedJob& followed) {
  if (!options.job.denoise) return;
  for (FollowedImage& of_view : followed.images) {
    if (followed.status.state() != v1::DONE || of_view.incomplete_pixels > 0) {
      std::cerr << "warning: the picture is not whole, and is not denoised\n";
      return;
    }
    of_view.denoised = make_whole(denoise_memory(options, spec), spec, of_view);
    if (!of_view.denoised.ok()) continue;
    Image& image = of_view.image;
    image.metadata["tessera.spp"] = static_cast<std::int32_t>(spec.samples().spp());
    const absl::StatusOr<DenoiseReport> done =
        denoise_image(denoise_options(*options.job.denoise, options.threads), image);
    if (!done.ok()) {
      of_view.denoised = done.status();
      continue;
    }
    if (!options.quiet) tell(*done);
    keep_wanted(options.job, image);
  }
}

}  // namespace tessera::client
