// Alias tables and two-dimensional distributions: what is built, and what the kernels sample from it.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "render/sampling/discrete.h"
#include "render/sampling/piecewise2d_sample.h"
#include "support/kernel/chi2.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Probability of each outcome as the two columns of the table give it.
std::vector<double> probabilities(const AliasTable& table) {
  std::vector<double> p(table.pmf.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    p[i] += table.threshold[i];
    p[static_cast<std::size_t>(table.alias[i])] += 1.0 - table.threshold[i];
  }
  for (double& x : p) x /= static_cast<double>(p.size());
  return p;
}

void expect_distribution(std::span<const double> weights, std::span<const double> expected) {
  const AliasTable table = AliasTable::build(weights);
  const std::vector<double> actual = probabilities(table);
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    // Thresholds are floats: 2^-25 a bin, and an outcome may be the alias of every bin.
    EXPECT_NEAR(actual[i], expected[i], 0x1p-24) << i;
    EXPECT_NEAR(table.pmf[i], expected[i], 0x1p-24 * expected[i]) << i;
  }
}

TEST(AliasTable, HoldsTheWeights) {
  expect_distribution(std::vector<double>{1, 2, 3, 4}, std::vector<double>{0.1, 0.2, 0.3, 0.4});
  expect_distribution(std::vector<double>{5}, std::vector<double>{1});
  expect_distribution(std::vector<double>{0, 1, 0}, std::vector<double>{0, 1, 0});
}

TEST(AliasTable, SurvivesStrangeWeights) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  expect_distribution(std::vector<double>{nan, 1, -3, inf, 1}, std::vector<double>{0, 0.5, 0, 0, 0.5});
  expect_distribution(std::vector<double>{0, 0}, std::vector<double>{0.5, 0.5});
  expect_distribution(std::vector<double>{1e308, 1e308}, std::vector<double>{0.5, 0.5});
  expect_distribution(std::vector<double>{1e-300, 3e-300}, std::vector<double>{0.25, 0.75});
  EXPECT_TRUE(AliasTable::build({}).pmf.empty());
}

TEST(AliasTable, HoldsManyWeights) {
  std::mt19937 random(1);
  std::vector<double> weights(10000), expected(10000);
  double sum = 0;
  for (double& w : weights) sum += w = std::pow(10.0, static_cast<double>(random() % 1000) / 100 - 5);
  for (std::size_t i = 0; i < weights.size(); ++i) expected[i] = weights[i] / sum;
  expect_distribution(weights, expected);
}

/// All numbers k / n + 1 / 2n, 16 at a time.
template <class F>
void for_each_u(int n, F&& f) {
  for (int i = 0; i < n; i += kWidth) f((to_float(Int::iota(i)) + 0.5f) * (1.0f / static_cast<float>(n)));
}

TEST(DiscreteSample, FollowsTheTableAndReusesTheNumber) {
  const std::vector<double> weights = {1, 0, 5, 0.5, 3, 0.01, 2};
  const AliasTable table = AliasTable::build(weights);
  constexpr int kN = 1 << 16, kBins = 8;
  std::vector<std::vector<int>> counts(weights.size(), std::vector<int>(kBins));
  for_each_u(kN, [&](Float u) {
    const DiscreteSample s = sample_discrete(table, u, Mask::all());
    for (int l = 0; l < kWidth; ++l) {
      const auto index = static_cast<std::size_t>(s.index.lane(l));
      ASSERT_EQ(s.pmf.lane(l), table.pmf[index]);
      ASSERT_GE(s.u.lane(l), 0);
      ASSERT_LT(s.u.lane(l), 1);
      ++counts[index][static_cast<std::size_t>(s.u.lane(l) * kBins)];
    }
  });
  double sum = 0;
  for (const double w : weights) sum += w;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    // Stratified numbers: each piece of the unit interval that leads to a bin is off by one count at most;
    // there are no more than one piece an entry of the table.
    for (const int count : counts[i]) EXPECT_NEAR(count, weights[i] / sum * kN / kBins, 8.0) << i;
  }
  EXPECT_EQ(counts[1], std::vector<int>(kBins, 0));
}

