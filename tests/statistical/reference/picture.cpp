#include "statistical/reference/picture.h"

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <thread>

#include "absl/strings/str_cat.h"
#include "support/long_form.h"
#include "support/picture/phases.h"

namespace tessera::test {

namespace {

constexpr std::uint32_t kSide = 32, kBlock = 8, kBlocks = kSide / kBlock, kBatches = 32;
constexpr std::size_t kValues = 3 * (1 + kBlocks * kBlocks);
constexpr double kStandardErrors = 6;

/// Means of one batch, in the order of Picture::values; behind them, those of all channels.
std::vector<double> batch_means(const wire::TileResult& tile, std::uint32_t samples) {
  std::vector<double> means(kValues + tile.channels.size(), 0);
  for (std::uint32_t c = 0; c < 3; ++c) {
    for (std::uint32_t y = 0; y < kSide; ++y) {
      for (std::uint32_t x = 0; x < kSide; ++x) {
        const double value = tile.values[(c * kSide + y) * kSide + x] / double{static_cast<float>(samples)};
        const std::uint32_t block = y / kBlock * kBlocks + x / kBlock;
        means[c] += value / (kSide * kSide);
        means[3 + 3 * block + c] += value / (kBlock * kBlock);
      }
    }
  }
  for (std::size_t c = 0; c < tile.channels.size(); ++c) {
    for (std::size_t i = 0; i < kSide * kSide; ++i)
      means[kValues + c] +=
          tile.values[c * kSide * kSide + i] / static_cast<double>(samples) / (kSide * kSide);
  }
  return means;
}

/// Sums over batches, by value.
struct BatchSums {
  std::vector<double> sum, of_squares;

  void add(const std::vector<double>& means) {
    sum.resize(means.size()), of_squares.resize(means.size());
    for (std::size_t v = 0; v < means.size(); ++v) sum[v] += means[v], of_squares[v] += means[v] * means[v];
  }
  Picture::Value value(std::size_t v) const {
    const double mean = sum[v] / kBatches;
    const double variance = std::max(0.0, of_squares[v] / kBatches - mean * mean);
    return {mean, std::sqrt(variance / (kBatches - 1))};
  }
};

}  // namespace

std::uint32_t samples_of_form(std::uint32_t in_long_form) {
  return long_form() ? in_long_form : std::max(kBatches, in_long_form / 4);
}

double noise_of_form(double in_long_form) { return long_form() ? in_long_form : 2 * in_long_form; }

Picture measure_picture(const PictureRequest& request) {
  test::SceneJob job;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(request.settings, &job.settings))
      << request.settings;
  job.settings.set_integrator(request.integrator);
  job.settings.set_sampler(v1::SAMPLER_INDEPENDENT);
  job.settings.set_spp(request.spp);
  job.settings.set_max_depth(request.max_depth);
  // Two estimators must not share their random numbers.
  const std::string isa = request.isa.empty() ? render::supported_isas().front() : request.isa;
  job.settings.set_seed((std::hash<std::string>()(request.integrator + request.settings + isa) & 0xffff) +
                        (request.seed << 16));
  const std::string text = absl::StrCat(request.scene, " film { width: ", kSide, " height: ", kSide,
                                        " filter { ", request.filter, " } }");
  const auto file = load_scene_text(text, job, isa, request.blobs);
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return {};
  for (const std::string& warning : file->scene->warnings()) {
    if (!is_of_blindness(warning)) ADD_FAILURE() << warning;
  }
  const MadePhases phases = make_phases(*file);

  BatchSums sums;
  std::mutex mutex;
  std::atomic<std::uint32_t> next{0};
  const std::uint32_t samples = request.spp / kBatches;
  const auto work = [&] {
    for (std::uint32_t i; (i = next.fetch_add(1)) < kBatches;) {
      render::RenderStats stats;
      const auto tile = file->scene->render_tile(
          {0, 0, kSide, kSide, i * samples, (i + 1) * samples, 0, phases.prepared.get()}, {}, stats);
      const std::lock_guard lock(mutex);
      EXPECT_TRUE(tile.ok()) << tile.status();
      EXPECT_EQ(stats.dropped_samples, 0u);
      if (!tile.ok()) continue;
      sums.add(batch_means(*tile, samples));
    }
  };
  {
    std::vector<std::jthread> workers;
    for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
      workers.emplace_back(work);
  }
  Picture picture;
  for (std::size_t v = 0; v < sums.sum.size(); ++v) {
    const Picture::Value value = sums.value(v);
    EXPECT_TRUE(std::isfinite(value.mean));
    (v < kValues ? picture.values : picture.channels).push_back(value);
  }
  return picture;
}

void expect_same(const Picture& a, const Picture& b, double relative) {
  ASSERT_EQ(a.values.size(), b.values.size());
  ASSERT_FALSE(a.values.empty());
  for (std::size_t v = 0; v < a.values.size(); ++v) {
    const double error = std::hypot(a.values[v].error, b.values[v].error);
    EXPECT_NEAR(a.values[v].mean, b.values[v].mean,
                kStandardErrors * error + relative * std::abs(a.values[v].mean) + 1e-6)
        << (v < 3 ? "whole picture" : absl::StrCat("block ", v / 3 - 1)) << ", channel " << v % 3
        << ", standard error " << error;
  }
}

void expect_value(const Picture& picture, double expected, double relative) {
  ASSERT_FALSE(picture.values.empty());
  for (std::size_t v = 0; v < picture.values.size(); ++v) {
    EXPECT_NEAR(picture.values[v].mean, expected,
                kStandardErrors * picture.values[v].error + relative * std::abs(expected) + 1e-6)
        << (v < 3 ? "whole picture" : absl::StrCat("block ", v / 3 - 1)) << ", channel " << v % 3;
  }
}

}  // namespace tessera::test
