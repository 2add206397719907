// Many renders of few samples each have the mean of one render of very many: nothing that the renderer does
// by default depends on how many samples a pixel gets, or favours what the first samples happen to show.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>

#include "support/long_form.h"
#include "support/needs.h"
#include "support/picture/phases.h"
#include "support/picture/scene_file.h"

namespace tessera::test {
namespace {

/// How much is rendered. The short form sees biases of a few percent only, but runs all of the code.
struct Size {
  std::uint32_t side, few, renders, many;
};
constexpr Size kShort{16, 16, 64, 4096}, kLong{40, 16, 256, 65536};
constexpr std::uint32_t kBatches = 64;  // batches of the render with many samples

/// Mean, variance of that mean, and how many samples they are from, of every pixel and channel.
struct Estimate {
  std::vector<double> mean, variance, samples;
};

/// Adds one of `count` equally good estimates of every value at a time.
class Accumulator {
 public:
  explicit Accumulator(std::size_t values) : sum_(values, 0), squares_(values, 0), samples_(values, 0) {}
  void add(const wire::TileResult& tile) {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < sum_.size(); ++i) {
      const auto samples = static_cast<double>(tile.counts[i % tile.pixel_count()]);
      const double value = tile.values[i] / samples;
      samples_[i] += samples;
      sum_[i] += value;
      squares_[i] += value * value;
    }
    ++count_;
  }
  Estimate estimate() const {
    Estimate result;
    const double n = count_;
    for (std::size_t i = 0; i < sum_.size(); ++i) {
      const double mean = sum_[i] / n;
      result.mean.push_back(mean);
      result.variance.push_back(std::max(0.0, squares_[i] / n - mean * mean) / (n - 1));
      result.samples.push_back(samples_[i]);
    }
    return result;
  }

 private:
  std::mutex mutex_;
  std::vector<double> sum_, squares_, samples_;
  int count_ = 0;
};

template <class Work>
void on_all_cores(std::uint32_t count, const Work& work) {
  std::atomic<std::uint32_t> next{0};
  std::vector<std::jthread> threads;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) {
    threads.emplace_back([&] {
      for (std::uint32_t k; (k = next.fetch_add(1)) < count;) work(k);
    });
  }
}

class FewSamples : public testing::TestWithParam<const char*> {
 protected:
  static Size size() { return long_form() ? kLong : kShort; }

  static absl::StatusOr<LoadedFile> load(std::uint32_t spp, std::uint64_t seed, double noise = 0) {
    test::SceneJob job;
    job.width = size().side;
    job.height = size().side;
    job.settings.set_spp(spp);
    job.settings.set_seed(seed);
    job.settings.set_noise(noise);
    return load_scene_file(GetParam(), job, render::supported_isas().front(), 1);
  }

  /// Returns how many samples were taken.
  static std::uint64_t add(const LoadedFile& file, std::uint32_t first, std::uint32_t samples,
                           Accumulator& sum) {
    const MadePhases phases = make_phases(file, {.threads = 1});
    render::RenderStats stats;
    const auto tile = file.scene->render_tile(
        {0, 0, size().side, size().side, first, first + samples, 0, phases.prepared.get()}, {}, stats);
    EXPECT_TRUE(tile.ok()) << tile.status();
    EXPECT_EQ(stats.dropped_samples, 0u);
    if (tile.ok()) sum.add(*tile);
    return stats.samples;
  }

  static void add_many(Accumulator& sum) {
    const Size s = size();
    const auto file = load(s.many, 1);
    ASSERT_TRUE(file.ok()) << file.status();
    on_all_cores(kBatches,
                 [&](std::uint32_t i) { add(*file, i * (s.many / kBatches), s.many / kBatches, sum); });
  }

  static std::size_t values() { return std::size_t{3} * size().side * size().side; }
};

/// The mean of all values from `first` on, `count` of them, and its standard error. Pixels of one render are
/// independent.
struct Mean {
  double value = 0, error = 0;
};
Mean mean_of(const Estimate& e, std::size_t first, std::size_t count) {
  Mean mean;
  for (std::size_t i = first; i < first + count; ++i) {
    mean.value += e.mean[i] / static_cast<double>(count);
    mean.error += e.variance[i];
  }
  mean.error = std::sqrt(mean.error) / static_cast<double>(count);
  return mean;
}

