#include "command/denoise_result.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>

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

}  // namespace

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
  if (!options.job.denoise || !followed.image) return;
  if (followed.status.state() != v1::DONE || followed.incomplete_pixels > 0) {
    std::cerr << "warning: the picture is not whole, and is not denoised\n";
    return;
  }
  Image& image = *followed.image;
  image.metadata["tessera.spp"] = static_cast<std::int32_t>(spec.samples().spp());
  const absl::StatusOr<DenoiseReport> done =
      denoise_image(denoise_options(*options.job.denoise, options.threads), image);
  if (!done.ok()) {
    followed.denoised = done.status();
    return;
  }
  if (!options.quiet) tell(*done);
  keep_wanted(options.job, image);
}

}  // namespace tessera::client
