// Chains of Metropolis light transport by themselves, on a function of random numbers whose integral is
// known: what a family brings to the film is unbiased, however short its chains are.
#include "render/transport/mlt/chains.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr int kDeep = 38;  // some of its numbers are none of the coordinates
static_assert(kDeep > kMutatedEvents + 2);

/// Light of some ways, which is where a number is large, and none in a third of the space.
class ToyPathSpace final : public PathSpace {
 public:
  static constexpr int kPower = 8;
  static constexpr float kDark = 0.3f;

  /// All light of the paths of so many events that are made with `s` vertices from the light.
  static double light_of(int events, int s) {
    if (events == kDeep) return 0.5 / (kDeep + 2);
    return events > 3 ? 0 : (s + 1) * 0.5 / events;
  }

  int ways(int events) const override { return events + 2; }
  int max_events() const override { return kDeep; }
  bool asks_for(int place) const override { return place != kFlightPlace; }

  Wavelengths wavelengths(const PathBatch&, int) const override { return {}; }
  const Response& response() const override { return response_; }
  void make(PathBatch& batch) override {
    for (int slot = 0; slot < batch.count; slot += kWidth) {
      const PrimaryNumbers numbers(batch, slot / kWidth);
      for (int i = slot; i < std::min(slot + kWidth, batch.count); ++i) {
        const int events = batch.events[i], s = batch.from_light[i], t = batch.from_eye[i], lane = i - slot;
        EXPECT_EQ(s + t, events + 2);
        // The way that is furthest from the eye finds its place by a number of the light's.
        const int place = t >= 2 ? dimension::kFilm
                                 : dimension::kFirstLightEvent + (s - 2) * dimension::kPairsPerLightEvent +
                                       dimension::kJoinLens;
        const int other =
            t >= 2 ? dimension::kFirstEvent + (t - 2) * dimension::kPairsPerEvent : dimension::kEmitter;
        const Vec2 u = numbers.get_2d(place), v = numbers.get_2d(other);
        const float x = u.x.lane(lane), y = u.y.lane(lane), z = v.x.lane(lane);
        const float bright = (kPower + 1) * std::pow(x, kPower) * 2 * z;
        const float value =
            y < kDark ? 0 : bright * static_cast<float>(light_of(events, s) * ways(events)) / (1 - kDark);
        batch.film_x[i] = x;
        batch.film_y[i] = y;
        batch.light.c[0][i] = value;
        batch.light.c[1][i] = value * 2 * y;
        for (int c = 2; c < kSpectrumLanes; ++c) batch.light.c[c][i] = 0.5f * value;
      }
    }
  }

 private:
  const Response response_;
};

/// Light on the film's left and right half, by bands.
class Halves final : public Film {
 public:
  FilmRect rect() const override { return {0, 0, 1, 1}; }
  void add(std::span<const SampleName>, const float*, std::size_t) override { std::abort(); }
  void splat(std::span<const Splat> splats) override {
    for (const Splat& splat : splats) {
      for (std::size_t band = 0; band < 3; ++band)
        sums[splat.x < kMiddle ? 0 : 1][band] += static_cast<double>(splat.value[band]);
    }
  }
  static constexpr float kMiddle = 0.8f;
  std::array<std::array<double, 3>, 2> sums = {};
};

std::array<std::array<double, 3>, 2> expected() {
  double all = 0;
  for (int events = 1; events <= kDeep; ++events) {
    for (int s = 0; s < events + 2; ++s) all += ToyPathSpace::light_of(events, s);
  }
  const double left = std::pow(static_cast<double>(Halves::kMiddle), ToyPathSpace::kPower + 1);
  const double mean_y = (1 + static_cast<double>(ToyPathSpace::kDark)) / 2;
  std::array<std::array<double, 3>, 2> result;
  for (std::size_t half = 0; half < 2; ++half) {
    const double red = all * (half == 0 ? left : 1 - left);
    result[half] = {red, red * 2 * mean_y, 0.5 * red};
  }
  return result;
}

