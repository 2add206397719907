// Where work comes from and light goes: tiles of fixed counts, and passes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>
#include <vector>

#include "render/film/fixed_tile.h"
#include "render/film/pass_film.h"
#include "wire/aov_channels.h"

namespace tessera::render {
namespace {

wire::TileResult empty_result(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1,
                              std::uint32_t begin, std::uint32_t end) {
  wire::TileResult result;
  result.x0 = x0, result.y0 = y0, result.x1 = x1, result.y1 = y1;
  result.sample_begin = begin, result.sample_end = end;
  result.channels = wire::channels_for_aovs({v1::AOV_VARIANCE});
  return result;
}

/// Value of a sample in R; the other channels are multiples of it.
float shade(const SampleName& name) {
  return 1.0f / static_cast<float>(1 + name.x + 7 * name.y + 31 * name.index);
}

/// All that `source` asks for, in batches of that size at most.
template <class SourceAndFilm>
std::vector<SampleName> render_all(SourceAndFilm& film, std::size_t batch) {
  std::vector<SampleName> all, names(batch);
  std::vector<float> planes(4 * batch);
  while (const std::size_t count = film.next(names)) {
    for (std::size_t i = 0; i < count; ++i) {
      all.push_back(names[i]);
      for (std::size_t c = 0; c < 4; ++c) planes[c * batch + i] = static_cast<float>(c + 1) * shade(names[i]);
    }
    film.add(std::span(names).first(count), planes.data(), batch);
  }
  return all;
}

TEST(FixedTile, TakesEverySampleOnceAndSumsTheSameBitsInAnyBatch) {
  std::vector<float> expected;
  for (const std::size_t batch : {16u, 100u, 1024u}) {
    wire::TileResult result = empty_result(3, 5, 20, 16, 8, 21);
    FixedTile film(result);
    std::map<std::tuple<std::uint32_t, std::uint32_t>, std::uint32_t> next;  // sample of each pixel
    for (const SampleName& name : render_all(film, batch)) {
      ASSERT_TRUE(name.x >= 3 && name.x < 20 && name.y >= 5 && name.y < 16 && name.stream == 0);
      EXPECT_EQ(name.index, 8 + next[std::tuple(name.x, name.y)]++);
    }
    EXPECT_EQ(next.size(), result.pixel_count());
    for (const auto& [pixel, samples] : next) EXPECT_EQ(samples, 13u);
    for (const std::uint32_t count : result.counts) EXPECT_EQ(count, 13u);
    if (expected.empty()) expected = result.values;
    EXPECT_EQ(result.values, expected) << "batches of " << batch;
  }
}

TEST(FixedTile, APixelIsTheSumOfItsSamples) {
  wire::TileResult result = empty_result(3, 5, 20, 16, 0, 6);
  FixedTile film(result);
  render_all(film, 1024);
  for (std::uint32_t y = 5; y < 16; ++y) {
    for (std::uint32_t x = 3; x < 20; ++x) {
      double sum = 0;
      for (std::uint32_t s = 0; s < 6; ++s) sum += static_cast<double>(shade({x, y, s, 0}));
      const std::size_t pixel = std::size_t{y - 5} * 17 + (x - 3);
      EXPECT_NEAR(result.values[pixel], sum, 6 * 6e-8 * sum);  // a rounding a sum
      EXPECT_NEAR(result.values[result.pixel_count() + pixel], 2 * sum, 6 * 12e-8 * sum);
    }
  }
}

TEST(PassFilm, APassIsOneSampleOfEveryPixelWithAllThatLands) {
  wire::TileResult result = empty_result(2, 1, 6, 4, 4, 7);
  const PixelFilterRecord filter = PixelFilterRecord::build({});  // a box of one pixel
  PassFilm film(result, filter);
  for (std::uint32_t pass = 4; pass < 7; ++pass) {
    ASSERT_TRUE(film.begin_pass());
    EXPECT_EQ(film.pass(), pass);
    const std::vector<SampleName> names = render_all(film, 5);
    EXPECT_EQ(names.size(), result.pixel_count());
    for (const SampleName& name : names) EXPECT_EQ(name.index, pass);
    // On pixel (3, 2), and beside the rectangle.
    const Splat splats[] = {{3.5f, 2.5f, {1, 2, 4}}, {1.5f, 2.5f, {8, 8, 8}}, {3.5f, 4.5f, {8, 8, 8}}};
    film.splat(splats);
    film.end_pass();
  }
  EXPECT_FALSE(film.begin_pass());
  for (std::uint32_t y = 1; y < 4; ++y) {
    for (std::uint32_t x = 2; x < 6; ++x) {
      const std::size_t pixel = std::size_t{y - 1} * 4 + (x - 2);
      EXPECT_EQ(result.counts[pixel], 3u);
      double sum = 0;
      for (std::uint32_t pass = 4; pass < 7; ++pass) sum += static_cast<double>(shade({x, y, pass, 0}));
      for (std::size_t c = 0; c < 3; ++c) {
        const double landed = x == 3 && y == 2 ? 3.0 * (1 << c) : 0.0;
        const double expected = static_cast<double>(c + 1) * sum + landed;
        EXPECT_NEAR(result.values[c * result.pixel_count() + pixel], expected, 6 * 6e-8 * expected);
      }
    }
  }
}

TEST(PassFilm, AFilterSpreadsWhatLandsAndKeepsItsSum) {
  FilterSpec spec;
  spec.kind = FilterKind::kTriangle;
  spec.radius_x = spec.radius_y = 2;
  const PixelFilterRecord filter = PixelFilterRecord::build(spec);
  wire::TileResult result = empty_result(0, 0, 8, 8, 0, 1);
  PassFilm film(result, filter);
  ASSERT_TRUE(film.begin_pass());
  const Splat splat{4.25f, 3.5f, {1, 1, 1}};
  film.splat({&splat, 1});
  film.end_pass();
  const float sum = std::accumulate(result.values.begin(), result.values.begin() + 64, 0.0f);
  EXPECT_NEAR(sum, 1, 1e-6);  // a triangle of radius 2 sums to 1 over unit steps
  EXPECT_GT(result.values[3 * 8 + 3], result.values[3 * 8 + 2]);
  EXPECT_EQ(result.values[3 * 8 + 7], 0);
}

/// Places beyond the edge are held to the maps' own rules.
TEST(RasterEdges, PlacesBeyondTheEdgeSeeWhatThePlaceWithinSees) {
  constexpr FilmSize kRaster{16, 8};
  // A direction of a globe, which is the same for any place that shows it.
  const auto on_globe = [](RasterPlace place) {
    const double longitude = place.x / 16 * 2 * std::numbers::pi, latitude = place.y / 8 * std::numbers::pi;
    return std::array{std::sin(latitude) * std::cos(longitude), std::cos(latitude),
                      std::sin(latitude) * std::sin(longitude)};
  };
  int found = 0;
  for (float x = 0.25f; x < 16; x += 0.5f) {
    for (float y = 0.25f; y < 8; y += 0.5f) {
      const RasterPlace place{x, y};
      EXPECT_TRUE(places_beyond(RasterEdges::kOpen, kRaster, place, 3, 2).empty());
      for (const RasterPlace& other : places_beyond(RasterEdges::kOverPole, kRaster, place, 3, 2)) {
        ++found;
        for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(on_globe(other)[i], on_globe(place)[i], 1e-6);
        EXPECT_TRUE(other.x < 0 || other.x > 16 || other.y < 0 || other.y > 8);
        EXPECT_TRUE(other.x > -3 && other.x < 19 && other.y > -2 && other.y < 10);
      }
      for (const RasterPlace& other : places_beyond(RasterEdges::kRound, kRaster, place, 3, 2)) {
        EXPECT_EQ(other.y, y);
        EXPECT_EQ(std::abs(other.x - x), 16);
      }
      for (const RasterPlace& other : places_beyond(RasterEdges::kMirrored, kRaster, place, 3, 2)) {
        EXPECT_EQ(16 - std::abs(16 - std::abs(other.x)), x);
        EXPECT_EQ(8 - std::abs(8 - std::abs(other.y)), y);
      }
    }
  }
  // Every quarter pixel of the border once: its area, of (16 + 6) x (8 + 4) pixels without the raster.
  EXPECT_EQ(found, 4 * (22 * 12 - 16 * 8));
}

TEST(PassFilm, AFilmWithoutAnEdgeKeepsAllThatLandsAtIt) {
  FilterSpec spec;
  spec.kind = FilterKind::kTriangle;
  spec.radius_x = spec.radius_y = 2;
  const PixelFilterRecord filter = PixelFilterRecord::build(spec);
  for (const RasterEdges edges : {RasterEdges::kOverPole, RasterEdges::kMirrored}) {
    wire::TileResult result = empty_result(0, 0, 8, 8, 0, 1);
    PassFilm film(result, filter, 0, 0, edges, {8, 8});
    ASSERT_TRUE(film.begin_pass());
    const Splat splats[] = {{0.25f, 0.5f, {1, 1, 1}}, {7.75f, 7.125f, {1, 1, 1}}};
    film.splat(splats);
    film.end_pass();
    EXPECT_NEAR(std::accumulate(result.values.begin(), result.values.begin() + 64, 0.0f), 2, 2e-6);
  }
}

}  // namespace
}  // namespace tessera::render
