#include "render/bsdf/tables/balance_table.h"

#include <gtest/gtest.h>

namespace tessera::render {
namespace {

const float* factors(const MaterialTable& table, int side, int row) {
  return table.coat_tables.data() + kBalanceFactors + (side * kBalanceRows + row) * kBalanceCosines;
}

TEST(BalanceTable, RowsOfOneRoughnessAreAlike) {
  MaterialTable table;
  EXPECT_EQ(append_balance_table({.alpha_x = 0.4f, .alpha_y = 0.4f, .eta = 1.5f}, table), 0);
  EXPECT_EQ(table.coat_tables[kBalancePerRow], 0);
  for (int side = 0; side < 2; ++side) {
    for (int c = 0; c < kBalanceCosines; ++c)
      EXPECT_EQ(factors(table, side, 0)[c], factors(table, side, kBalanceRows - 1)[c]);
  }
}

TEST(BalanceTable, SmoothRowLosesNothingAndRougherOnesMore) {
  MaterialTable table;
  append_balance_table({.textured = true}, table);
  for (int c = 0; c < kBalanceCosines; ++c) EXPECT_EQ(factors(table, 0, 0)[c], 1);
  for (int r = 1; r < kBalanceRows; ++r) {
    EXPECT_LE(table.coat_tables[kBalanceKept + r], table.coat_tables[kBalanceKept + r - 1] + 1e-4f);
    for (int c = 0; c < kBalanceCosines; ++c) {
      // About half is lost at most, and not everywhere, so that no factor is far from 1.
      EXPECT_GT(factors(table, 0, r)[c], 0.7f);
      EXPECT_LT(factors(table, 0, r)[c], 2.2f);
    }
  }
}

TEST(BalanceTable, FacetsTurnedByARightAngleHaveTheSameFactors) {
  MaterialTable table;
  append_balance_table({.alpha_x = 0.2f, .alpha_y = 0.7f}, table);
  MaterialTable turned;
  append_balance_table({.alpha_x = 0.7f, .alpha_y = 0.2f}, turned);
  ASSERT_EQ(table.coat_tables.size(), turned.coat_tables.size());
  // The quadrature's points are not turned with the facets; it is right to about 1e-3.
  for (std::size_t i = 0; i < table.coat_tables.size(); ++i)
    EXPECT_NEAR(table.coat_tables[i], turned.coat_tables[i], 4e-3f) << i;
}

}  // namespace
}  // namespace tessera::render
