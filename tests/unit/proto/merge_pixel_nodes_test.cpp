#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>
#include <span>

#include "wire/tile_result.h"

namespace tessera::wire {
namespace {

/// Nodes of one pixel with two channels: a sum and its squared deviation.
struct Node {
  std::uint32_t count = 0;
  float values[2] = {0.0f, 0.0f};
};

const std::vector<ChannelDesc> kChannels = {{"R", ChannelKind::kSum, 0},
                                            {"variance.R", ChannelKind::kSquaredDeviation, 0}};

Node merged(Node left, const Node& right) {
  merge_pixel_nodes(kChannels, 1, &left.count, left.values, 1, &right.count, right.values, 1);
  return left;
}

/// The node over `samples` by the rule of the tree, cut at powers of two.
Node tree(std::span<const float> samples) {
  if (samples.size() == 1) return {1, {samples[0], 0.0f}};
  const std::size_t half = std::bit_ceil(samples.size()) / 2;
  return merged(tree(samples.first(half)), tree(samples.subspan(half)));
}

std::vector<float> random_samples(std::size_t count, float mean, float spread) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> value(mean - spread, mean + spread);
  std::vector<float> samples(count);
  for (float& sample : samples) sample = value(random);
  return samples;
}

TEST(MergePixelNodes, GivesSumAndSquaredDeviation) {
  for (const std::size_t count : {1, 2, 3, 7, 64, 1000}) {
    const std::vector<float> samples = random_samples(count, 5.0f, 2.0f);
    double sum = 0.0, deviation = 0.0;
    for (const float sample : samples) sum += sample;
    const double mean = sum / static_cast<double>(count);
    for (const float sample : samples) deviation += (sample - mean) * (sample - mean);

    const Node node = tree(samples);
    EXPECT_EQ(node.count, count);
    // Each of the log2(n) <= 10 levels rounds to float once, by at most 2^-24 of the node's value. The
    // deviation also sees the error of the two means: 10 * 2^-24 * mean twice, against a difference of means
    // of order spread / sqrt(n); over the levels that stays below 1e-4 of a deviation of this size (mean /
    // spread = 2.5, n <= 1000).
    EXPECT_NEAR(node.values[0], sum, 10 * std::ldexp(sum, -24));
    EXPECT_NEAR(node.values[1], deviation, 1e-4 * deviation);
  }
}

TEST(MergePixelNodes, AnyCutIntoNodesGivesTheSameBits) {
  constexpr std::uint32_t kSamples = 103;  // not a power of two: the last nodes are cut short
  const std::vector<float> samples = random_samples(kSamples, 1.0f, 1.0f);
  const Node whole = tree(samples);
  for (const std::uint32_t range : {1u, 2u, 8u, 32u, 64u, 128u}) {
    // Nodes as units would return them, then merged pairwise, as an assembler does.
    struct Ranged {
      std::uint32_t begin, end;
      Node node;
    };
    std::vector<Ranged> nodes;
    for (std::uint32_t begin = 0; begin < kSamples; begin += range) {
      const std::uint32_t end = std::min(begin + range, kSamples);
      nodes.push_back({begin, end, tree(std::span(samples).subspan(begin, end - begin))});
    }
    while (nodes.size() > 1) {
      bool found = false;
      for (std::size_t i = nodes.size() - 1; i-- > 0 && !found;) {
        if (!are_siblings(nodes[i].begin, nodes[i].end, nodes[i + 1].begin, nodes[i + 1].end, kSamples))
          continue;
        nodes[i] = {nodes[i].begin, nodes[i + 1].end, merged(nodes[i].node, nodes[i + 1].node)};
        nodes.erase(nodes.begin() + static_cast<std::ptrdiff_t>(i) + 1);
        found = true;
      }
      ASSERT_TRUE(found) << "range " << range;
    }
    EXPECT_EQ(nodes[0].node.count, whole.count);
    EXPECT_EQ(std::bit_cast<std::uint32_t>(nodes[0].node.values[0]),
              std::bit_cast<std::uint32_t>(whole.values[0]));
    EXPECT_EQ(std::bit_cast<std::uint32_t>(nodes[0].node.values[1]),
              std::bit_cast<std::uint32_t>(whole.values[1]));
  }
}

TEST(MergePixelNodes, LeftAndRightAreNotTheSame) {
  // The order is part of the contract: it would show if the two were swapped by accident. Three floats whose
  // sum depends on the order: (1 + 2^-24) + 2^-24 = 1, but 1 + (2^-24 + 2^-24) > 1.
  const float small = std::ldexp(1.0f, -24);
  const Node one{1, {1.0f, 0.0f}}, tiny{1, {small, 0.0f}};
  EXPECT_NE(merged(merged(one, tiny), tiny).values[0], merged(one, merged(tiny, tiny)).values[0]);
}

TEST(MergePixelNodes, AnEmptySideAddsNothing) {
  const Node node{4, {6.0f, 3.0f}}, empty;
  for (const Node& both : {merged(node, empty), merged(empty, node)}) {
    EXPECT_EQ(both.count, 4u);
    EXPECT_EQ(both.values[0], 6.0f);
    EXPECT_EQ(both.values[1], 3.0f);
  }
}

TEST(MergePixelNodes, HonoursStrides) {
  std::uint32_t left_counts[] = {1, 1}, right_counts[] = {1, 1};
  float left[] = {1, 2, -1, 0, 0, -1};       // planes of 2 pixels, 3 floats apart
  float right[] = {3, 4, -2, -2, 0, 0, -2};  // 4 floats apart
  merge_pixel_nodes(kChannels, 2, left_counts, left, 3, right_counts, right, 4);
  EXPECT_EQ(std::vector<float>(left, left + 6), (std::vector<float>{4, 6, -1, 2, 2, -1}));
}

TEST(AreSiblings, FollowsTheTree) {
  EXPECT_TRUE(are_siblings(0, 4, 4, 8, 16));
  EXPECT_TRUE(are_siblings(8, 12, 12, 16, 16));
  EXPECT_TRUE(are_siblings(8, 12, 12, 14, 14));  // the right one is cut short by the end
  EXPECT_TRUE(are_siblings(0, 64, 64, 100, 100));
  EXPECT_FALSE(are_siblings(4, 8, 8, 12, 16));    // neighbours, but of two parents
  EXPECT_FALSE(are_siblings(8, 12, 12, 14, 16));  // the right one is not whole
  EXPECT_FALSE(are_siblings(0, 4, 8, 12, 16));
  EXPECT_FALSE(are_siblings(4, 8, 0, 4, 16));
  EXPECT_FALSE(are_siblings(0, 3, 3, 6, 6));
  EXPECT_FALSE(are_siblings(0, 0, 0, 4, 4));
}

TEST(MergePixelNodes, FirstSamplesStayWhateverTheCut) {
  const std::vector<ChannelDesc> channels = {{"id", ChannelKind::kFirst, 0}};
  const auto merge = [&](Node left, const Node& right) {
    merge_pixel_nodes(channels, 1, &left.count, left.values, 1, &right.count, right.values, 1);
    return left;
  };
  const Node a{1, {7}}, b{1, {3}}, c{2, {9}}, none{};
  EXPECT_EQ(merge(merge(a, b), c).values[0], 7);
  EXPECT_EQ(merge(a, merge(b, c)).values[0], 7);
  EXPECT_EQ(merge(a, merge(b, c)).count, 4u);
  // A pixel without samples yet has no first one.
  EXPECT_EQ(merge(none, b).values[0], 3);
  EXPECT_EQ(merge(b, none).values[0], 3);
}

}  // namespace
}  // namespace tessera::wire
