// Samples that go into all pixels around.
#include "render/film/scatter_tile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "render/film/filter_value.h"
#include "render/film/fixed_tile.h"
#include "unit/render/film/pixel_groups.h"
#include "wire/aov_channels.h"

namespace tessera::render::scatter_tile_test {
namespace {

constexpr std::uint64_t kSeed = 5;

PixelFilterRecord filter_of(FilterKind kind, float radius) {
  FilterSpec spec;
  spec.kind = kind;
  spec.radius_x = spec.radius_y = radius;
  return PixelFilterRecord::build(spec);
}

/// The channels of a picture with variance and numbers.
wire::TileResult empty_result(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1,
                              std::uint32_t begin, std::uint32_t end) {
  wire::TileResult result;
  result.x0 = x0, result.y0 = y0, result.x1 = x1, result.y1 = y1;
  result.sample_begin = begin, result.sample_end = end;
  result.channels = wire::channels_for_aovs({v1::AOV_VARIANCE, v1::AOV_ID});
  return result;
}

/// R, G, B, A and two numbers of a sample.
constexpr std::size_t kPlanes = 6;
using Shade = float (*)(const SampleName& name, std::size_t plane);

float rough(const SampleName& name, std::size_t plane) {
  std::uint32_t h = name.x * 0x9e3779b9u ^ name.y * 0x85ebca6bu ^ name.index * 0xc2b2ae35u;
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  return static_cast<float>(plane + 1) * static_cast<float>(h >> 8) * 0x1p-24f;
}

float even(const SampleName&, std::size_t) { return 1; }

/// Renders all that is asked for, in batches of that size at most; returns how many samples there were.
template <class SourceAndFilm>
std::size_t render(SourceAndFilm& film, Shade shade, std::size_t batch = 1024) {
  std::vector<SampleName> names(batch);
  std::vector<float> planes(kPlanes * batch);
  std::size_t all = 0;
  while (const std::size_t count = film.next(names)) {
    all += count;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < kPlanes; ++c) planes[c * batch + i] = shade(names[i], c);
    film.add(std::span(names).first(count), planes.data(), batch);
  }
  return all;
}

wire::TileResult rendered(const PixelFilterRecord& filter, wire::TileResult result, Shade shade,
                          std::size_t batch = 1024) {
  ScatterTile film(result, &filter, kSeed);
  render(film, shade, batch);
  return result;
}

/// Where samples lie, by their numbers.
std::map<std::uint32_t, std::pair<float, float>> places_of(std::uint32_t samples) {
  wire::TileResult result = empty_result(0, 0, 1, 1, 0, samples);
  const PixelFilterRecord filter = filter_of(FilterKind::kBox, 0.5f);
  ScatterTile film(result, &filter, kSeed);
  std::map<std::uint32_t, std::pair<float, float>> places;
  std::vector<SampleName> names(16);
  const std::vector<float> planes(kPlanes * 16);
  while (const std::size_t count = film.next(names)) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t at = names[i].index - film.places()->first;
      places[names[i].index] = {film.places()->x[at], film.places()->y[at]};
    }
    film.add(std::span(names).first(count), planes.data(), 16);
  }
  return places;
}

TEST(ScatterTile, ReachesAsFarAsTheFilter) {
  const auto reach = [](float radius) { return filter_reach(filter_of(FilterKind::kTriangle, radius).x); };
  EXPECT_EQ(reach(0.3f), 0u);
  EXPECT_EQ(reach(0.5f), 0u);
  EXPECT_EQ(reach(0.6f), 1u);
  EXPECT_EQ(reach(1.5f), 1u);
  EXPECT_EQ(reach(2), 2u);
  EXPECT_EQ(reach(4), 4u);
}

