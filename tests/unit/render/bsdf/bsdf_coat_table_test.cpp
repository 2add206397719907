#include "render/bsdf/tables/coat_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "render/bsdf/tables/boundary_energy.h"

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
  append_coat_table(1.5f, 0, table);
  // The average Fresnel reflectance of index 1.5 is 0.0918 [Egan & Hilgeman 1973]; R_int = 1 - (1 - 0.0918)
  // / 2.25.
  EXPECT_NEAR(table.coat_tables[kCoatInternal], 1 - (1 - 0.0918) / 2.25, 0.5e-4 / 2.25 + 1e-5);
  EXPECT_NEAR(table.coat_tables[kCoatTransmittance + kCoatCosines - 1], 0.96, 1e-6);
}

TEST(CoatTable, InterpolationIsAccurate) {
  // Accuracy that coat_table.h states, for cosines from 0.01 on; other indices are alike.
  for (const float eta : {1.3f, 1.5f, 2.2f}) {
    MaterialTable table;
    append_coat_table(eta, 0, table);
    double worst = 0, sum = 0;
    int count = 0;
    for (double alpha = 0.002; alpha < 1; alpha *= 1.3) {
      for (double cosine = 0.01; cosine < 1; cosine += 0.0171) {
        const double exact = boundary_energy(cosine, {alpha}, eta).transmitted;
        const double error =
            std::abs(interpolated_transmittance(table.coat_tables.data(), cosine, alpha) - exact);
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

/// Fresnel reflectance for unpolarised light; `eta` is the index beyond over that of this side.
double fresnel(double cosine, double eta) {
  const double sin2 = (1 - cosine * cosine) / (eta * eta);
  if (sin2 >= 1) return 1;
  const double c = std::sqrt(1 - sin2);
  const double s = (cosine - eta * c) / (cosine + eta * c), p = (eta * cosine - c) / (eta * cosine + c);
  return (s * s + p * p) / 2;
}

TEST(CoatTable, AbsorptionAgreesWithAWalkBetweenCoatAndBase) {
  // Light along the normal enters a smooth coat of index 1.5 over a base of reflectance rho, and is followed
  // until it leaves or is absorbed; the coat takes exp(-d / cos) of it at each crossing.
  constexpr double kEta = 1.5, kThickness = 0.1, kRho = 0.8;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform;
  constexpr int kWalks = 400000;
  double walked = 0;
  for (int i = 0; i < kWalks; ++i) {
    double weight = (1 - fresnel(1, kEta)) * std::exp(-kThickness);
    for (;;) {
      weight *= kRho;
      const double cosine = std::sqrt(1 - uniform(random));  // Lambertian
      weight *= std::exp(-kThickness / cosine);
      if (uniform(random) >= fresnel(cosine, 1 / kEta)) break;
      weight *= std::exp(-kThickness / cosine);
    }
    walked += weight;
  }
  walked /= kWalks;

  MaterialTable table;
  append_coat_table(1.5f, 0.1f, table);
  double out = 0;  // part of the diffuse light from the base that leaves at once
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double cosine = (i + 0.5) / kSteps;
    out += 2 * cosine / kSteps * (1 - fresnel(cosine, 1 / kEta)) * std::exp(-kThickness / cosine);
  }
  const double entered = table.coat_tables[kCoatTransmittance + kCoatCosines - 1];
  const double closed = entered * kRho * out / (1 - kRho * table.coat_tables[kCoatInternal]);
  // The walks' deviation is at most 0.3 each, so 0.0005 of their mean; R_int is right to 2e-5 (test above).
  EXPECT_NEAR(closed, walked, 4 * 0.0005 + 1e-4);
}

TEST(CoatTable, OneTableAnIndexAndThickness) {
  MaterialTable table;
  EXPECT_EQ(append_coat_table(1.5f, 0, table), 0);
  EXPECT_EQ(append_coat_table(1.3f, 0, table), kCoatTableSize);
  EXPECT_EQ(append_coat_table(1.5f, 0, table), 0);
  EXPECT_EQ(append_coat_table(1.5f, 0.01f, table), 2 * kCoatTableSize);
  EXPECT_EQ(table.coat_tables.size(), 3u * kCoatTableSize);
}

}  // namespace
}  // namespace tessera::render
