// Path guides: their sums, their cells and their densities, each by itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "render/transport/guide/guide_density.h"
#include "render/transport/guide/guide_field.h"
#include "render/transport/guide/guided_path.h"
#include "support/kernel/chi2.h"
#include "support/kernel/random_lanes.h"

namespace tessera::render::TESSERA_ISA::guide_test {  // apart from tests that are compiled with these
namespace {

using test::chi_square_test;
using test::sidak_level;
using testing::Each;
using testing::Gt;

constexpr int kFields = 3;  // drawn at random

/// Sums of one cell, whose bins have values that differ by factors of up to 10,000.
std::vector<GuideSum> sums_of_cell(std::uint64_t cell, unsigned seed) {
  std::mt19937 random{seed};
  std::vector<GuideSum> sums;
  for (std::uint64_t bin = 0; bin < kGuideBins; ++bin) {
    const double value = std::pow(10.0, 4.0 * static_cast<double>(random()) * 0x1p-32);
    sums.push_back({guide_key::with_bin(cell, bin), guide_value(value), 1 + random() % 64});
  }
  return sums;
}

GuideCells cells_at(std::int32_t exponent, std::int32_t x, std::int32_t y, std::int32_t z,
                    std::int32_t side) {
  return {Int(exponent), Int(x), Int(y), Int(z), Int(side)};
}

Guided guided_by(const GuideField& field) { return field.at(cells_at(0, 1, 2, 3, 4), Mask::all()); }

const std::uint64_t kCell = guide_key::cell(0, 1, 2, 3, 4);

TEST(GuideField, DensitiesIntegrateToOne) {
  for (unsigned seed = 0; seed < kFields; ++seed) {
    const GuideField field(sums_of_cell(kCell, seed));
    const Guided guided = guided_by(field);
    ASSERT_TRUE(all(guided.known & guided.followed));
    // One direction a bin: each has an equal share of the sphere.
    double sum = 0;
    for (int bin = 0; bin < kGuideBins; ++bin) {
      const float x = (static_cast<float>(bin % kGuideRows) + 0.5f) / kGuideRows;
      const float y = (static_cast<float>(bin / kGuideRows) + 0.5f) / kGuideRows;
      const Vec3 w = direction_from_octahedral({Float(x), Float(y)});
      EXPECT_EQ(guide_bin(w).lane(0), bin);
      sum += double{field.pdf(guided, w, Mask::all()).lane(0)} * 4 * std::numbers::pi / kGuideBins;
    }
    EXPECT_NEAR(sum, 1, 1e-5);
  }
}

TEST(GuideField, SamplesFollowTheDensity) {
  constexpr int kPackets = 20'000;
  for (unsigned seed = 0; seed < kFields; ++seed) {
    const GuideField field(sums_of_cell(kCell, seed));
    const Guided guided = guided_by(field);
    RandomLanes random(seed + 100);
    std::vector<double> observed(kGuideBins + 1), expected(kGuideBins + 1);
    for (int i = 0; i < kPackets; ++i) {
      const Vec3 w = field.sample(guided, {random(), random()}, Mask::all());
      const Int bin = guide_bin(w);
      for (int lane = 0; lane < kWidth; ++lane) ++observed[static_cast<std::size_t>(bin.lane(lane))];
    }
    for (int bin = 0; bin < kGuideBins; ++bin) {
      const float x = (static_cast<float>(bin % kGuideRows) + 0.5f) / kGuideRows;
      const float y = (static_cast<float>(bin / kGuideRows) + 0.5f) / kGuideRows;
      const Float pdf = field.pdf(guided, direction_from_octahedral({Float(x), Float(y)}), Mask::all());
      expected[static_cast<std::size_t>(bin)] =
          kPackets * kWidth * double{pdf.lane(0)} * 4 * std::numbers::pi / kGuideBins;
    }
    EXPECT_GT(chi_square_test(observed, expected).p_value, sidak_level(0.01, kFields));
  }
}

TEST(GuideField, EndsOfTheUnitSquareAreDirections) {
  const GuideField field(sums_of_cell(kCell, 1));
  for (const float u : {0.0f, kOneMinusEpsilon}) {
    for (const float v : {0.0f, kOneMinusEpsilon}) {
      const Vec3 w = field.sample(guided_by(field), {Float(u), Float(v)}, Mask::all());
      EXPECT_NEAR(length(w).lane(0), 1, 1e-5);
      EXPECT_GT(field.pdf(guided_by(field), w, Mask::all()).lane(0), 0);
    }
  }
}

TEST(GuideField, KnowsNothingOfOtherCells) {
  const GuideField field(sums_of_cell(kCell, 1));
  EXPECT_TRUE(none(field.at(cells_at(0, 1, 2, 3, 5), Mask::all()).known));
  EXPECT_TRUE(none(field.at(cells_at(1, 1, 2, 3, 4), Mask::all()).known));
  const GuideField empty{{}};
  EXPECT_TRUE(none(guided_by(empty).known));
  EXPECT_FALSE(empty.any_followed());
}

TEST(GuideField, FewSamplesGuideNobody) {
  std::vector<GuideSum> sums = sums_of_cell(kCell, 1);
  for (GuideSum& sum : sums) sum.count = 1;  // 256, where 1,024 are the least
  EXPECT_FALSE(GuideField(sums).any_followed());
}

TEST(GuideField, CellsOfFewSamplesShareADensity) {
  // Eight neighbours, two of which have light, from different directions.
  std::vector<GuideSum> sums;
  for (std::int32_t i = 0; i < 8; ++i) {
    const std::uint64_t cell = guide_key::cell(0, i & 1, i >> 1 & 1, i >> 2 & 1, 4);
    for (std::uint64_t bin = 0; bin < kGuideBins; ++bin) {
      const bool lit = (i == 0 && bin == 7) || (i == 1 && bin == 200);
      sums.push_back({guide_key::with_bin(cell, bin), lit ? guide_value(1) : 0, 2});
    }
  }
  const GuideField field(added_up(sums));
  const Int first = field.at(cells_at(0, 0, 0, 0, 4), Mask::all()).density;
  for (std::int32_t i = 1; i < 8; ++i) {
    const Guided other = field.at(cells_at(0, i & 1, i >> 1 & 1, i >> 2 & 1, 4), Mask::all());
    EXPECT_TRUE(all(other.known & (other.density == first)));
  }
}

TEST(GuideField, IsNotFollowedWhereItsSquaresAreLarger) {
  std::vector<GuideSum> sums = sums_of_cell(kCell, 1);
  const auto with_squares = [&](double bsdf, double mixed) {
    std::vector<GuideSum> all = sums;
    all.push_back({guide_key::with_bin(kCell, guide_key::kSquares), guide_value(bsdf), 10});
    all.push_back({guide_key::with_bin(kCell, guide_key::kSquares + 1), guide_value(mixed), 10});
    return GuideField(all).any_followed();
  };
  EXPECT_TRUE(with_squares(10, 5));
  EXPECT_TRUE(with_squares(10, 12));
  EXPECT_FALSE(with_squares(10, 13));
}

TEST(GuideDensity, WithoutLightIsEven) {
  const std::vector<GuideTally> dark(kGuideBins, GuideTally{0, 10});
  for (const double share : guide_density(dark)) EXPECT_NEAR(share, 1.0 / kGuideBins, 1e-12);
}

TEST(GuideDensity, LeavesNoBinOut) {
  std::vector<GuideTally> one(kGuideBins, GuideTally{0, 1e6});
  one[37].value = 1e9;
  const std::vector<double> share = guide_density(one);
  EXPECT_THAT(share, Each(Gt(0.0)));
  EXPECT_GT(share[37], 0.99);
}

TEST(GuideSums, AddUpToTheSameBitsInAnyOrder) {
  std::mt19937 random{5};
  std::vector<GuideSum> samples;
  for (int i = 0; i < 20'000; ++i) {
    // Some sums reach the largest number, and stay there: those of so many samples that they can.
    const std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t key = guide_key::with_bin(guide_key::cell(0, random() % 4, 2, 3, 4), random() % 250);
    samples.push_back(i % 50 == 0 ? GuideSum{key, most - random(), std::uint64_t{1} << 28}
                                  : GuideSum{key, guide_value(random() * 0x1p-20), 1});
  }
  const auto merged = [&](std::size_t parts) {
    std::shuffle(samples.begin(), samples.end(), random);
    std::vector<std::string> blobs;
    for (std::size_t part = 0; part < parts; ++part) {
      GuideSums sums(2000);
      for (std::size_t i = part; i < samples.size(); i += parts)
        sums.add(samples[i].key, samples[i].value, samples[i].count);
      blobs.push_back(guide_blob(sums.sorted()));
    }
    std::shuffle(blobs.begin(), blobs.end(), random);
    std::string all = blobs[0];
    for (std::size_t part = 1; part < parts; ++part) {
      const std::array<std::string_view, 2> both{all, blobs[part]};
      std::string next;
      EXPECT_TRUE(merge_guides(both, next));
      all = std::move(next);
    }
    return all;
  };
  const std::string one = merged(1);
  EXPECT_EQ(merged(2), one);
  EXPECT_EQ(merged(16), one);
}

TEST(GuideSums, TakeNoMoreKeysThanAskedFor) {
  GuideSums sums(10);
  for (std::uint64_t key = 0; key < 100; ++key) sums.add(key % 20, 1);
  ASSERT_EQ(sums.sorted().size(), 10u);
  for (const GuideSum& sum : sums.sorted()) EXPECT_EQ(sum.count, 5u);
}

TEST(GuideSums, ValuesThatAreNoneCountAsNothing) {
  EXPECT_EQ(guide_value(std::nan("")), 0u);
  EXPECT_EQ(guide_value(-1), 0u);
  EXPECT_EQ(guide_value(std::numeric_limits<double>::infinity()), guide_value(kMostGuideValue));
}

TEST(GuideSums, DamagedBlobsAreRefused) {
  const std::string sound = guide_blob(sums_of_cell(kCell, 1));
  std::vector<GuideSum> sums;
  EXPECT_TRUE(append_guide_blob(sound, sums));
  EXPECT_TRUE(append_guide_blob("", sums));
  EXPECT_FALSE(append_guide_blob(std::string_view(sound).substr(1), sums));
  std::vector<GuideSum> wrong = sums_of_cell(kCell, 1);
  std::swap(wrong[3], wrong[4]);
  EXPECT_FALSE(append_guide_blob(guide_blob(wrong), sums));
  wrong = sums_of_cell(kCell, 1);
  wrong[9].count = 0;
  EXPECT_FALSE(append_guide_blob(guide_blob(wrong), sums));
  wrong = sums_of_cell(kCell, 1);
  wrong[9].value = guide_value(kMostGuideValue) * wrong[9].count + 1;
  EXPECT_FALSE(append_guide_blob(guide_blob(wrong), sums)) << "more than so many samples add up to";
  wrong = {{guide_key::with_bin(kCell, kGuideBins + guide_key::kSquareSums), 1, 1}};
  EXPECT_FALSE(append_guide_blob(guide_blob(wrong), sums)) << "no such bin";
  wrong = {{guide_key::with_bin(guide_key::cell(0, 1, 2, 3, 6), 0), 1, 1}};
  EXPECT_FALSE(append_guide_blob(guide_blob(wrong), sums)) << "no such side";
  std::string merged;
  const std::array<std::string_view, 1> blobs{std::string_view(sound).substr(3)};
  EXPECT_FALSE(merge_guides(blobs, merged));
}

TEST(GuideCell, TheParentHoldsIt) {
  using guide_key::cell;
  using guide_key::parent;
  EXPECT_EQ(parent(cell(-5, 7, -7, 0, 3)), cell(-4, 3, -4, 0, 3));
  EXPECT_EQ(parent(cell(3, -1, 1, -2, 0)), cell(4, -1, 0, -1, 0));
  EXPECT_EQ(guide_key::cell_of(guide_key::with_bin(cell(3, -1, 1, -2, 0), 255)), cell(3, -1, 1, -2, 0));
  EXPECT_EQ(guide_key::bin_of(guide_key::with_bin(cell(3, -1, 1, -2, 0), 255)), 255);
}

TEST(GuideCell, SidesGrowWithTheDistance) {
  RandomLanes random(3);
  for (int i = 0; i < 100; ++i) {
    const Float scale(std::pow(10.0f, static_cast<float>(i % 13) - 6.0f));
    const Vec3 p{random(-1, 1) * scale, random(-1, 1) * scale, random(-1, 1) * scale};
    const Vec3 n = normalize(Vec3{random(-1, 1), random(-1, 1), random(-1, 1)});
    const GuideCells cells = guide_cells_at(p, n, {random(), random()});
    for (int lane = 0; lane < kWidth; ++lane) {
      const double side = std::ldexp(1.0, cells.size_exponent.lane(lane));
      const double distance = double{length(p).lane(lane)};
      EXPECT_LE(side, distance * double{kGuideCellSize} * 1.0001);
      EXPECT_GT(2 * side, distance * double{kGuideCellSize} * 0.9999);
      // No further away than the shift by half a side.
      const std::pair<Float, Int> axes[] = {{p.x, cells.x}, {p.y, cells.y}, {p.z, cells.z}};
      for (const auto& [place, cell] : axes)
        EXPECT_LE(std::abs((cell.lane(lane) + 0.5) * side - double{place.lane(lane)}), side * 1.0001);
      EXPECT_GE(cells.side.lane(lane), 0);
      EXPECT_LT(cells.side.lane(lane), 6);
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::guide_test
