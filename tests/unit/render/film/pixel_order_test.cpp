#include "render/film/pixel_order.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "unit/render/film/pixel_groups.h"

namespace tessera::render {
namespace {

using Pixels = std::set<std::pair<std::uint32_t, std::uint32_t>>;

constexpr std::uint64_t kSeed = 5;

/// Groups as sets of pixels of the film, those of a border with numbers modulo 2^32.
std::set<Pixels> groups_of(std::uint32_t left, std::uint32_t top, std::uint32_t width, std::uint32_t height,
                           const PixelGroup& group, const GroupGrid& grid) {
  const std::vector<PixelPlace> places = groups_in(left, top, width, height, group, grid);
  const auto size = static_cast<std::size_t>(group.count());
  EXPECT_EQ(places.size() % size, 0u);
  std::set<Pixels> groups;
  for (std::size_t first = 0; first < places.size(); first += size) {
    Pixels pixels;
    for (std::size_t i = first; i < first + size; ++i) pixels.emplace(left + places[i].x, top + places[i].y);
    EXPECT_EQ(pixels.size(), size);
    EXPECT_TRUE(groups.insert(std::move(pixels)).second);
  }
  return groups;
}

TEST(PixelOrder, EveryPixelIsOfOneGroupWhateverTheRectangle) {
  for (const PixelGroup group : test::kGroups) {
    for (const GroupGrid grid : {GroupGrid{}, grid_of(group, kSeed, 0), grid_of(group, kSeed, 5)}) {
      const std::set<Pixels> all = groups_of(0 - 16u, 0 - 16u, 64, 64, group, grid);
      std::map<std::pair<std::uint32_t, std::uint32_t>, int> seen;
      for (const Pixels& pixels : all) {
        for (const auto& pixel : pixels) ++seen[pixel];
      }
      for (std::uint32_t i = 0; i < 64 * 64; ++i)
        EXPECT_EQ(seen[std::pair(i % 64 - 16, i / 64 - 16)], 1) << i;
      for (const std::uint32_t left : {0u, 3u, ~0u}) {
        for (const Pixels& pixels : groups_of(left, 5, 21, 10, group, grid))
          EXPECT_TRUE(all.contains(pixels));
      }
    }
  }
}

/// The same pixels come one after the other, in the same order, and none that are not needed.
TEST(PixelOrder, PacketsAreTheSameWhateverTheRectangle) {
  using Packet = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  for (const PixelGroup group : test::kGroups) {
    const std::size_t size = packet_of(group);
    EXPECT_EQ(size, group.step == 1 ? static_cast<std::size_t>(group.count()) : 16u);
    const GroupGrid grid = grid_of(group, kSeed, 3);
    const auto packets_of = [&](std::uint32_t left, std::uint32_t top, std::uint32_t width,
                                std::uint32_t height) {
      const std::vector<PixelPlace> places = groups_in(left, top, width, height, group, grid);
      EXPECT_EQ(places.size() % size, 0u);
      std::set<Packet> packets;
      for (std::size_t first = 0; first < places.size(); first += size) {
        Packet packet;
        bool any = false;
        for (std::size_t i = first; i < first + size; ++i) {
          packet.emplace_back(left + places[i].x, top + places[i].y);
          any |= places[i].x < width && places[i].y < height;
        }
        EXPECT_TRUE(any) << "none of it is needed";
        packets.insert(std::move(packet));
      }
      return packets;
    };
    const std::set<Packet> all = packets_of(0 - 16u, 0 - 16u, 64, 64);
    for (const std::uint32_t left : {0u, 3u, ~0u}) {
      for (const Packet& packet : packets_of(left, 5, 21, 10)) EXPECT_TRUE(all.contains(packet));
    }
  }
}

/// A group has one pixel of each place of the film's blocks of 4 x 4, so each of the numbers that these take
/// from one sequence.
TEST(PixelOrder, AGroupHasOnePixelOfEachPlace) {
  for (std::uint32_t number = 0; number < 16; ++number) {
    for (const Pixels& pixels : groups_of(0, 0, 64, 64, {4, 4, 2}, grid_of({4, 4, 2}, kSeed, number))) {
      Pixels places;
      for (const auto& [x, y] : pixels) places.emplace(x % 4, y % 4);
      EXPECT_EQ(places.size(), 16u);
    }
  }
}

/// Over 64 numbers, two pixels share as often wherever on the film they are, and the less the farther apart
/// they are: there is neither a grid nor a weave. Two pixels of a cell of four groups share with probability
/// 1/4.
TEST(PixelOrder, WhichPixelsShareDependsOnHowFarApartTheyAreAlone) {
  constexpr PixelGroup kGroup{4, 4, 2};
  constexpr std::uint32_t kNumbers = 64, kSide = 64;
  double sharing[4][8] = {};  // [distance along rows][column in a grid of 8]
  for (std::uint32_t number = 0; number < kNumbers; ++number) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> group_of;
    std::size_t count = 0;
    for (const Pixels& pixels : groups_of(0, 0, kSide + 4, kSide, kGroup, grid_of(kGroup, kSeed, number))) {
      for (const auto& pixel : pixels) group_of[pixel] = count;
      ++count;
    }
    for (std::uint32_t y = 0; y < kSide; ++y) {
      for (std::uint32_t x = 0; x < kSide; ++x) {
        for (std::uint32_t apart = 1; apart < 4; ++apart)
          sharing[apart][x % 8] += group_of.at({x, y}) == group_of.at({x + apart, y}) ? 1 : 0;
      }
    }
  }
  // Draws of one cell depend on each other, those of two cells do not: 8 pairs of a row and 8 rows, at most.
  constexpr double kPairs = kNumbers * kSide * kSide / 8.0, kIndependent = kPairs / 64;
  for (std::uint32_t apart = 1; apart < 4; ++apart) {
    const double expected = (1 - apart / 8.0) / 4;
    for (const double times : sharing[apart])
      EXPECT_NEAR(times / kPairs, expected, 4 * std::sqrt(expected * (1 - expected) / kIndependent)) << apart;
  }
}

/// Cells have been at all places after as many numbers as they have pixels, and evenly after fewer.
TEST(PixelOrder, CellsGoEverywhere) {
  constexpr PixelGroup kGroup{4, 4, 2};
  for (const std::uint64_t seed : {0u, 1u, 77u}) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> corners;
    std::set<std::uint32_t> columns, rows;
    for (std::uint32_t number = 0; number < 64; ++number) {
      const GroupGrid grid = grid_of(kGroup, seed, number);
      corners.emplace(grid.x, grid.y);
      if (number < 4) columns.insert(grid.x / 2), rows.insert(grid.y / 2);
    }
    EXPECT_EQ(corners.size(), 64u);
    EXPECT_EQ(columns.size(), 4u);
    EXPECT_EQ(rows.size(), 4u);
  }
}

TEST(FilmSize, ReachesTheBorderThatFiltersReach) {
  constexpr FilmSize kSize{20, 14};
  EXPECT_TRUE(kSize.reaches(0, 0, 0, 0));
  EXPECT_TRUE(kSize.reaches(19, 13, 0, 0));
  EXPECT_FALSE(kSize.reaches(20, 13, 0, 0));
  EXPECT_FALSE(kSize.reaches(~0u, 0, 0, 0));
  EXPECT_TRUE(kSize.reaches(~0u, 15, 1, 2));
  EXPECT_FALSE(kSize.reaches(~0u - 1, 15, 1, 2));
  EXPECT_FALSE(kSize.reaches(0, 16, 1, 2));
  EXPECT_TRUE(FilmSize{}.reaches(~0u, ~0u, 4, 4));
}

}  // namespace
}  // namespace tessera::render
