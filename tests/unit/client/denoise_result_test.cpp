// A picture that is denoised has to be in memory: where it may not be, that is told, and where it is not yet,
// it is read.
#include "command/denoise_result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "image/exr/rows.h"
#include "wire/aov_channels.h"

namespace tessera::client {
namespace {

using testing::HasSubstr;

RenderOptions denoising(DenoiseMethod method) {
  RenderOptions options;
  options.job.denoise = method;
  options.quiet = true;
  options.threads = 1;
  return options;
}

v1::JobSpec job(std::uint32_t width, std::uint32_t height) {
  v1::JobSpec spec;
  for (const v1::AOV aov : {v1::AOV_VARIANCE, v1::AOV_ALBEDO, v1::AOV_NORMAL, v1::AOV_DEPTH, v1::AOV_HALVES})
    spec.mutable_view()->add_aovs(aov);
  spec.mutable_samples()->set_spp(4);
  spec.mutable_cut()->mutable_crop()->set_x1(width);
  spec.mutable_cut()->mutable_crop()->set_y1(height);
  return spec;
}

TEST(DenoiseResult, AFrameMemoryThatIsTooSmallIsRefusedWithBothNumbers) {
  RenderOptions options = denoising(DenoiseMethod::kRegression);
  const v1::JobSpec spec = job(8192, 4096);
  const std::uint64_t needed = denoise_memory(options, spec);
  EXPECT_EQ(needed, std::uint64_t{8192} * 4096 * (208 + 4 * 27))
      << "24 channels, and three of the raw picture";
  options.exr.frame_memory = std::uint64_t{1} << 29;
  const absl::Status refused = check_denoise_memory(options, spec);
  EXPECT_EQ(refused.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(refused.message()),
              HasSubstr("denoising 8192x4096 pixels takes about 9.88 GiB of memory, for it needs the whole "
                        "picture; --frame-memory allows 0.5 GiB"));
  options.exr.frame_memory = needed;
  EXPECT_TRUE(check_denoise_memory(options, spec).ok());
  options.exr.frame_memory = 1;
  options.job.denoise.reset();
  EXPECT_TRUE(check_denoise_memory(options, spec).ok());
  EXPECT_EQ(frame_memory(options.exr), 1u) << "of a PNG, too";
}

TEST(DenoiseResult, APictureElsewhereIsDenoisedAsOneInMemory) {
  const v1::JobSpec spec = job(12, 10);
  const auto picture = std::make_shared<Image>();
  picture->data = picture->display = {0, 0, 12, 10};
  for (const wire::ChannelDesc& channel : wire::channels_of(spec.view())) {
    std::vector<float>& values = picture->add(channel.name).values;
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<float>((i * 37 + picture->channels.size() * 11) % 64) / 64;
  }
  FollowedJob in_memory, elsewhere;
  for (FollowedJob* followed : {&in_memory, &elsewhere}) {
    followed->status.set_state(v1::DONE);
    followed->images.push_back(
        {.image = *picture, .rows = nullptr, .holes = {}, .denoised = absl::OkStatus()});
  }
  for (Channel& channel : elsewhere.images[0].image.channels) channel.values.clear();
  elsewhere.images[0].rows = std::make_unique<ImageRows>(*picture);
  const RenderOptions options = denoising(DenoiseMethod::kRegression);
  denoise_result(options, spec, in_memory);
  denoise_result(options, spec, elsewhere);
  ASSERT_TRUE(in_memory.images[0].denoised.ok()) << in_memory.images[0].denoised;
  ASSERT_TRUE(elsewhere.images[0].denoised.ok()) << elsewhere.images[0].denoised;
  EXPECT_EQ(elsewhere.images[0].rows, nullptr);
  ASSERT_EQ(elsewhere.images[0].image.channels.size(), in_memory.images[0].image.channels.size());
  ASSERT_NE(elsewhere.images[0].image.find("raw.R"), nullptr);
  EXPECT_NE(elsewhere.images[0].image.find("R")->values, picture->find("R")->values);
  for (std::size_t c = 0; c < in_memory.images[0].image.channels.size(); ++c)
    EXPECT_EQ(elsewhere.images[0].image.channels[c].values, in_memory.images[0].image.channels[c].values);
}

}  // namespace
}  // namespace tessera::client
