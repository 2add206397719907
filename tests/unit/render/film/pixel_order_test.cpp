#include "render/film/pixel_order.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "unit/render/film/pixel_groups.h"

namespace tessera::render {
namespace {

using Pixels = std::set<std::pair<std::uint32_t, std::uint32_t>>;

/// Groups as sets of pixels of the film, those of a border with numbers modulo 2^32.
std::set<Pixels> groups_of(std::uint32_t left, std::uint32_t top, std::uint32_t width, std::uint32_t height,
                           const PixelGroup& group) {
  const std::vector<PixelPlace> places = groups_in(left, top, width, height, group);
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
    const std::set<Pixels> all = groups_of(0 - 16u, 0 - 16u, 64, 64, group);
    EXPECT_EQ(all.size(), 64u * 64 / static_cast<std::size_t>(group.count()));
    Pixels seen;
    for (const Pixels& pixels : all) seen.insert(pixels.begin(), pixels.end());
    EXPECT_EQ(seen.size(), 64u * 64);
    for (const std::uint32_t left : {0u, 3u, ~0u}) {
      for (const Pixels& pixels : groups_of(left, 5, 21, 10, group)) EXPECT_TRUE(all.contains(pixels));
    }
  }
}

/// The same pixels come one after the other, in the same order, and none that are not needed.
TEST(PixelOrder, PacketsAreTheSameWhateverTheRectangle) {
  using Packet = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  for (const PixelGroup group : test::kGroups) {
    const std::size_t size = packet_of(group);
    EXPECT_EQ(size, group.step == 1 ? static_cast<std::size_t>(group.count()) : 16u);
    const auto packets_of = [&](std::uint32_t left, std::uint32_t top, std::uint32_t width,
                                std::uint32_t height) {
      const std::vector<PixelPlace> places = groups_in(left, top, width, height, group);
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

/// Each block of 2 x 2 pixels gives one pixel to a group, in a fixed column and a random row.
TEST(PixelOrder, GroupsAreSpreadAndTheirRowsAreDrawn) {
  const PixelGroup group{4, 2, 2};
  int second_rows = 0;
  const std::set<Pixels> all = groups_of(0, 0, 64, 64, group);
  for (const Pixels& pixels : all) {
    Pixels blocks;
    for (const auto& [x, y] : pixels) {
      blocks.emplace(x / 2, y / 2);
      EXPECT_EQ(x % 2, pixels.begin()->first % 2);
      EXPECT_EQ(x / 8, pixels.begin()->first / 8);
      EXPECT_EQ(y / 4, pixels.begin()->second / 4);
      second_rows += static_cast<int>(y % 2 != pixels.begin()->second % 2);
    }
    EXPECT_EQ(blocks.size(), 8u);
  }
  // Seven of eight pixels of each of 512 groups, half of them; groups of one cell come in equal pairs.
  EXPECT_NEAR(second_rows, 512 * 3.5, 200);
}

/// Cells have 8 x 8 pixels and four groups, two of which meet any one row or column of pixels at an edge.
TEST(PixelOrder, ABorderOfOnePixelMeetsHalfOfTheGroups) {
  const PixelGroup group{4, 4, 2};
  for (const std::uint32_t edge : {7u, 8u}) {
    EXPECT_EQ(groups_in(0, edge, 64, 1, group).size(), 8u * 32);
    EXPECT_EQ(groups_in(edge, 0, 1, 64, group).size(), 8u * 32);
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
