// Pilots of noise: what they see, and their bytes.
#include "render/film/noise_pilot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <set>

#include "base/split_mix.h"
#include "unit/render/film/pixel_groups.h"

namespace tessera::render::noise_pilot_test {
namespace {

using Shade = std::function<float(const SampleName&)>;

float uniform(const SampleName& name) {
  const std::uint64_t place = std::uint64_t{name.x} << 40 ^ std::uint64_t{name.y} << 20 ^ name.index;
  return static_cast<float>(base::split_mix(base::split_mix(place) ^ name.stream) >> 40) * 0x1p-24f;
}

/// A sample costs a ray on the left, and five from pixel 32 on.
std::uint64_t rays_of(const SampleName& name) { return name.x < 32 ? 1 : 5; }

Pilot pilot_of(const FilmRect& crop, const PartRequest& part, const Shade& shade, double noise = 0.1,
               std::vector<SampleName>* all = nullptr, PixelGroup group = {}) {
  constexpr std::size_t kBatch = 128;
  RenderStats stats;
  NoisePilot film(crop, {60, 44}, part, {noise, 4096}, /*scatters=*/true, group, 1, stats);
  std::vector<SampleName> names(kBatch);
  std::vector<float> planes(4 * kBatch);
  while (const std::size_t count = film.next(names)) {
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_TRUE((names[i].x < 60 && names[i].y < 44) || group.count() > 1);
      EXPECT_GT(names[i].stream, 1u);
      const CommonPlaces& places = *film.places();
      EXPECT_TRUE(places.x[names[i].index - places.first] < 1 && places.y[names[i].index - places.first] < 1);
      for (std::size_t c = 0; c < 3; ++c) planes[c * kBatch + i] = shade(names[i]);
      stats.bounce_rays += rays_of(names[i]);
      if (all != nullptr) all->push_back(names[i]);
    }
    film.add(std::span(names).first(count), planes.data(), kBatch);
  }
  return film.result();
}

constexpr FilmRect kFilm{0, 0, 60, 44};

TEST(NoisePilot, SeesTheVarianceOfSamples) {
  // Uniform in [0, 2): variance 1 / 3, relative to 1 + 0.01.
  double error[2]{}, blocks = 0;
  const Pilot pilot = pilot_of(
      kFilm, {}, [](const SampleName& name) { return 2 * uniform(name); }, 0.01);
  EXPECT_EQ(pilot.values.size(), 8u * 6);
  for (const PilotBlock& block : pilot.values) {
    for (std::size_t half : {0u, 1u}) error[half] += double{block.error[half]};
    ++blocks;
  }
  // 48 blocks of 32 pixels a half (fewer at the border), each a square of a nearly normal number: 4 %, four
  // times.
  EXPECT_NEAR(error[0] / blocks, 1 / 3.03, 0.16 / 3.03);
  EXPECT_NEAR(error[1] / blocks, 1 / 3.03, 0.16 / 3.03);
}

/// Neighbours that share light make one half of a block, so noise that they share does not judge itself.
TEST(NoisePilot, SamplesWholeGroupsOfNeighbours) {
  for (const PixelGroup group : test::kGroups) {
    std::vector<SampleName> all;
    const auto count = static_cast<std::size_t>(group.count());
    std::map<std::uint64_t, std::set<std::uint64_t>> groups_of_block;
    const test::GroupMap map(group);
    const auto group_of = [&](const SampleName& name) { return map.of(name); };
    const auto shade = [&](const SampleName& name) {
      const std::uint64_t block = std::uint64_t{name.y / 8} << 32 | name.x / 8;
      groups_of_block[block].insert(group_of(name));
      return 2 * uniform(name);
    };
    const Pilot pilot = pilot_of(kFilm, {}, shade, 0.1, &all, group);
    EXPECT_EQ(pilot.values.size(), 8u * 6);
    ASSERT_EQ(all.size() % count, 0u);
    for (std::size_t i = 0; i < all.size(); ++i)
      EXPECT_EQ(group_of(all[i]), group_of(all[i / count * count]));
    for (const auto& [block, groups] : groups_of_block) {
      const bool whole = (block >> 32) < 44 / 8 && (block & 0xffffffff) < 60 / 8;
      if (whole) {
        EXPECT_GE(groups.size(), 2u) << "one half would judge itself";
      }
    }
    for (const PilotBlock& block : pilot.values) EXPECT_GT(block.error[0], 0);
  }
}

TEST(NoisePilot, SeesNoNoiseInWhatDoesNotVaryWithinPixels) {
  const Pilot pilot =
      pilot_of(kFilm, {}, [](const SampleName& name) { return static_cast<float>(name.x * name.y); });
  for (const PilotBlock& block : pilot.values) EXPECT_EQ(block.error, (std::array{0.0f, 0.0f}));
}

TEST(NoisePilot, SamplesAreFewAndEachTakenOnce) {
  for (const auto& [noise, pixels] : {std::pair(0.1, 4u), {0.03, 32u}, {0.01, 64u}}) {
    std::vector<SampleName> all;
    pilot_of(kFilm, {}, uniform, noise, &all);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::set<std::pair<std::uint32_t, std::uint32_t>>>
        by_pixel;
    for (const SampleName& name : all)
      EXPECT_TRUE((by_pixel[{name.x, name.y}].emplace(name.stream, name.index).second));
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> by_block;
    for (const auto& [pixel, samples] : by_pixel) {
      EXPECT_EQ(samples.size(), 4u);
      ++by_block[{pixel.first / 8, pixel.second / 8}];
    }
    EXPECT_EQ(by_block.size(), 48u);
    // The block in the corner has 4x4 pixels.
    EXPECT_EQ((by_block[{7, 5}]), std::min(pixels, 16u));
    EXPECT_EQ((by_block[{0, 0}]), pixels);
  }
}

TEST(NoisePilot, CostsAreRaysOfTheBlocksAround) {
  const Pilot pilot = pilot_of(kFilm, {}, uniform);
  for (std::size_t i = 0; i < pilot.values.size(); ++i)
    EXPECT_EQ(pilot.values[i].cost, i % 8 < 4 ? 1.0f : 5.0f) << "batches are of 4x2 blocks";
}

TEST(NoisePilot, PartsMergeToTheSameBytes) {
  const FilmRect crop{9, 8, 50, 41};
  const std::string whole = pilot_blob(pilot_of(crop, {}, uniform));
  for (const std::uint32_t parts : {2u, 5u, 9u}) {
    Pilot merged;
    for (std::uint32_t part = 0; part < parts; ++part) {
      const std::string blob = pilot_blob(pilot_of(crop, {.part = part, .parts = parts}, uniform));
      EXPECT_TRUE(append_pilot_blob(blob, merged));
    }
    // Costs are those of batches, which parts cut.
    Pilot expected;
    EXPECT_TRUE(append_pilot_blob(whole, expected));
    ASSERT_EQ(merged.values.size(), 6u * 5);
    for (std::size_t i = 0; i < merged.values.size(); ++i)
      EXPECT_EQ(merged.values[i].error, expected.values[i].error);
    EXPECT_EQ(merged.blocks.x0, 1u);
    EXPECT_EQ(merged.blocks.y1, 6u);
  }
}

TEST(NoisePilot, OtherBytesAreRefused) {
  const Pilot one = pilot_of({0, 0, 16, 16}, {}, uniform);
  const std::string good = pilot_blob(one);
  const auto takes = [](const std::string& blob) {
    Pilot pilot;
    return append_pilot_blob(blob, pilot);
  };
  EXPECT_TRUE(takes(good));
  EXPECT_TRUE(takes(""));
  EXPECT_FALSE(takes(good.substr(1)));
  EXPECT_FALSE(takes(good + "x"));
  EXPECT_FALSE(takes(good.substr(0, 10)));
  const auto with_word = [&](std::size_t word, auto value) {
    std::string blob = good;
    std::memcpy(&blob[4 * word], &value, 4);
    return blob;
  };
  for (const std::uint32_t side : {0u, 3u, 8193u, 1u << 31, ~0u}) {
    for (const std::size_t word : {0u, 1u, 2u, 3u}) {
      const bool is_begin = side == 0 && word < 2;
      EXPECT_EQ(takes(with_word(word, side)), is_begin) << word << ' ' << side;
    }
  }
  for (const float value : {NAN, INFINITY, -INFINITY, -1.0f, 1e31f}) {
    for (const std::size_t word : {4u, 5u, 6u, 15u}) EXPECT_FALSE(takes(with_word(word, value))) << value;
  }
  EXPECT_FALSE(takes(with_word(6, 0.5f))) << "less than a ray a sample";
  // The same blocks twice, and others beside them.
  Pilot pilot;
  EXPECT_TRUE(append_pilot_blob(good, pilot));
  EXPECT_FALSE(append_pilot_blob(good, pilot));
  EXPECT_FALSE(append_pilot_blob(pilot_blob(pilot_of({8, 16, 24, 32}, {}, uniform)), pilot));
}

}  // namespace
}  // namespace tessera::render::noise_pilot_test