/// The mean of `few`, and every pixel of it, against `many`.
void expect_the_mean_of(const Accumulator& few, const Accumulator& many, std::size_t values) {
  const Estimate a = few.estimate(), b = many.estimate();

  const std::size_t pixels = values / 3;
  for (std::size_t c = 0; c < 3; ++c) {
    const Mean of_few = mean_of(a, c * pixels, pixels), of_many = mean_of(b, c * pixels, pixels);
    const double error = std::hypot(of_few.error, of_many.error);
    testing::Test::RecordProperty("bias_percent_" + std::to_string(c),
                                  std::to_string(100 * (of_few.value / of_many.value - 1)));
    testing::Test::RecordProperty("error_percent_" + std::to_string(c),
                                  std::to_string(100 * error / of_many.value));
    // Four standard errors: one channel in 16,000. Beyond 0.1 % only as far as the noise reaches.
    EXPECT_NEAR(of_few.value, of_many.value, std::max(1e-3 * of_many.value, 4 * error))
        << "channel " << c << ", standard error " << error;
    if (long_form()) {
      // At most 0.12 %, but for Veach's small bright lamps: 0.6 %.
      EXPECT_LT(error, 1e-2 * of_many.value) << "too noisy to tell anything";
    }
  }

  // Every pixel by itself, with no floor under its variance: a pixel without any must be right to the
  // rounding of its sums.
  double sum_of_squares = 0;
  std::size_t tested = 0, wrong = 0;
  for (std::size_t i = 0; i < values; ++i) {
    // Where bright paths are rare, few samples may have met none, and then know neither of them nor of the
    // variance that they make: what many samples know counts, scaled to as many as those.
    const double of_few = std::max(a.variance[i], b.variance[i] * b.samples[i] / a.samples[i]);
    const double difference = a.mean[i] - b.mean[i], variance = of_few + b.variance[i];
    if (variance <= 1e-12 * b.mean[i] * b.mean[i]) {
      wrong += std::abs(difference) > 1e-5 * std::abs(b.mean[i]);
      continue;
    }
    sum_of_squares += difference * difference / variance;
    ++tested;
  }
  EXPECT_EQ(wrong, 0u) << "of the pixels that do not vary";
  ASSERT_GT(tested, values / 4);
  // Squares of normal z have mean 1 and variance 2; channels of a pixel go together, so as if there were a
  // third of them. The variance of many, from ranges of one low-discrepancy sequence, is above the true one:
  // only too large a sum is a fault.
  const double mean_square = sum_of_squares / static_cast<double>(tested);
  testing::Test::RecordProperty("mean_square_of_z", std::to_string(mean_square));
  EXPECT_LT(mean_square, 1 + 5 * std::sqrt(2.0 * 3 / static_cast<double>(tested)));
}

TEST_P(FewSamples, HaveTheMeanOfMany) {
  if (!std::filesystem::exists(GetParam())) GTEST_SKIP() << needs(GetParam());
  const Size s = size();
  Accumulator few(values()), many(values());
  on_all_cores(s.renders, [&](std::uint32_t i) {
    const auto file = load(s.few, 1000 + i);
    ASSERT_TRUE(file.ok()) << file.status();
    add(*file, 0, s.few, few);
  });
  add_many(many);
  expect_the_mean_of(few, many, values());
}

TEST_P(FewSamples, AsManyAsNoiseAsksForHaveTheMeanOfMany) {
  if (!std::filesystem::exists(GetParam())) GTEST_SKIP() << needs(GetParam());
  const Size s = size();
  Accumulator many(values());
  std::optional<Accumulator> few;
  std::atomic<std::uint64_t> taken{0};
  const std::uint64_t all = std::uint64_t{s.side} * s.side * (s.renders / 2) * 8 * s.few;
  // Some pixels are to stop early, and some not: scenes of little noise are asked for less.
  for (double noise = 0.2; taken <= all / 8 && noise > 0.005; noise /= 2) {
    taken = 0;
    few.emplace(values());
    on_all_cores(s.renders / 2, [&](std::uint32_t i) {
      const auto file = load(8 * s.few, 2000 + i, noise);
      ASSERT_TRUE(file.ok()) << file.status();
      taken += add(*file, 0, 8 * s.few, *few);
    });
  }
  EXPECT_GT(taken, all / 8);
  EXPECT_LT(taken, all);
  add_many(many);
  expect_the_mean_of(*few, many, values());
}

INSTANTIATE_TEST_SUITE_P(Scenes, FewSamples,
                         testing::Values("scenes/cornell-box/scene.pbrt",
                                         "scenes/first-light/scene.textproto",
                                         "tests/statistical/unbiased/scenes/media.textproto",
                                         "tests/statistical/unbiased/scenes/lens.textproto",
                                         "../shared/scenes/pbrt/veach-mis/scene.pbrt",
                                         "../shared/scenes/mitsuba/cornell-box/scene.xml"),
                         [](const auto& tested) {
                           const std::filesystem::path path(tested.param);
                           const std::filesystem::path own =
                               path.stem() == "scene" ? path.parent_path().filename() : path.stem();
                           std::string name = own.string() + "_" + path.extension().string().substr(1);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace tessera::test