TEST(DiscreteSample, TakesTheEndsOfTheUnitInterval) {
  const AliasTable table = AliasTable::build(std::vector<double>{0, 1, 0, 2, 0});
  for (const float u : {0.0f, kOneMinusEpsilon}) {
    const int index = sample_discrete(table, Float(u), Mask::all()).index.lane(0);
    EXPECT_TRUE(index == 1 || index == 3) << index;
  }
}

std::vector<float> noisy_weights(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<float> weights(n);
  for (float& w : weights) w = random() % 3 == 0 ? 0.0f : static_cast<float>(random() % 1000);
  return weights;
}

TEST(Piecewise2d, IntegratesToOne) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {1, 9}, {16, 1}}) {
    const auto n = static_cast<std::size_t>(width * height);
    const Piecewise2d p = Piecewise2d::build(noisy_weights(n, 1), width, height);
    double sum = 0;
    for (const float d : p.density) sum += d;
    EXPECT_NEAR(sum / static_cast<double>(n), 1, 1e-6);
    EXPECT_EQ(p.marginal_cdf.front(), 0);
    EXPECT_EQ(p.marginal_cdf.back(), 1);
  }
}

TEST(Piecewise2d, IsUniformWithoutUsableWeights) {
  const Piecewise2d p = Piecewise2d::build(std::vector<float>{0, -1, std::nanf(""), INFINITY}, 2, 2);
  for (const float d : p.density) EXPECT_EQ(d, 1);
}

TEST(Piecewise2dSample, FollowsItsDensity) {
  constexpr int kWidthCells = 13, kHeightCells = 9, kN = 200000;
  std::vector<float> weights = noisy_weights(kWidthCells * kHeightCells, 2);
  std::fill(weights.begin() + 4 * kWidthCells, weights.begin() + 5 * kWidthCells, 0.0f);  // a row of nothing
  const Piecewise2d p = Piecewise2d::build(weights, kWidthCells, kHeightCells);
  // Cells are told apart by quarters, so that the place within a cell is tested too.
  std::vector<double> observed(4 * weights.size()), expected(observed.size());
  std::mt19937 random(3);
  const auto next = [&] {
    alignas(64) float u[kWidth];
    for (float& x : u) x = static_cast<float>(random() >> 8) * 0x1p-24f;
    return Float::load(u);
  };
  for (int i = 0; i < kN; i += kWidth) {
    const Piecewise2dSample s = sample_piecewise2d(p, {next(), next()}, Mask::all());
    const Float density = piecewise2d_density(p, s.uv, Mask::all());
    for (int l = 0; l < kWidth; ++l) {
      const float x = s.uv.x.lane(l) * kWidthCells, y = s.uv.y.lane(l) * kHeightCells;
      ASSERT_EQ(static_cast<int>(x), s.x.lane(l));
      ASSERT_EQ(static_cast<int>(y), s.y.lane(l));
      ASSERT_EQ(density.lane(l), s.density.lane(l));
      ASSERT_GT(s.density.lane(l), 0);
      const int quarter = 2 * (y - std::floor(y) >= 0.5f) + (x - std::floor(x) >= 0.5f);
      ++observed[static_cast<std::size_t>(4 * (s.y.lane(l) * kWidthCells + s.x.lane(l)) + quarter)];
    }
  }
  for (std::size_t i = 0; i < expected.size(); ++i)
    expected[i] = kN * p.density[i / 4] / (4.0 * static_cast<double>(weights.size()));
  EXPECT_GT(test::chi_square_test(observed, expected).p_value, 0.01);
}

TEST(Piecewise2dSample, NeverLeavesTheWeights) {
  // Weight in the first and last cells only, and numbers at the very ends.
  std::vector<float> weights(100, 0.0f);
  weights[11] = 1;
  weights[88] = 1;
  const Piecewise2d p = Piecewise2d::build(weights, 10, 10);
  for (const float v : {0.0f, 0.25f, 0.5f, kOneMinusEpsilon}) {
    for (const float u : {0.0f, 0.5f, kOneMinusEpsilon}) {
      const Piecewise2dSample s = sample_piecewise2d(p, {Float(u), Float(v)}, Mask::all());
      const int cell = s.y.lane(0) * 10 + s.x.lane(0);
      EXPECT_TRUE(cell == 11 || cell == 88) << u << " " << v << " " << cell;
      EXPECT_EQ(s.density.lane(0), 50);
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
