#include "render/core/wide.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace tessera::render::TESSERA_ISA {
namespace {

TEST(Mask, BitsRoundTrip) {
  for (const std::uint32_t bits : {0u, 1u, 0x8000u, 0xffffu, 0x1234u, 0xa5a5u}) {
    const Mask m = Mask::from_bits(bits);
    EXPECT_EQ(m.bits(), bits);
    EXPECT_EQ(count(m), __builtin_popcount(bits));
    EXPECT_EQ(none(m), bits == 0);
    EXPECT_EQ(all(m), bits == 0xffff);
  }
  for (int n = 0; n <= 16; ++n) EXPECT_EQ(Mask::first(n).bits(), (1u << n) - 1);
  EXPECT_EQ(Mask::first(-3).bits(), 0u);
  EXPECT_EQ(Mask::first(99).bits(), 0xffffu);
}

TEST(Wide, CompareAndSelectActLaneByLane) {
  const Int i = Int::iota();
  EXPECT_EQ((i < 5).bits(), 0x001fu);
  EXPECT_EQ((i >= 5).bits(), 0xffe0u);
  EXPECT_EQ((i <= 5).bits(), 0x003fu);
  EXPECT_EQ((i == 5).bits(), 0x0020u);
  const Int chosen = select(i > 7, i, Int(-1));
  EXPECT_EQ(chosen.lane(7), -1);
  EXPECT_EQ(chosen.lane(8), 8);
}

TEST(Wide, CompressStoreKeepsOrderAndWritesNothingElse) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    const std::uint32_t bits = random() & 0xffff;
    std::vector<float> out(kWidth + 1, -1.0f);
    const int n = compress_store(Float::iota(), Mask::from_bits(bits), out.data());
    ASSERT_EQ(n, __builtin_popcount(bits));
    int expected = 0;
    for (int i = 0; i < kWidth; ++i) {
      if (!(bits >> i & 1)) continue;
      EXPECT_EQ(out[static_cast<std::size_t>(expected++)], static_cast<float>(i));
    }
    // The wavefront relies on it that entries behind the last one written are still to be read.
    for (int i = n; i <= kWidth; ++i) EXPECT_EQ(out[static_cast<std::size_t>(i)], -1.0f);
  }
}

TEST(Wide, GatherReadsActiveLanesOnly) {
  const std::vector<float> table = {10, 11, 12, 13};
  const Int index = select(Mask::first(4), Int::iota(), Int(1 << 30));
  const Float values = gather(table.data(), index, Mask::first(4));
  for (int i = 0; i < 4; ++i) EXPECT_EQ(values.lane(i), 10.0f + static_cast<float>(i));
  EXPECT_EQ(values.lane(4), 0.0f);
}

TEST(Wide, GatherOfRowsIsFourGathers) {
  std::vector<float> floats(64);
  std::vector<std::int32_t> ints(64);
  for (int i = 0; i < 64; ++i)
    floats[static_cast<std::size_t>(i)] = 0.5f * static_cast<float>(ints[static_cast<std::size_t>(i)] = i);
  // Rows may begin anywhere; lanes that are not active may have any index.
  const Mask active = Mask::first(13);
  const Int index = select(active, (Int::iota() & 7) * 7 + 1, Int(1 << 30));
  const Float4 of_floats = gather4(floats.data(), index, active);
  const Int4 of_ints = gather4(ints.data(), index, active);
  for (int lane = 0; lane < 13; ++lane) {
    for (int c = 0; c < 4; ++c) {
      EXPECT_EQ(of_ints.c[c].lane(lane), (lane & 7) * 7 + 1 + c);
      EXPECT_EQ(of_floats.c[c].lane(lane), 0.5f * static_cast<float>((lane & 7) * 7 + 1 + c));
    }
  }
}

TEST(Wide, CommonValueIsThatOfAllActiveLanes) {
  const Int values = select(Mask::first(9), Int(5), Int::iota());
  EXPECT_EQ(common_value(values, Mask::first(9)), 5);
  EXPECT_EQ(common_value(values, ~Mask::first(15)), 15);
  EXPECT_EQ(common_value(values, Mask::all()), std::nullopt);
  EXPECT_EQ(common_value(values, Mask::none()), std::nullopt);
}

TEST(Wide, EveryDistinctKeyIsVisitedOnceWithItsLanes) {
  const Int keys = Int::iota() & 3;
  std::uint32_t seen = 0;
  int visits = 0;
  for_each_distinct(keys, Mask::first(10), [&](std::int32_t key, Mask lanes) {
    EXPECT_EQ(lanes.bits(), (0x1111u << key) & 0x3ffu);
    EXPECT_EQ(seen & lanes.bits(), 0u);
    seen |= lanes.bits();
    ++visits;
  });
  EXPECT_EQ(visits, 4);
  EXPECT_EQ(seen, 0x3ffu);
}

TEST(Wide, ReverseBitsMatchesTheDefinition) {
  std::mt19937 random(2);
  for (int round = 0; round < 100; ++round) {
    const std::uint32_t x = static_cast<std::uint32_t>(random());
    std::uint32_t expected = 0;
    for (int i = 0; i < 32; ++i) expected |= (x >> i & 1) << (31 - i);
    EXPECT_EQ(reverse_bits(UInt(x)).lane(round % kWidth), expected);
  }
}

TEST(Wide, UnitFloatsStayBelowOne) {
  EXPECT_EQ(to_unit_float(UInt(0u)).lane(0), 0.0f);
  EXPECT_LT(to_unit_float(UInt(0xffffffffu)).lane(0), 1.0f);
}

TEST(Wide, ElementaryFunctionsAgreeWithTheLibrary) {
  // Highway promises a few units in the last place; 1e-5 relative leaves room for range reduction.
  for (float x = -3.1f; x < 3.1f; x += 0.01f) {
    EXPECT_NEAR(sin(Float(x)).lane(3), std::sin(x), 2e-6f);
    EXPECT_NEAR(cos(Float(x)).lane(3), std::cos(x), 2e-6f);
    EXPECT_NEAR(exp(Float(x)).lane(3), std::exp(x), 1e-5f * std::exp(x));
    EXPECT_NEAR(atan2(Float(x), Float(0.7f)).lane(3), std::atan2(x, 0.7f), 2e-6f);
    EXPECT_NEAR(atan2(Float(x), Float(-0.7f)).lane(3), std::atan2(x, -0.7f), 2e-6f);
  }
  EXPECT_EQ(atan2(Float(0.0f), Float(0.0f)).lane(0), 0.0f);
  EXPECT_NEAR(pow(Float(2.5f), Float(1.7f)).lane(0), std::pow(2.5f, 1.7f), 1e-4f);
}

TEST(Wide, DifferenceOfProductsSurvivesCancellation) {
  // a b - c d with products that agree in all but their last bits.
  const float a = 1.0f + 0x1p-12f, b = 1.0f - 0x1p-12f;
  const double exact = double{a} * b - 1.0;
  EXPECT_FLOAT_EQ(difference_of_products(Float(a), Float(b), Float(1.0f), Float(1.0f)).lane(0),
                  static_cast<float>(exact));
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