/// The same as the definition: the sum over samples of all pixels around, each weighted by the filter.
TEST(ScatterTile, APixelIsTheWeightedSumOfTheSamplesAroundIt) {
  constexpr std::uint32_t kSamples = 6;
  const auto places = places_of(kSamples);
  for (const auto& [kind, radius] : {std::pair(FilterKind::kTriangle, 1.0f),
                                     {FilterKind::kGaussian, 1.5f},
                                     {FilterKind::kMitchell, 2.0f},
                                     {FilterKind::kLanczos, 4.0f},
                                     {FilterKind::kBox, 1.25f}}) {
    const PixelFilterRecord filter = filter_of(kind, radius);
    const wire::TileResult result = rendered(filter, empty_result(0, 2, 7, 7, 0, kSamples), rough);
    for (std::uint32_t y = 2; y < 7; ++y) {
      for (std::uint32_t x = 0; x < 7; ++x) {
        const std::size_t pixel = (y - 2) * 7 + x;
        EXPECT_EQ(result.counts[pixel], kSamples);
        double sum = 0, magnitude = 0, squares = 0;
        for (std::uint32_t s = 0; s < kSamples; ++s) {
          double leaf = 0;
          for (int dy = -5; dy <= 5; ++dy) {
            for (int dx = -5; dx <= 5; ++dx) {
              const SampleName name{x + static_cast<std::uint32_t>(dx), y + static_cast<std::uint32_t>(dy), s,
                                    0};
              const auto [u, v] = places.at(s);
              const double weight =
                  double{filter_value(kind, filter.x, static_cast<float>(dx) + (u - 0.5f))} *
                  double{filter_value(kind, filter.y, static_cast<float>(dy) + (v - 0.5f))};
              leaf += weight * double{rough(name, 0)};
              magnitude += std::abs(weight);
            }
          }
          sum += leaf, squares += leaf * leaf;
        }
        // Some 20 roundings of what is at most `magnitude`.
        EXPECT_NEAR(result.values[pixel], sum, 20 * 6e-8 * magnitude);
        const std::size_t variance = 4 * result.pixel_count() + pixel;
        EXPECT_NEAR(result.values[variance], squares - sum * sum / kSamples, 1e-5 * squares);
      }
    }
  }
}

/// Groups are of the film's grid, others for each sample number, whole, and one after the other. Samples may
/// go into several pixels or stay in their own.
TEST(ScatterTile, AsksForWholeGroupsOfNeighboursForTheSamePicture) {
  const PixelFilterRecord tent = filter_of(FilterKind::kTriangle, 2);
  const SampleCounts counts{{0, 0, 3, 2}, {8, 12, 8, 16, 8, 12}, false};
  constexpr FilmSize kSize{20, 14};
  for (const PixelFilterRecord* const filter : {static_cast<const PixelFilterRecord*>(nullptr), &tent}) {
    const std::uint32_t reach = filter == nullptr ? 0 : 2;
    for (const SampleCounts* const some : {static_cast<const SampleCounts*>(nullptr), &counts}) {
      wire::TileResult alone = empty_result(1, 2, 19, 13, 0, 16);
      ScatterTile single(alone, filter, kSeed, some);
      render(single, rough);
      for (const PixelGroup group : test::kGroups) {
        std::vector<test::GroupMap> groups;
        for (std::uint32_t number = 0; number < 16; ++number)
          groups.emplace_back(group, grid_of(group, kSeed, number));
        wire::TileResult result = empty_result(1, 2, 19, 13, 0, 16);
        ScatterTile film(result, filter, kSeed, some, group, kSize);
        EXPECT_EQ(film.group().count(), group.count());
        EXPECT_EQ(film.places() == nullptr, filter == nullptr);
        std::vector<SampleName> names(100);
        std::vector<float> planes(kPlanes * names.size());
        const auto whole = static_cast<std::size_t>(group.count());
        while (const std::size_t count = film.next(names)) {
          ASSERT_EQ(count % whole, 0u);
          for (std::size_t i = 0; i < count; ++i) {
            const SampleName& first = names[i / whole * whole];
            EXPECT_EQ(groups.at(first.index).of(names[i]), groups.at(first.index).of(first));
            EXPECT_EQ(names[i].index, first.index);
            const bool sampled = kSize.reaches(names[i].x, names[i].y, reach, reach);
            EXPECT_EQ(names[i].stream, sampled ? 0 : kUnsampled);
            for (std::size_t c = 0; c < kPlanes; ++c)
              planes[c * names.size() + i] = sampled ? rough(names[i], c) : std::nanf("");
          }
          film.add(std::span(names).first(count), planes.data(), names.size());
        }
        EXPECT_EQ(result.values, alone.values) << group.count();
        EXPECT_EQ(result.counts, alone.counts);
      }
    }
  }
}

/// The sums are those of FixedTile.
TEST(ScatterTile, WithoutAFilterAPixelHasItsOwnSamplesAlone) {
  wire::TileResult expected = empty_result(3, 5, 20, 16, 8, 21), result = expected;
  FixedTile fixed(expected);
  ScatterTile film(result, nullptr, kSeed, nullptr, {4, 4, 2}, {20, 17});
  render(fixed, rough);
  render(film, rough);
  EXPECT_EQ(result.values, expected.values);
  EXPECT_EQ(result.counts, expected.counts);
}

