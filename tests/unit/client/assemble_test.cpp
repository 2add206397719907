#include "image/assemble.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <variant>

#include "absl/strings/str_format.h"
#include "wire/aov_channels.h"

namespace tessera::client {
namespace {

using ::testing::HasSubstr;
using wire::TileResult;

constexpr std::uint32_t kWidth = 20, kHeight = 14;

std::vector<wire::ChannelDesc> channels() {
  return wire::channels_for_aovs({v1::AOV_VARIANCE, v1::AOV_DEPTH});
}

AssemblyOptions options(std::uint32_t spp) {
  return {.width = kWidth,
          .height = kHeight,
          .crop = {0, 0, kWidth, kHeight},
          .spp = spp,
          .channels = channels()};
}

// One sample of each pixel of a tile: a hash of pixel, channel and sample index.
TileResult leaf(const Window& tile, std::uint32_t sample) {
  TileResult result;
  result.x0 = std::uint32_t(tile.x0), result.y0 = std::uint32_t(tile.y0);
  result.x1 = std::uint32_t(tile.x1), result.y1 = std::uint32_t(tile.y1);
  result.sample_begin = sample, result.sample_end = sample + 1;
  result.channels = channels();
  result.counts.assign(result.pixel_count(), 1);
  for (std::size_t c = 0; c < result.channels.size(); ++c) {
    for (std::uint32_t y = result.y0; y < result.y1; ++y) {
      for (std::uint32_t x = result.x0; x < result.x1; ++x) {
        std::mt19937 random(x + 1000 * y + 1000000 * sample + 1000000000 * std::uint32_t(c));
        const bool deviation = result.channels[c].kind == wire::ChannelKind::kSquaredDeviation;
        result.values.push_back(deviation ? 0.0f : std::lognormal_distribution<float>(0, 1)(random));
      }
    }
  }
  return result;
}

void append(TileResult& left, const TileResult& right) {
  const std::size_t n = left.pixel_count();
  wire::merge_pixel_nodes(left.channels, n, left.counts.data(), left.values.data(), n, right.counts.data(),
                          right.values.data(), n);
  left.sample_end = right.sample_end;
}

// The node over [begin, begin + size) by the definition of the tree, cut at spp.
TileResult tree_node(const Window& tile, std::uint32_t begin, std::uint32_t size, std::uint32_t spp) {
  if (size == 1) return leaf(tile, begin);
  TileResult left = tree_node(tile, begin, size / 2, spp);
  if (begin + size / 2 < spp) append(left, tree_node(tile, begin + size / 2, size / 2, spp));
  return left;
}

// All units of a job: tiles of tile_size and ranges of range_size samples.
std::vector<TileResult> all_units(std::uint32_t spp, std::int32_t tile_size, std::uint32_t range_size) {
  std::vector<TileResult> units;
  for (std::int32_t y = 0; y < std::int32_t{kHeight}; y += tile_size) {
    for (std::int32_t x = 0; x < std::int32_t{kWidth}; x += tile_size) {
      const Window tile{x, y, std::min(x + tile_size, std::int32_t{kWidth}),
                        std::min(y + tile_size, std::int32_t{kHeight})};
      for (std::uint32_t s = 0; s < spp; s += range_size)
        units.push_back(tree_node(tile, s, range_size, spp));
    }
  }
  return units;
}

Image assemble(AssemblyOptions how, const std::vector<TileResult>& units) {
  absl::StatusOr<Assembler> assembler = Assembler::create(std::move(how));
  EXPECT_TRUE(assembler.ok()) << assembler.status();
  for (const TileResult& unit : units) {
    const absl::Status status = assembler->add(unit);
    EXPECT_TRUE(status.ok()) << status;
  }
  EXPECT_TRUE(assembler->complete());
  absl::StatusOr<Assembly> assembly = std::move(*assembler).finish();
  EXPECT_TRUE(assembly.ok()) << assembly.status();
  EXPECT_EQ(assembly->incomplete_pixels, 0u);
  return std::move(assembly->image);
}

void expect_same_bits(const Image& a, const Image& b) {
  ASSERT_EQ(a.channels.size(), b.channels.size());
  for (std::size_t c = 0; c < a.channels.size(); ++c) EXPECT_EQ(a.channels[c].values, b.channels[c].values);
}

TEST(Assembler, GivesTheSameBitsForAnyOrderAndAnyCut) {
  const std::uint32_t spp = 13;  // no power of two: the tree has nodes without a right child
  const Image expected = assemble(options(spp), all_units(spp, 64, 16));
  std::mt19937 random(1);
  for (const std::int32_t tile_size : {5, 8, 64}) {
    for (const std::uint32_t range_size : {1u, 2u, 4u, 8u}) {
      std::vector<TileResult> units = all_units(spp, tile_size, range_size);
      std::shuffle(units.begin(), units.end(), random);
      expect_same_bits(assemble(options(spp), units), expected);
    }
  }
}

TEST(Assembler, GivesTheSameBitsFromTheTemporaryFile) {
  const std::uint32_t spp = 16;
  std::vector<TileResult> units = all_units(spp, 8, 1);
  const Image expected = assemble(options(spp), units);
  std::shuffle(units.begin(), units.end(), std::mt19937(3));
  AssemblyOptions tight = options(spp);
  tight.max_pending_bytes = 1;  // nothing fits
  expect_same_bits(assemble(tight, units), expected);
}

TEST(Assembler, ComputesMeansAndVariances) {
  const std::uint32_t spp = 11;
  const Image image = assemble(options(spp), all_units(spp, 8, 4));
  const std::size_t pixel = 9 * kWidth + 17;
  double sum = 0, squares = 0, depth = 0;
  for (std::uint32_t s = 0; s < spp; ++s) {
    const TileResult sample = leaf({17, 9, 18, 10}, s);
    sum += sample.values[0];
    squares += sample.values[0] * double{sample.values[0]};
    depth += sample.values[7];
  }
  const double mean = sum / spp, variance = (squares - sum * mean) / (spp - 1);
  // Sums go through at most four additions in float: 4 * 2^-24 relative. Deviations from means that err as
  // much have an error of about 2 |mean| sd 2^-22 / variance, 1e-5 relative with room for mean = 5 sd.
  EXPECT_NEAR(image.find("R")->values[pixel], mean, 4 * std::ldexp(mean, -24));
  EXPECT_NEAR(image.find("variance.R")->values[pixel], variance, 1e-5 * variance);
  EXPECT_NEAR(image.find("depth.Z")->values[pixel], depth / spp, 4 * std::ldexp(depth / spp, -24));
  EXPECT_EQ(image.find("samples")->values[pixel], 11);
}

TEST(Assembler, OneSampleHasNoVariance) {
  const Image image = assemble(options(1), all_units(1, 64, 1));
  EXPECT_EQ(image.find("variance.G")->values[3], 0);
  EXPECT_EQ(image.find("G")->values[0], leaf({0, 0, 1, 1}, 0).values[1]);
}

TEST(Assembler, TheSamplesChannelIsOptional) {
  AssemblyOptions without = options(2);
  without.samples_channel = false;
  const std::vector<TileResult> units = all_units(2, 64, 2);
  const Image with = assemble(options(2), units), image = assemble(without, units);
  EXPECT_EQ(image.find("samples"), nullptr);
  EXPECT_EQ(image.channels.size(), channels().size());
  EXPECT_EQ(image.find("R")->values, with.find("R")->values);
}

TEST(Assembler, PlacesACrop) {
  AssemblyOptions crop = options(2);
  crop.crop = {4, 3, 15, 9};
  absl::StatusOr<Assembler> assembler = Assembler::create(crop);
  ASSERT_TRUE(assembler.ok()) << assembler.status();
  ASSERT_TRUE(assembler->add(tree_node({8, 3, 15, 9}, 0, 2, 2)).ok());
  ASSERT_TRUE(assembler->add(tree_node({4, 3, 8, 9}, 0, 2, 2)).ok());
  EXPECT_TRUE(assembler->complete());
  const Image image = std::move(*assembler).finish()->image;
  EXPECT_EQ(image.data, (Window{4, 3, 15, 9}));
  EXPECT_EQ(image.display, (Window{0, 0, kWidth, kHeight}));
  const Image whole = assemble(options(2), all_units(2, 64, 2));
  for (std::int32_t y = 3; y < 9; ++y) {
    for (std::int32_t x = 4; x < 15; ++x) {
      ASSERT_EQ(image.find("B")->values[std::size_t((y - 3) * 11 + x - 4)],
                whole.find("B")->values[std::size_t(y * std::int32_t{kWidth} + x)]);
    }
  }
}

TEST(Assembler, ReportsWhatIsMissing) {
  absl::StatusOr<Assembler> assembler = Assembler::create(options(8));
  ASSERT_TRUE(assembler->add(tree_node({0, 0, 10, 14}, 0, 8, 8)).ok());
  ASSERT_TRUE(assembler->add(tree_node({10, 0, 20, 7}, 4, 2, 8)).ok());
  ASSERT_TRUE(assembler->add(tree_node({10, 0, 20, 7}, 0, 2, 8)).ok());
  EXPECT_FALSE(assembler->complete());
  EXPECT_EQ(assembler->samples_total(), 20u * 14 * 8);
  EXPECT_EQ(assembler->samples_done(), 140u * 8 + 70 * 4);
  const absl::StatusOr<Assembly> assembly = std::move(*assembler).finish();
  ASSERT_TRUE(assembly.ok());
  EXPECT_EQ(assembly->incomplete_pixels, 140u);
  const Image& image = assembly->image;
  const auto at = [&](const char* channel, std::uint32_t x, std::uint32_t y) {
    return image.find(channel)->values[y * kWidth + x];
  };
  EXPECT_EQ(at("samples", 3, 3), 8);
  EXPECT_EQ(at("samples", 12, 3), 4);
  EXPECT_EQ(at("samples", 12, 10), 0);
  // Nothing is known of a pixel without samples, and it says so: a checkerboard of black and magenta.
  EXPECT_EQ(at("R", 12, 10), 1);
  EXPECT_EQ(at("G", 12, 10), 0);
  EXPECT_EQ(at("B", 12, 10), 1);
  EXPECT_EQ(at("R", 17, 10), 0);
  ASSERT_EQ(assembly->holes.size(), 2u);
  EXPECT_EQ(assembly->holes[0].pixels, (Window{10, 0, 20, 7}));
  EXPECT_FALSE(assembly->holes[0].empty);
  EXPECT_EQ(assembly->holes[1].pixels, (Window{10, 7, 20, 14}));
  EXPECT_TRUE(assembly->holes[1].empty);
  TileResult part = tree_node({12, 3, 13, 4}, 0, 2, 8);
  append(part, tree_node({12, 3, 13, 4}, 4, 2, 8));
  EXPECT_EQ(at("R", 12, 3), part.values[0] / 4);
}

/// A result whose samples each show one of a few things.
TileResult things(const Window& tile, std::uint32_t sample) {
  TileResult result = leaf(tile, sample);
  result.channels = wire::channels_for_aovs({v1::AOV_CRYPTO_OBJECT});
  result.values.assign(result.channels.size() * result.pixel_count(), 0.25f);
  const auto first = std::ranges::find(result.channels, wire::ChannelKind::kEntry, &wire::ChannelDesc::kind);
  for (std::size_t c = std::size_t(first - result.channels.begin()); c < result.channels.size(); ++c) {
    const bool identifies = (c - first->of) % 2 == 0,
               is_own = result.channels[c].kind == wire::ChannelKind::kEntry;
    for (std::size_t i = 0; i < result.pixel_count(); ++i) {
      const std::size_t x = std::size_t(tile.x0) + i % std::size_t(tile.width());
      const std::size_t y = std::size_t(tile.y0) + i / std::size_t(tile.width());
      const float thing = float(1 + (7 * x + 3 * y + sample * (x % 3)) % 5);
      result.values[c * result.pixel_count() + i] = !is_own ? 0.0f : identifies ? thing : 1.0f;
    }
  }
  return result;
}

/// The picture as it is written, from memory or from a file of tiles.
Assembly assemble_things(std::size_t max_frame_bytes, bool with_hole) {
  AssemblyOptions how = options(2);
  how.channels = things({0, 0, 1, 1}, 0).channels;
  how.mattes = {
      {.list = "crypto-object", .name = "CryptoObject", .ranks = 3, .name_of = [](std::int64_t number) {
         return "thing " + std::to_string(number);
       }}};
  how.max_frame_bytes = max_frame_bytes;
  how.tile_size = 8;
  absl::StatusOr<Assembler> assembler = Assembler::create(how);
  EXPECT_TRUE(assembler.ok()) << assembler.status();
  for (std::int32_t y = 0; y < std::int32_t{kHeight}; y += 8) {
    for (std::int32_t x = 0; x < std::int32_t{kWidth}; x += 8) {
      if (with_hole && x == 16 && y == 0) continue;
      const Window tile{x, y, std::min(x + 8, std::int32_t{kWidth}), std::min(y + 8, std::int32_t{kHeight})};
      for (const std::uint32_t sample : {1u, 0u}) EXPECT_TRUE(assembler->add(things(tile, sample)).ok());
    }
  }
  absl::StatusOr<Assembly> assembly = std::move(*assembler).finish();
  EXPECT_TRUE(assembly.ok()) << assembly.status();
  return *std::move(assembly);
}

TEST(Assembler, ResolvesCryptomattesInMemoryAndInAFileAlike) {
  for (const bool with_hole : {false, true}) {
    const Assembly whole = assemble_things(SIZE_MAX, with_hole), rows = assemble_things(0, with_hole);
    EXPECT_EQ(whole.rows, nullptr);
    ASSERT_NE(rows.rows, nullptr);
    EXPECT_EQ(whole.image.find("crypto-object.id0"), nullptr);
    ASSERT_NE(whole.image.find("CryptoObject01.A"), nullptr);
    EXPECT_EQ(whole.image.metadata, rows.image.metadata);
    EXPECT_THAT(std::get<std::string>(whole.image.metadata.at(
                    absl::StrFormat("cryptomatte/%07x/manifest", matte_hash("CryptoObject") >> 4))),
                HasSubstr("thing 5"));
    ASSERT_EQ(whole.image.channels.size(), rows.image.channels.size());
    for (std::size_t plane = 0; plane < whole.image.channels.size(); ++plane) {
      EXPECT_EQ(whole.image.channels[plane].name, rows.image.channels[plane].name);
      std::vector<float> values, row(kWidth);
      for (std::int32_t y = 0; y < std::int32_t{kHeight}; ++y) {
        ASSERT_TRUE(rows.rows->read(plane, y, row).ok());
        values.insert(values.end(), row.begin(), row.end());
      }
      EXPECT_EQ(whole.image.channels[plane].values, values) << whole.image.channels[plane].name;
    }
    const auto at = [&](const char* channel, std::uint32_t x, std::uint32_t y) {
      return whole.image.find(channel)->values[y * kWidth + x];
    };
    // The two samples of (1, 0) show things 1 + 7 % 5 and 1 + 8 % 5.
    EXPECT_EQ(at("CryptoObject00.G", 1, 0), 0.5f);
    EXPECT_EQ(at("CryptoObject00.A", 1, 0), 0.5f);
    EXPECT_EQ(at("CryptoObject00.G", 0, 1), 1);
    EXPECT_EQ(at("R", 15, 7), 0.25f);
    EXPECT_EQ(at("R", 16, 0), with_hole ? 1.0f : 0.25f);
    EXPECT_EQ(whole.holes.size(), with_hole ? 1u : 0u);
  }
}

TEST(Assembler, RefusesWhatIsThereAlready) {
  absl::StatusOr<Assembler> assembler = Assembler::create(options(8));
  const Window tile{0, 0, 8, 8};
  ASSERT_TRUE(assembler->add(tree_node(tile, 0, 2, 8)).ok());
  ASSERT_TRUE(assembler->add(tree_node(tile, 4, 4, 8)).ok());
  for (const TileResult& again :
       {tree_node(tile, 0, 2, 8), tree_node(tile, 1, 1, 8), tree_node(tile, 0, 4, 8),
        tree_node(tile, 0, 8, 8), tree_node(tile, 6, 2, 8)}) {
    const absl::Status status = assembler->add(again);
    EXPECT_EQ(status.code(), absl::StatusCode::kAlreadyExists) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("pixels [0, 8) x [0, 8)"));
  }
  EXPECT_EQ(assembler->samples_done(), 64u * 6);
  ASSERT_TRUE(assembler->add(tree_node(tile, 2, 2, 8)).ok());
  EXPECT_EQ(assembler->add(tree_node(tile, 2, 2, 8)).code(), absl::StatusCode::kAlreadyExists);
}

TEST(Assembler, RefusesForeignResults) {
  absl::StatusOr<Assembler> assembler = Assembler::create(options(12));
  ASSERT_TRUE(assembler->add(tree_node({0, 0, 8, 8}, 0, 4, 12)).ok());
  const auto expect_refused = [&](TileResult result, const char* why) {
    const absl::Status status = assembler->add(std::move(result));
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << why;
    EXPECT_THAT(std::string(status.message()), HasSubstr(why));
  };
  expect_refused(tree_node({4, 4, 12, 12}, 0, 4, 12), "overlap");
  expect_refused(tree_node({0, 0, 4, 8}, 4, 4, 12), "overlap");
  expect_refused(tree_node({16, 8, 24, 14}, 0, 4, 12), "not inside");
  expect_refused(tree_node({8, 0, 16, 8}, 12, 4, 16), "not a node");

  TileResult result = tree_node({8, 0, 16, 8}, 0, 4, 12);
  result.sample_begin = 1;
  expect_refused(result, "not a node");
  result.sample_begin = 2;
  result.sample_end = 6;
  expect_refused(result, "not a node");

  result = tree_node({8, 0, 16, 8}, 0, 4, 12);
  result.channels.pop_back();
  expect_refused(result, "other channels");

  result = tree_node({8, 0, 16, 8}, 0, 4, 12);
  result.values.pop_back();
  expect_refused(result, "arrays");

  result = tree_node({8, 0, 16, 8}, 0, 4, 12);
  result.counts[5] = 5;
  expect_refused(result, "more samples than");
  EXPECT_EQ(assembler->samples_done(), 64u * 4);
}

TEST(Assembler, RefusesOptionsThatDoNotFit) {
  const auto refused = [](const AssemblyOptions& bad) { return !Assembler::create(bad).ok(); };
  AssemblyOptions bad = options(1);
  bad.crop.x1 = kWidth + 1;
  EXPECT_TRUE(refused(bad));
  bad.crop = {5, 5, 5, 6};
  EXPECT_TRUE(refused(bad));
  bad.crop = {-1, 0, 5, 6};
  EXPECT_TRUE(refused(bad));
  EXPECT_TRUE(refused(options(0)));
  bad = options(1);
  bad.width = bad.height = 1u << 20;
  bad.crop = {0, 0, 1 << 20, 1 << 20};
  EXPECT_TRUE(refused(bad));
  bad = options(1);
  bad.channels.clear();
  EXPECT_TRUE(refused(bad));
}

}  // namespace
}  // namespace tessera::client
