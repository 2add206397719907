// Metals, glasses and dispersion formulas.
#include <gtest/gtest.h>

#include <complex>

#include "spectra/matter/dispersion.h"
#include "spectra/matter/glasses.h"
#include "spectra/matter/metals.h"

namespace tessera::spectra {
namespace {

struct MeasuredIndex {
  double nm, eta, k;
};

/// [Johnson & Christy 1972]
constexpr MeasuredIndex kGoldIndices[] = {{450.9, 1.38, 1.914},
                                          {495.9, 1.04, 1.833},
                                          {548.6, 0.43, 2.455},
                                          {616.8, 0.21, 3.272},
                                          {704.5, 0.13, 4.103}};
constexpr MeasuredIndex kCopperIndices[] = {{450.9, 1.24, 2.397},
                                            {495.9, 1.22, 2.564},
                                            {548.6, 1.02, 2.577},
                                            {616.8, 0.30, 3.205},
                                            {704.5, 0.21, 4.205}};
/// [Rakic 1995]
constexpr MeasuredIndex kAluminiumIndices[] = {{442.80, 0.60790, 5.3676},
                                               {516.60, 0.87340, 6.2418},
                                               {563.57, 1.0728, 6.7839},
                                               {619.93, 1.3660, 7.4052},
                                               {688.81, 1.8301, 8.0601}};

double table_reflectance(const char* name, double nm) {
  const Metal metal = *find_metal(name);
  return normal_reflectance(metal.eta.at(nm), metal.k.at(nm));
}

TEST(Metals, ReflectAsOtherMeasurementsSay) {
  // Films of one metal that others made and measured differ by so much.
  for (const MeasuredIndex& m : kGoldIndices)
    EXPECT_NEAR(table_reflectance("Au", m.nm), normal_reflectance(m.eta, m.k), 0.06) << m.nm;
  for (const MeasuredIndex& m : kCopperIndices)
    EXPECT_NEAR(table_reflectance("Cu", m.nm), normal_reflectance(m.eta, m.k), 0.06) << m.nm;
  for (const MeasuredIndex& m : kAluminiumIndices)
    EXPECT_NEAR(table_reflectance("Al", m.nm), normal_reflectance(m.eta, m.k), 0.01) << m.nm;
}

TEST(Metals, NormalReflectanceIsFresnels) {
  // The square of the amplitude's (n - 1) / (n + 1), with a complex n.
  const auto expect_fresnel = [](const MeasuredIndex& m) {
    const std::complex<double> n(m.eta, m.k);
    EXPECT_NEAR(normal_reflectance(m.eta, m.k), std::norm((n - 1.0) / (n + 1.0)), 1e-14) << m.nm;
  };
  for (const MeasuredIndex& m : kGoldIndices) expect_fresnel(m);
  for (const MeasuredIndex& m : kCopperIndices) expect_fresnel(m);
  for (const MeasuredIndex& m : kAluminiumIndices) expect_fresnel(m);
  EXPECT_DOUBLE_EQ(normal_reflectance(1.5, 0), 0.04);
}

TEST(Metals, AreWholeWithTheirSources) {
  for (const char* name : {"Ag", "Al", "Au", "Cr", "Cu", "CuZn", "Fe", "MgO", "Ni", "Ti", "TiO2"}) {
    const std::optional<Metal> metal = find_metal(name);
    ASSERT_TRUE(metal.has_value()) << name;
    EXPECT_TRUE(check_curve(metal->eta).ok()) << name;
    EXPECT_TRUE(check_curve(metal->k).ok()) << name;
    EXPECT_FALSE(metal->source.empty()) << name;
  }
  EXPECT_FALSE(find_metal("Unobtainium").has_value());
  EXPECT_FALSE(find_metal("").has_value());
}

TEST(Dispersion, HasTheMakersIndexAtTheHeliumLine) {
  // n_d, at 587.5618 nm, and Abbe's number (n_d - 1) / (n_F - n_C) with the lines of hydrogen, in Schott's
  // catalogue.
  struct Glass {
    const char* name;
    double nd, abbe;
  };
  for (const Glass& glass : {Glass{"N-BK7", 1.5168, 64.17},
                             {"N-BAF10", 1.67003, 47.11},
                             {"N-FK51A", 1.48656, 84.47},
                             {"N-LASF9", 1.85025, 32.17},
                             {"N-SF11", 1.78472, 25.68},
                             {"F2", 1.62004, 36.37},
                             {"F5", 1.60342, 38.03},
                             {"SF5", 1.6727, 32.21},
                             {"SF10", 1.72825, 28.41},
                             {"SF11", 1.78472, 25.76}}) {
    const std::optional<Dispersion> dispersion = find_dispersion(glass.name);
    ASSERT_TRUE(dispersion.has_value()) << glass.name;
    EXPECT_NEAR(dispersion->eta(587.5618), glass.nd, 6e-6) << glass.name;
    EXPECT_NEAR((glass.nd - 1) / (dispersion->eta(486.1327) - dispersion->eta(656.2725)), glass.abbe, 0.006)
        << glass.name;
  }
}

TEST(Dispersion, OtherMaterials) {
  // At the sodium line: 1.4585 for fused silica [Malitson 1965], 2.417 for diamond; 1.3330 for water at 20 C
  // against air, whose own is 1.00027.
  EXPECT_NEAR(find_dispersion("fused silica")->eta(587.6), 1.4585, 1e-4);
  EXPECT_NEAR(find_dispersion("diamond")->eta(589.3), 2.417, 1e-3);
  EXPECT_NEAR(find_dispersion("water")->eta(589.3), 1.3330 * 1.00027, 1e-4);
  EXPECT_NEAR(find_dispersion("sapphire")->eta(589.3), 1.768, 1e-3);
  // Cauchy's formula: 1.35265 + 0.00306 / 0.5893^2 + 0.00002 / 0.5893^4.
  EXPECT_NEAR(find_dispersion("ethanol")->eta(589.3), 1.36163, 1e-5);
  // Beyond the measurements it stays as at their ends.
  EXPECT_EQ(find_dispersion("ethanol")->eta(300), find_dispersion("ethanol")->eta(476.5));
  EXPECT_FALSE(find_dispersion("BK7").has_value());
}

TEST(Dispersion, FormulasOfNumbers) {
  const Dispersion cauchy = cauchy_dispersion(1.5, 0.004, 0.0002);
  EXPECT_NEAR(cauchy.eta(500), 1.5 + 0.004 / 0.25 + 0.0002 / 0.0625, 1e-12);
  const Dispersion abbe = abbe_dispersion(1.62, 36.3);
  EXPECT_NEAR(abbe.eta(587.56), 1.62, 1e-12);
  EXPECT_NEAR((1.62 - 1) / (abbe.eta(486.13) - abbe.eta(656.27)), 36.3, 1e-9);
}

TEST(Dispersion, NamesAreThoseThatAreFound) {
  for (const std::string& name : dispersion_names()) EXPECT_TRUE(find_dispersion(name).has_value()) << name;
  EXPECT_EQ(dispersion_names().size(), 15u);
}

TEST(Dispersion, TablesOfPbrtFollowTheFormulas) {
  // The tables have one formula's values at their samples, of glasses from other years: they agree to 1e-4.
  const auto expect_same = [](const char* table_name, const char* formula_name) {
    const Curve table = *find_glass(table_name);
    const Dispersion formula = *find_dispersion(formula_name);
    for (std::size_t i = 0; i < table.nm.size(); ++i) {
      // Wavelengths are rounded to a nanometre there.
      if (table.nm[i] > 430) {
        EXPECT_NEAR(table.values[i], formula.eta(table.nm[i]), 2e-4) << table_name << " " << table.nm[i];
      }
    }
  };
  expect_same("BK7", "N-BK7");
  expect_same("FK51A", "N-FK51A");
  expect_same("BAF10", "N-BAF10");
}

}  // namespace
}  // namespace tessera::spectra