void expect_unbiased(const MetropolisSettings& config, std::uint64_t seed, std::uint32_t families) {
  ToyPathSpace toy;
  RenderStats stats;
  Chains chains(toy, config, stats);
  std::array<std::array<double, 3>, 2> sum = {}, squares = {};
  for (std::uint32_t family = 0; family < families; ++family) {
    Halves film;
    ASSERT_TRUE(chains.run({seed, family, 0}, 1, film, {}));
    for (std::size_t half = 0; half < 2; ++half) {
      for (std::size_t band = 0; band < 3; ++band) {
        sum[half][band] += film.sums[half][band];
        squares[half][band] += film.sums[half][band] * film.sums[half][band];
      }
    }
  }
  EXPECT_EQ(stats.mutations, std::uint64_t{families} * kChains * config.mutations);
  const auto right = expected();
  for (std::size_t half = 0; half < 2; ++half) {
    for (std::size_t band = 0; band < 3; ++band) {
      const double mean = sum[half][band] / families, variance = squares[half][band] / families - mean * mean,
                   error = std::sqrt(variance / (families - 1));
      // Six standard errors of 100 values and more: one comparison in 10^7, and there are 120.
      EXPECT_NEAR(mean, right[half][band], 6 * error)
          << config.mutations << " mutations, " << config.candidates << " candidates, seed " << seed
          << ", half " << half << ", band " << band;
      // A seventh of it would be seen anywhere, and much less in most comparisons.
      EXPECT_LT(error, right[half][band] / 42);
    }
  }
}

TEST(Chains, AreUnbiasedHoweverShort) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    expect_unbiased({.mutations = 1, .candidates = 1}, seed, 3000);
    expect_unbiased({.mutations = 1, .candidates = 8}, seed, 500);
    expect_unbiased({.mutations = 4, .candidates = 2}, seed, 1000);
    expect_unbiased({.mutations = 64, .candidates = 2}, seed, 500);
  }
}

TEST(Chains, AreUnbiasedWithStepsOfAnySize) {
  expect_unbiased({.mutations = 16, .candidates = 4, .large_steps = 1}, 4, 400);
  expect_unbiased({.mutations = 16, .candidates = 4, .large_steps = 0.01f}, 5, 600);
  expect_unbiased({.mutations = 16, .candidates = 4, .step = 0.5f}, 6, 400);
}

/// The mean of all families is right whatever they begin with; so is each family's light where chains are
/// long, but for the light of its candidates: halves are as bright against each other as they should be.
TEST(Chains, ForgetWhereTheyBegan) {
  ToyPathSpace toy;
  RenderStats stats;
  Chains chains(toy, {.mutations = 4096, .candidates = 16}, stats);
  Halves film;
  ASSERT_TRUE(chains.run({11, 0, 0}, 1, film, {}));
  const auto right = expected();
  for (std::size_t band = 0; band < 3; ++band) {
    EXPECT_NEAR(film.sums[0][band] / (film.sums[0][band] + film.sums[1][band]),
                right[0][band] / (right[0][band] + right[1][band]), 0.01);
  }
}

TEST(Chains, AreTheSameWheneverTheyRun) {
  ToyPathSpace toy;
  RenderStats stats;
  Chains chains(toy, {.mutations = 8, .candidates = 2}, stats),
      others(toy, {.mutations = 8, .candidates = 2}, stats);
  Halves once, again, another;
  ASSERT_TRUE(chains.run({1, 5, 2}, 1, once, {}));
  ASSERT_TRUE(others.run({1, 4, 2}, 1, another, {}));
  ASSERT_TRUE(others.run({1, 5, 2}, 1, again, {}));
  EXPECT_EQ(once.sums, again.sums);
  EXPECT_NE(once.sums, another.sums);
}

/// Large steps of the depths' distribution, which all candidates are of.
TEST(Chains, DepthsAreChosenAsLikelyAsTheySay) {
  for (const int most : {1, 2, 5, 100, 32767}) {
    const DepthChoice depths(most);
    double sum = 0;
    for (int events = 1; events <= most; ++events) sum += depths.probability(events);
    EXPECT_NEAR(sum, 1, 1e-9);
    constexpr int kTries = 100000;
    std::vector<int> found(static_cast<std::size_t>(most) + 1);
    std::vector<double> rest(static_cast<std::size_t>(most) + 1);
    for (int i = 0; i < kTries; ++i) {
      const DepthChoice::Choice choice = depths.choose((i + 0.5) / kTries);
      ASSERT_GE(choice.events, 1);
      ASSERT_LE(choice.events, most);
      ++found[static_cast<std::size_t>(choice.events)];
      rest[static_cast<std::size_t>(choice.events)] += static_cast<double>(choice.rest);
    }
    for (int events = 1; events <= std::min(most, 20); ++events) {
      const auto n = static_cast<std::size_t>(events);
      // Evenly spaced numbers: each count is off by one at most, and the mean of the rests by half of a step.
      EXPECT_NEAR(found[n], kTries * depths.probability(events), 1.001);
      EXPECT_NEAR(rest[n] / found[n], 0.5, 1.0 / found[n] + 1e-4);
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
