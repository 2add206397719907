#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "render/film/pixel_filter.h"
#include "render/film/tile_accumulator.h"
#include "wire/aov_channels.h"

namespace tessera::render {
namespace {

/// Samples [begin, end) of one pixel through an accumulator; sample i has the value values[i].
wire::TileResult accumulate(const std::vector<float>& values, std::uint32_t begin, std::uint32_t end) {
  wire::TileResult result;
  result.x1 = result.y1 = 1;
  result.sample_begin = begin;
  result.sample_end = end;
  result.channels = wire::channels_for_aovs({v1::AOV_VARIANCE});
  TileAccumulator film(result);
  const std::uint32_t pixel = 0;
  film.begin_pixels({&pixel, 1});
  for (std::uint32_t i = begin; i < end; ++i) {
    const float planes[4] = {values[i], -values[i], values[i] * values[i], 1};
    film.add_sample(planes, 1);
  }
  film.end_pixels();
  return result;
}

std::vector<float> random_values(std::size_t n) {
  std::mt19937 random(7);
  std::lognormal_distribution<float> distribution(0, 3);
  std::vector<float> values(n);
  for (float& v : values) v = distribution(random);
  return values;
}

TEST(TileAccumulator, AnyCutIntoNodesGivesTheSameBits) {
  for (const std::uint32_t spp : {1u, 2u, 3u, 7u, 16u, 50u, 100u, 127u}) {
    const auto values = random_values(spp);
    const wire::TileResult whole = accumulate(values, 0, spp);
    for (std::uint32_t unit = 1; unit < spp; unit *= 2) {
      std::vector<wire::TileResult> nodes;
      for (std::uint32_t begin = 0; begin < spp; begin += unit)
        nodes.push_back(accumulate(values, begin, std::min(begin + unit, spp)));
      // Merge siblings until one is left, right ones first to vary the order.
      while (nodes.size() > 1) {
        bool merged = false;
        for (std::size_t i = nodes.size() - 1; i > 0 && !merged; --i) {
          auto &left = nodes[i - 1], &right = nodes[i];
          if (!wire::are_siblings(left.sample_begin, left.sample_end, right.sample_begin, right.sample_end,
                                  spp))
            continue;
          wire::merge_pixel_nodes(left.channels, 1, left.counts.data(), left.values.data(), 1,
                                  right.counts.data(), right.values.data(), 1);
          left.sample_end = right.sample_end;
          nodes.erase(nodes.begin() + static_cast<std::ptrdiff_t>(i));
          merged = true;
        }
        ASSERT_TRUE(merged) << "no siblings among " << nodes.size() << " nodes of " << spp << " samples";
      }
      EXPECT_EQ(nodes[0].values, whole.values) << spp << " samples in units of " << unit;
      EXPECT_EQ(nodes[0].counts, whole.counts);
    }
  }
}

TEST(TileAccumulator, SumsAndDeviationsAreRight) {
  const auto values = random_values(1000);
  const wire::TileResult result = accumulate(values, 0, 1000);
  const double sum = std::accumulate(values.begin(), values.end(), 0.0), mean = sum / 1000;
  double m2 = 0;
  for (const float v : values) m2 += (v - mean) * (v - mean);
  ASSERT_EQ(result.channels[4].name, "variance.R");
  // Ten levels of one rounding each (2^-24) for the sum, a few more for the deviations.
  EXPECT_NEAR(result.values[0], sum, 1e-6 * sum);
  EXPECT_NEAR(result.values[4], m2, 1e-5 * m2);
  EXPECT_EQ(result.counts[0], 1000u);
}

TEST(PixelFilter, TablesHaveTheFiltersMoments) {
  for (const FilterKind kind : {FilterKind::kGaussian, FilterKind::kMitchell, FilterKind::kLanczos}) {
    FilterSpec spec;
    spec.kind = kind;
    spec.radius_x = spec.radius_y = kind == FilterKind::kLanczos ? 4.0f : 2.0f;
    const FilterAxis axis = PixelFilterRecord::build(spec).x;
    ASSERT_EQ(axis.cdf.size(), axis.weight.size() + 1);
    EXPECT_EQ(axis.cdf.front(), 0);
    EXPECT_EQ(axis.cdf.back(), 1);
    // The mean weight is 1: the filter keeps constants.
    double mean = 0;
    for (std::size_t i = 0; i < axis.weight.size(); ++i)
      mean += double{axis.weight[i]} * (axis.cdf[i + 1] - axis.cdf[i]);
    EXPECT_NEAR(mean, 1, 1e-5);
  }
}

}  // namespace
}  // namespace tessera::render
