// Tiles whose pixels take different numbers of samples.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "base/split_mix.h"
#include "render/film/filter_value.h"
#include "render/film/fixed_tile.h"
#include "render/film/scatter_tile.h"
#include "wire/aov_channels.h"

namespace tessera::render::noise_counts_test {
namespace {

constexpr std::size_t kPlanes = 6;  // R, G, B, A, and two numbers

wire::TileResult empty_result(const FilmRect& rect, std::uint32_t samples) {
  wire::TileResult result;
  result.x0 = rect.x0, result.y0 = rect.y0, result.x1 = rect.x1, result.y1 = rect.y1;
  result.sample_end = samples;
  result.channels = wire::channels_for_aovs({v1::AOV_VARIANCE, v1::AOV_ID});
  return result;
}

PixelFilterRecord filter_of(FilterKind kind, float radius) {
  FilterSpec spec;
  spec.kind = kind;
  spec.radius_x = spec.radius_y = radius;
  return PixelFilterRecord::build(spec);
}

/// Blocks of a film of 40x32 pixels, next to each other in all ways.
SampleCounts uneven_counts() {
  SampleCounts counts{{0, 0, 5, 4}, {}};
  constexpr std::uint32_t kCounts[] = {4, 6, 4, 16, 6, 24, 4};
  for (std::uint32_t i = 0; i < 20; ++i) counts.counts.push_back(kCounts[i % 7]);
  return counts;
}

/// Value of a sample that lies at a place of its pixel.
using Shade = std::function<float(const SampleName&, float x, float y)>;

std::uint64_t hash(const SampleName& name, std::uint64_t seed) {
  return base::split_mix(
      base::split_mix(std::uint64_t{name.x} << 40 ^ std::uint64_t{name.y} << 16 ^ name.index) ^ seed);
}

Shade rough(std::uint64_t seed) {
  return [seed](const SampleName& name, float, float) {
    return static_cast<float>(hash(name, seed) >> 40) * 0x1p-24f;
  };
}

template <class Tile>
void render(Tile& film, const Shade& shade, std::size_t batch = 1024) {
  std::vector<SampleName> names(batch);
  std::vector<float> planes(kPlanes * batch);
  while (const std::size_t count = film.next(names)) {
    const CommonPlaces* const places = film.places();
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = places != nullptr ? names[i].index - places->first : 0;
      const float value =
          shade(names[i], places != nullptr ? places->x[at] : 0.5f, places != nullptr ? places->y[at] : 0.5f);
      for (std::size_t c = 0; c < kPlanes; ++c) planes[c * batch + i] = value * static_cast<float>(c + 1);
    }
    film.add(std::span(names).first(count), planes.data(), batch);
  }
}

wire::TileResult rendered(const FilmRect& rect, const SampleCounts* counts, const PixelFilterRecord* filter,
                          const Shade& shade, std::uint64_t seed = 5, std::size_t batch = 1024,
                          std::uint32_t samples = 64) {
  wire::TileResult result = empty_result(rect, samples);
  if (filter == nullptr) {
    FixedTile film(result, counts);
    render(film, shade, batch);
  } else {
    ScatterTile film(result, filter, seed, counts);
    render(film, shade, batch);
  }
  return result;
}

TEST(SampleCounts, TheSameBitsInEveryTileAndBatch) {
  const SampleCounts counts = uneven_counts();
  const PixelFilterRecord tent = filter_of(FilterKind::kTriangle, 1),
                          wide = filter_of(FilterKind::kMitchell, 4),
                          sinc = filter_of(FilterKind::kLanczos, 12);
  for (const PixelFilterRecord* const filter :
       {static_cast<const PixelFilterRecord*>(nullptr), &tent, &wide, &sinc}) {
    const wire::TileResult whole = rendered({0, 0, 40, 32}, &counts, filter, rough(1));
    for (const auto& [rect, batch] : {std::pair(FilmRect{0, 0, 8, 8}, std::size_t{1024}),
                                      {{8, 0, 32, 24}, 100},
                                      {{3, 5, 39, 31}, 7},
                                      {{33, 17, 34, 18}, 64}}) {
      const wire::TileResult part = rendered(rect, &counts, filter, rough(1), 5, batch);
      for (std::uint32_t y = rect.y0; y < rect.y1; ++y) {
        for (std::uint32_t x = rect.x0; x < rect.x1; ++x) {
          const std::size_t at = (y - rect.y0) * rect.width() + x - rect.x0, of = y * 40 + x;
          ASSERT_EQ(part.counts[at], counts.at(x, y));
          for (std::size_t c = 0; c < part.channels.size(); ++c)
            ASSERT_EQ(part.values[c * part.pixel_count() + at], whole.values[c * whole.pixel_count() + of])
                << x << ", " << y << ", " << part.channels[c].name;
        }
      }
    }
  }
}

TEST(SampleCounts, APixelIsTheSumOverPixelsAroundOfTheirMeans) {
  const SampleCounts counts = uneven_counts();
  const PixelFilterRecord filter = filter_of(FilterKind::kGaussian, 2);
  // Where samples lie.
  std::vector<std::pair<float, float>> places(64);
  rendered({0, 0, 40, 32}, &counts, &filter, [&](const SampleName& name, float x, float y) {
    places[name.index] = {x, y};
    return 0.0f;
  });
  const wire::TileResult result = rendered({0, 0, 40, 32}, &counts, &filter, rough(1));
  for (const auto& [px, py] : {std::pair(20u, 12u), {8u, 8u}, {7u, 15u}, {39u, 31u}, {0u, 16u}}) {
    double value = 0;
    for (int dy = -3; dy <= 3; ++dy) {
      for (int dx = -3; dx <= 3; ++dx) {
        SampleName q{px + static_cast<std::uint32_t>(dx), py + static_cast<std::uint32_t>(dy), 0, 0};
        const std::uint32_t n = counts.at(q.x, q.y);
        for (; q.index < n; ++q.index) {
          const auto [x, y] = places[q.index];
          value += double{filter_value(filter.kind, filter.x, static_cast<float>(dx) + x - 0.5f)} *
                   double{filter_value(filter.kind, filter.y, static_cast<float>(dy) + y - 0.5f)} *
                   double{rough(1)(q, x, y)} / n;
        }
      }
    }
    const std::size_t at = py * 40 + px;
    EXPECT_NEAR(result.values[at] / result.counts[at], value, 1e-5) << px << ", " << py;
    // The number is that of the pixel's own first sample.
    EXPECT_EQ(result.values[7 * result.pixel_count() + at], 5 * rough(1)({px, py, 0, 0}, 0, 0));
  }
}

TEST(SampleCounts, EqualOnesGiveThePictureOfATileWithout) {
  const SampleCounts counts{{0, 0, 1, 1}, {24}, /*even=*/true};
  const PixelFilterRecord tent = filter_of(FilterKind::kTriangle, 1);
  const FilmRect rect{0, 0, 20, 12};
  for (const PixelFilterRecord* const filter : {static_cast<const PixelFilterRecord*>(nullptr), &tent}) {
    const wire::TileResult with = rendered(rect, &counts, filter, rough(1)),
                           without = rendered(rect, nullptr, filter, rough(1), 5, 1024, 24);
    EXPECT_EQ(with.values, without.values);
    EXPECT_EQ(with.counts, without.counts);
  }
}

TEST(SampleCounts, WithoutBiasAtEdgesAndBordersOfBlocks) {
  // Light that ends within pixels, beside noise; many pictures, each with places of its own.
  const SampleCounts counts{{0, 0, 3, 1}, {4, 16, 6}};
  const PixelFilterRecord filter = filter_of(FilterKind::kTriangle, 1);
  constexpr int kPictures = 3000;
  constexpr std::uint32_t kWidth = 24;
  std::vector<double> sum(kWidth), squares(kWidth);
  double said = 0, spread = 0;
  for (int i = 0; i < kPictures; ++i) {
    const std::uint64_t seed = base::split_mix(static_cast<std::uint64_t>(i));
    const wire::TileResult result = rendered(
        {0, 3, kWidth, 4}, &counts, &filter,
        [&](const SampleName& name, float x, float) {
          const float lit = static_cast<float>(static_cast<std::int32_t>(name.x)) + x < 8.3f ? 1 : 0;
          return lit + (hash(name, seed) >> 60 == 0 ? 16.0f : 0.0f);
        },
        seed);
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      const double count = result.counts[x], value = result.values[x] / count;
      sum[x] += value, squares[x] += value * value;
      said += result.values[4 * kWidth + x] / (count - 1) / count / kPictures;
    }
  }
  double chi2 = 0;
  for (std::uint32_t x = 0; x < kWidth; ++x) {
    const double mean = sum[x] / kPictures, variance = squares[x] / kPictures - mean * mean;
    // The tent over what is lit, by its integral from the left; and 1 of noise.
    const double to = std::clamp(8.3 - (x + 0.5), -1.0, 1.0);
    const double lit = to < 0 ? (1 + to) * (1 + to) / 2 : 1 - (1 - to) * (1 - to) / 2;
    chi2 += (mean - lit - 1) * (mean - lit - 1) / (variance / kPictures);
    spread += variance;
  }
  // The sum has 24 degrees of freedom, a little fewer as neighbours share samples: beyond 60 in one of 20,000
  // seeds.
  EXPECT_LT(chi2, 60);
  RecordProperty("chi2", std::to_string(chi2));
  // The variance that is told: 72,000 values, whose own deviation is below twice their mean.
  EXPECT_NEAR(said / spread, 1, 0.04);
}

TEST(SampleCounts, NoLineShowsWhereTheyChange) {
  // Flat light at the least samples beside many, with a filter whose copies add up to 1.
  const SampleCounts counts{{0, 0, 2, 1}, {16, 64}};
  const PixelFilterRecord filter = filter_of(FilterKind::kTriangle, 1);
  double squares = 0;
  constexpr int kSeeds = 400;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const wire::TileResult result = rendered(
        {0, 0, 16, 1}, &counts, &filter, [](const SampleName&, float, float) { return 1.0f; },
        base::split_mix(seed));
    for (std::uint32_t x = 0; x < 16; ++x) {
      const double off = double{result.values[x]} / result.counts[x] - 1;
      if (x == 7 || x == 8) {
        squares += off * off / (2 * kSeeds);
      } else {
        EXPECT_NEAR(off, 0, 1e-6);
      }
    }
  }
  // Weights of half a pixel are means over 16 / 2 cells of samples that lie anywhere in theirs.
  EXPECT_LT(std::sqrt(squares), 0.005);
}

}  // namespace
}  // namespace tessera::render::noise_counts_test
