// Pictures that other renderers made of scenes that other people made. The corpus lies beside the project;
// without it the tests are skipped by name.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <thread>

#include "image/exr.h"
#include "image/metrics.h"
#include "support/needs.h"
#include "support/picture/render_image.h"

namespace tessera::test {
namespace {

constexpr const char* kCorpus = "../shared/scenes/";

client::Image render(const std::string& path, std::uint32_t spp) {
  test::SceneJob job;
  job.settings.set_spp(spp);
  const int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const auto file = load_scene_file(path, job, render::supported_isas().front(), threads);
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? render_image(*file) : client::Image{};
}

client::Image crop(const client::Image& image, client::Window window) {
  client::Image result;
  result.data = result.display = window;
  for (const client::Channel& channel : image.channels) {
    client::Channel& to = result.add(channel.name);
    to.values.clear();
    for (std::int32_t y = window.y0; y < window.y1; ++y) {
      const auto row = channel.values.begin() + std::ptrdiff_t{y} * image.data.width();
      to.values.insert(to.values.end(), row + window.x0, row + window.x1);
    }
  }
  return result;
}

/// Means are equal within the rounding of half floats, which on walls of nearly one value does not cancel,
/// and five standard errors of the means of blocks (p = 6 10^-7), the reference's noise among them. These
/// errors are `standard_error_percent` at most, so that noise hides no more than was known when this was
/// written.
void expect_equal_means(const client::Comparison& comparison, double standard_error_percent) {
  constexpr double kHalfRoundingPercent = 100 * 0x1p-11;
  for (const client::ChannelBias& channel : comparison.channels) {
    const double standard_error = std::abs(channel.bias_percent / channel.t);
    EXPECT_LT(standard_error, standard_error_percent);
    EXPECT_LT(std::abs(channel.bias_percent), kHalfRoundingPercent + 5 * standard_error);
  }
}

bool have(const std::string& file) { return std::filesystem::exists(std::string(kCorpus) + file); }

TEST(Reference, CornellBoxAgreesWithTungstenAndMitsuba) {
  if (!have("pbrt/cornell-box/reference.exr")) GTEST_SKIP() << needs("../shared/scenes");
  const client::Image ours = render(std::string(kCorpus) + "pbrt/cornell-box/scene.pbrt", 32);
  for (const char* file : {"pbrt/cornell-box/reference.exr", "mitsuba/cornell-box/reference-mitsuba.exr"}) {
    const auto reference = client::read_exr(std::string(kCorpus) + file);
    ASSERT_TRUE(reference.ok()) << reference.status();
    SCOPED_TRACE(file);
    const auto comparison = client::compare_images(*reference, ours);
    ASSERT_TRUE(comparison.ok()) << comparison.status();
    expect_equal_means(*comparison, 0.03);
    EXPECT_EQ(comparison->blocks_rejected, 0u) << file;
    EXPECT_EQ(comparison->non_finite_pixels, 0u);
  }
}

TEST(Reference, VeachMisAgreesOnWallAndFloor) {
  if (!have("pbrt/veach-mis/reference.exr")) GTEST_SKIP() << needs("../shared/scenes");
  const client::Image ours = render(std::string(kCorpus) + "pbrt/veach-mis/scene.pbrt", 64);
  const auto reference = client::read_exr(std::string(kCorpus) + "pbrt/veach-mis/reference.exr");
  ASSERT_TRUE(reference.ok()) << reference.status();
  // Above the plates and below them; the plates themselves are known to differ (another microfacet model).
  for (const client::Window& window : {client::Window{0, 0, 1280, 240}, client::Window{0, 688, 1280, 720}}) {
    const auto comparison = client::compare_images(crop(*reference, window), crop(ours, window));
    ASSERT_TRUE(comparison.ok()) << comparison.status();
    expect_equal_means(*comparison, 0.15);
  }
}

}  // namespace
}  // namespace tessera::test