TEST(ScatterTile, TakesEverySampleOfTileAndBorderOnceInAnyBatch) {
  const PixelFilterRecord filter = filter_of(FilterKind::kTriangle, 2);
  std::vector<float> expected;
  for (const std::size_t batch : {5u, 100u, 1024u}) {
    wire::TileResult result = empty_result(0, 8, 17, 16, 8, 21);
    ScatterTile film(result, &filter, kSeed);
    EXPECT_EQ(render(film, rough, batch), 13u * (17 + 4) * (8 + 4));
    if (expected.empty()) expected = result.values;
    EXPECT_EQ(result.values, expected) << "batches of " << batch;
  }
}

TEST(ScatterTile, GivesTheSameBitsInAnyCut) {
  const PixelFilterRecord filter = filter_of(FilterKind::kMitchell, 2);
  constexpr std::uint32_t kSide = 21, kSamples = 13;
  const wire::TileResult whole = rendered(filter, empty_result(0, 0, kSide, kSide, 0, kSamples), rough);
  for (const std::uint32_t side : {1u, 8u, 13u}) {
    for (std::uint32_t y0 = 0; y0 < kSide; y0 += side) {
      for (std::uint32_t x0 = 0; x0 < kSide; x0 += side) {
        const std::uint32_t x1 = std::min(x0 + side, kSide), y1 = std::min(y0 + side, kSide);
        // In two nodes of the sum tree.
        wire::TileResult tile = rendered(filter, empty_result(x0, y0, x1, y1, 0, 8), rough);
        const wire::TileResult right = rendered(filter, empty_result(x0, y0, x1, y1, 8, kSamples), rough);
        wire::merge_pixel_nodes(tile.channels, tile.pixel_count(), tile.counts.data(), tile.values.data(),
                                tile.pixel_count(), right.counts.data(), right.values.data(),
                                tile.pixel_count());
        for (std::size_t c = 0; c < tile.channels.size(); ++c) {
          for (std::uint32_t y = y0; y < y1; ++y) {
            for (std::uint32_t x = x0; x < x1; ++x) {
              ASSERT_EQ(tile.values[c * tile.pixel_count() + (y - y0) * (x1 - x0) + (x - x0)],
                        whole.values[c * whole.pixel_count() + y * kSide + x])
                  << "tiles of " << side << ", channel " << c << ", pixel " << x << ' ' << y;
            }
          }
        }
      }
    }
  }
}

TEST(ScatterTile, WhatIsEvenStaysEven) {
  for (const auto& [kind, radius, ripple] :
       {std::tuple(FilterKind::kTriangle, 1.0f, 0.0f),
        {FilterKind::kTriangle, 2.0f, 0.0f},
        // Copies of a Gaussian add up to 1 within 2 exp(-2 pi^2 sigma^2), both ways, and what cutting it off
        // adds; with Mitchell's filter, all but for the bins that it is made of.
        {FilterKind::kGaussian, 1.5f, 0.06f},
        {FilterKind::kMitchell, 2.0f, 2e-4f}}) {
    const wire::TileResult result = rendered(filter_of(kind, radius), empty_result(0, 0, 9, 5, 3, 4), even);
    for (std::size_t i = 0; i < result.pixel_count(); ++i) {
      EXPECT_NEAR(result.values[i], 1, 1e-6 + ripple);
      // At borders of the film, too: what is beyond them is sampled.
      EXPECT_NEAR(result.values[i], result.values[0], 1e-6);
    }
  }
}

TEST(ScatterTile, NumbersAreThoseOfThePixelsFirstSample) {
  const wire::TileResult result =
      rendered(filter_of(FilterKind::kTriangle, 2), empty_result(3, 1, 9, 7, 4, 9), rough);
  for (std::uint32_t y = 1; y < 7; ++y) {
    for (std::uint32_t x = 3; x < 9; ++x) {
      for (const std::size_t number : {0u, 1u}) {
        EXPECT_EQ(result.values[(7 + number) * result.pixel_count() + (y - 1) * 6 + (x - 3)],
                  rough({x, y, 4, 0}, 4 + number));
      }
    }
  }
}

/// Every seed's places are as likely as others, and those of one are evenly spread.
TEST(ScatterTile, PlacesFillThePixel) {
  const auto places = places_of(256);
  EXPECT_EQ(places.size(), 256u);
  std::set<std::pair<int, int>> cells;
  for (const auto& [number, place] : places) {
    ASSERT_TRUE(place.first >= 0 && place.first < 1 && place.second >= 0 && place.second < 1);
    cells.emplace(static_cast<int>(8 * place.first), static_cast<int>(8 * place.second));
  }
  EXPECT_EQ(cells.size(), 64u);  // random places would leave one of 64 empty more often than not
}

}  // namespace
}  // namespace tessera::render::scatter_tile_test
