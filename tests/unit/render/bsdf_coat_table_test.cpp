#include "render/bsdf/coat_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render/bsdf/boundary_energy.h"

namespace tessera::render {
namespace {

double interpolated_transmittance(const float* table, double cosine, double alpha) {
  const double row = std::sqrt(alpha) * (kCoatAlphas - 1), column = std::sqrt(cosine) * (kCoatCosines - 1);
  const int r = std::min(static_cast<int>(row), kCoatAlphas - 2);
  const int c = std::min(static_cast<int>(column), kCoatCosines - 2);
  const auto entry = [&](int i, int j) { return table[kCoatTransmittance + i * kCoatCosines + j]; };
  return std::lerp(std::lerp(entry(r, c), entry(r, c + 1), column - c),
                   std::lerp(entry(r + 1, c), entry(r + 1, c + 1), column - c), row - r);
}

TEST(CoatTable, SmoothRowIsFresnel) {
  MaterialTable table;
  append_coat_table(1.5f, table);
  // The average Fresnel reflectance of index 1.5 is 0.0918 [Egan & Hilgeman 1973]; R_int = 1 - (1 - 0.0918) / 2.25.
  EXPECT_NEAR(table.coat_tables[kCoatInternal], 1 - (1 - 0.0918) / 2.25, 0.5e-4 / 2.25 + 1e-5);
  EXPECT_NEAR(table.coat_tables[kCoatTransmittance + kCoatCosines - 1], 0.96, 1e-6);
}

TEST(CoatTable, InterpolationIsAccurate) {
  // What coat_table.h says, for cosines from 0.01 on; other indices are alike.
  for (const float eta : {1.3f, 1.5f, 2.2f}) {
    MaterialTable table;
    append_coat_table(eta, table);
    double worst = 0, sum = 0;
    int count = 0;
    for (double alpha = 0.002; alpha < 1; alpha *= 1.3) {
      for (double cosine = 0.01; cosine < 1; cosine += 0.0171) {
        const double exact = boundary_energy(cosine, {alpha}, eta).transmitted;
        const double error = std::abs(interpolated_transmittance(table.coat_tables.data(), cosine, alpha) - exact);
        worst = std::max(worst, error);
        sum += error;
        ++count;
      }
    }
    EXPECT_LT(worst, 6e-3) << "eta " << eta;
    EXPECT_LT(sum / count, 4e-4) << "eta " << eta;
  }
}

TEST(CoatTable, BoundariesCreateNoEnergy) {
  for (const double eta : {1 / 1.5, 1.0, 1.5, 3.0}) {
    for (const double alpha : {0.0, 0.01, 0.3, 1.0}) {
      for (const double cosine : {1e-9, 0.01, 0.5, 1.0}) {
        const BoundaryEnergy energy = boundary_energy(cosine, {alpha}, eta);
        EXPECT_GE(energy.reflected, 0);
        EXPECT_GE(energy.transmitted, 0);
        EXPECT_LE(energy.reflected + energy.transmitted, 1 + 1e-6);
      }
    }
  }
}

TEST(CoatTable, OneTableAnIndex) {
  MaterialTable table;
  EXPECT_EQ(append_coat_table(1.5f, table), 0);
  EXPECT_EQ(append_coat_table(1.3f, table), kCoatTableSize);
  EXPECT_EQ(append_coat_table(1.5f, table), 0);
  EXPECT_EQ(table.coat_tables.size(), 2u * kCoatTableSize);
}

}  // namespace
}  // namespace tessera::render
