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
#include "support/picture/p_values.h"
#include "support/picture/phases.h"

namespace tessera::test {

namespace {

constexpr std::uint32_t kSide = 32, kBlock = 8, kBlocks = kSide / kBlock, kBatches = 32;
constexpr std::size_t kValues = 3 * (1 + kBlocks * kBlocks);
constexpr double kStandardErrors = 6;
constexpr std::uint32_t kSeeds = 4;
constexpr double kLevel = 1e-4;

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

/// Name of one of Picture::values.
std::string name_of(std::size_t v) {
  return absl::StrCat(v < 3 ? "whole picture" : absl::StrCat("block ", v / 3 - 1), ", channel ", v % 3);
}

Picture::Value difference(const Picture::Value& a, const Picture::Value& b) {
  return {a.mean - b.mean, std::hypot(a.error, b.error)};
}

using Values = std::vector<Picture::Value> Picture::*;

std::vector<Difference> differences_in(Values values, std::size_t first, const Pictures& a, const Pictures& b,
                                       double relative) {
  std::vector<Difference> result;
  EXPECT_TRUE(!a.empty() && a.size() == b.size());
  for (std::size_t seed = 0; seed < std::min(a.size(), b.size()); ++seed) {
    const auto &one = a[seed].*values, &other = b[seed].*values;
    EXPECT_TRUE(one.size() == other.size() && one.size() > first);
    result.resize(std::min(one.size(), other.size()) - first);
    for (std::size_t i = 0; i < result.size(); ++i) {
      const Picture::Value &x = one[first + i], &y = other[first + i];
      result[i].name = values == &Picture::values ? name_of(first + i) : absl::StrCat("channel ", first + i);
      result[i].by_seed.push_back(difference(x, y));
      result[i].allowed +=
          (relative * (std::abs(x.mean) + std::abs(y.mean)) / 2 + 1e-6) / static_cast<double>(a.size());
    }
  }
  return result;
}

/// P-value of the hypothesis that it is no larger than allowed. Pictures that differ in their seeds have one
/// standard error, which is that of all their batches: where few of these find a light, one picture alone may
/// have none that does.
double combined_p_value(const Difference& difference) {
  const std::size_t seeds = difference.by_seed.size();
  double variance = 0;
  for (const Picture::Value& value : difference.by_seed)
    variance += value.error * value.error / static_cast<double>(seeds);
  std::vector<double> p_values;
  for (const Picture::Value& value : difference.by_seed) {
    const double p = interval_p_value(value.mean, difference.allowed, std::sqrt(variance),
                                      static_cast<int>(seeds * (kBatches - 1)));
    p_values.push_back(std::isfinite(p) ? p : 0);
  }
  return fisher_p_value(p_values);
}

std::vector<double> adjusted_p_values(const std::vector<Difference>& differences) {
  std::vector<double> p_values;
  for (const Difference& difference : differences) p_values.push_back(combined_p_value(difference));
  return holm_adjusted(p_values);
}

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

Pictures measure_pictures(const PictureRequest& request) {
  Pictures pictures;
  PictureRequest one = request;
  one.spp = std::max(kBatches, request.spp / kSeeds);
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    one.seed = request.seed * kSeeds + seed;
    pictures.push_back(measure_picture(one));
  }
  return pictures;
}

std::vector<Difference> differences_of(const Pictures& a, const Pictures& b, double relative) {
  return differences_in(&Picture::values, 0, a, b, relative);
}

std::vector<Difference> channel_differences(const Pictures& a, const Pictures& b, std::size_t first,
                                            double relative) {
  return differences_in(&Picture::channels, first, a, b, relative);
}

Difference difference_from(const std::string& name, const std::vector<Picture::Value>& by_seed,
                           double expected, double relative) {
  Difference result{.name = name, .by_seed = by_seed, .allowed = relative * std::abs(expected) + 1e-6};
  for (Picture::Value& value : result.by_seed) value.mean -= expected;
  return result;
}

double p_value_of(const std::vector<Difference>& differences) {
  const std::vector<double> adjusted = adjusted_p_values(differences);
  return adjusted.empty() ? 0 : *std::ranges::min_element(adjusted);
}

void expect_none(const std::vector<Difference>& differences) {
  ASSERT_FALSE(differences.empty());
  const std::vector<double> adjusted = adjusted_p_values(differences);
  for (std::size_t i = 0; i < adjusted.size(); ++i) {
    if (adjusted[i] >= kLevel) continue;
    std::string seen;
    for (const Picture::Value& value : differences[i].by_seed)
      absl::StrAppend(&seen, " ", value.mean, " +- ", value.error);
    ADD_FAILURE() << differences[i].name << ": p = " << adjusted[i] << ", allowed " << differences[i].allowed
                  << ", by seed" << seen;
  }
}

void expect_same(const Pictures& a, const Pictures& b, double relative) {
  expect_none(differences_of(a, b, relative));
}

void expect_value(const Pictures& pictures, double expected, double relative) {
  Pictures known;
  for (const Picture& picture : pictures)
    known.push_back({std::vector<Picture::Value>(picture.values.size(), {expected, 0}), {}});
  expect_same(pictures, known, relative);
}

void expect_same(const Picture& a, const Picture& b, double relative) {
  ASSERT_EQ(a.values.size(), b.values.size());
  ASSERT_FALSE(a.values.empty());
  for (std::size_t v = 0; v < a.values.size(); ++v) {
    const double error = std::hypot(a.values[v].error, b.values[v].error);
    EXPECT_NEAR(a.values[v].mean, b.values[v].mean,
                kStandardErrors * error + relative * std::abs(a.values[v].mean) + 1e-6)
        << name_of(v) << ", standard error " << error;
  }
}

void expect_value(const Picture& picture, double expected, double relative) {
  ASSERT_FALSE(picture.values.empty());
  for (std::size_t v = 0; v < picture.values.size(); ++v) {
    EXPECT_NEAR(picture.values[v].mean, expected,
                kStandardErrors * picture.values[v].error + relative * std::abs(expected) + 1e-6)
        << name_of(v);
  }
}

}  // namespace tessera::test
