#include "spectra/named_spectra.h"

#include "gtest/gtest.h"
#include "spectra/light/planck.h"
#include "spectra/matter/metal_colors.h"
#include "spectra/rgb/mitsuba_rgb.h"
#include "spectra/rgb/pbrt_luminance.h"

namespace tessera::spectra {
namespace {

double value_of(std::string_view name, double nm) {
  const std::optional<Curve> table = find_named_spectrum(name);
  EXPECT_TRUE(table.has_value()) << name;
  return table ? table->at(nm) : 0;
}

TEST(NamedSpectra, TablesAreWholeAndAscend) {
  std::vector<std::string> names = {"illum-acesD60", "stdillum-A", "stdillum-D50", "stdillum-D65"};
  for (int i = 1; i <= 12; ++i) names.push_back("stdillum-F" + std::to_string(i));
  for (const char* metal : {"Ag", "Al", "Au", "Cu", "CuZn", "MgO", "TiO2"}) {
    for (const char* part : {"-eta", "-k"}) names.push_back(std::string("metal-") + metal + part);
  }
  for (const char* glass : {"BK7", "BAF10", "FK51A", "LASF9", "F5", "F10", "F11", "SF5", "SF10", "SF11"}) {
    names.push_back(std::string("glass-") + glass);
  }
  for (const std::string& name : names) {
    const std::optional<Curve> table = find_named_spectrum(name);
    ASSERT_TRUE(table.has_value()) << name;
    ASSERT_EQ(table->nm.size(), table->values.size()) << name;
    for (std::size_t i = 1; i < table->values.size(); ++i) {
      EXPECT_GT(table->nm[i], table->nm[i - 1]) << name;
    }
    // A table that lost an entry would end in a zero.
    if (!name.ends_with("-k")) {
      EXPECT_GT(table->values.back(), 0) << name;
    }
  }
  for (const char* unknown :
       {"metal-Unobtainium-eta", "metal-Cu", "glass-", "stdillum-F13", "stdillum-acesD60", ""}) {
    EXPECT_FALSE(find_named_spectrum(unknown).has_value()) << unknown;
  }
}

TEST(NamedSpectra, KnownValues) {
  // The sodium D line, 589.3 nm: Schott's n_D of BK7 is 1.51673, of SF11 1.78446. The tables are linear over
  // 22 nm, where the dispersion's curvature leaves less than 2e-4.
  EXPECT_NEAR(value_of("glass-BK7", 589.3), 1.51673, 2e-4);
  EXPECT_NEAR(value_of("glass-SF11", 589.3), 1.78446, 4e-4);
  // Gold turns from absorbing to reflecting at 500 nm.
  EXPECT_NEAR(value_of("metal-Au-eta", 495.94), 0.916, 1e-3);
  EXPECT_NEAR(value_of("metal-Au-k", 652.55), 3.15, 1e-3);
  EXPECT_NEAR(value_of("metal-Cu-eta", 563.56), 0.826, 1e-3);
}

/// The table's colours were integrated elsewhere; what is here as a spectrum tells whether in the same way.
/// Other colour matching tables, other steps and rounding: 0.5 %.
void expect_color(const std::array<double, 3>& found, const std::array<double, 3>& expected) {
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(found[c], expected[c], 5e-3 * expected[c]) << "component " << c;
}

TEST(MetalColors, AreIntegratedAsTheSpectraHere) {
  // Tungsten's colours of metals that are here as spectra.
  const auto color = [](const char* name) {
    return mitsuba_rgb(*find_named_spectrum(name), SeenUnder::kEqualEnergy);
  };
  expect_color(color("metal-Ag-eta"), {0.15526, 0.11672, 0.13838});
  expect_color(color("metal-Ag-k"), {4.8283, 3.1222, 2.147});
  expect_color(color("metal-Al-eta"), {1.6575, 0.88037, 0.52123});
  expect_color(color("metal-Al-k"), {9.2239, 6.2695, 4.837});
  expect_color(color("metal-Au-eta"), {0.14312, 0.37496, 1.4425});
  expect_color(color("metal-Au-k"), {3.9832, 2.3857, 1.6032});
  expect_color(color("metal-Cu-eta"), {0.20044, 0.92403, 1.1022});
  expect_color(color("metal-Cu-k"), {3.9129, 2.4528, 2.1422});
  // Tungsten, the metal, the other way round: Luxpop's measurements against the table.
  Curve tungsten;
  tungsten.nm = {359.362, 364.647, 370.09,  375.697, 381.477, 387.438, 393.587, 399.935, 406.492, 413.267,
                 420.271, 427.517, 435.018, 442.786, 450.836, 459.185, 467.849, 476.846, 486.196, 495.92,
                 506.041, 516.583, 527.575, 539.044, 551.022, 563.545, 576.651, 590.381, 604.781, 619.9,
                 635.795, 652.526, 670.162, 688.778, 708.457, 729.294, 751.394, 774.875, 799.871, 826.533};
  tungsten.values = {3.32, 3.39, 3.43, 3.45, 3.45, 3.43, 3.41, 3.39, 3.37, 3.35, 3.33, 3.32, 3.31, 3.3,
                     3.31, 3.31, 3.32, 3.34, 3.35, 3.38, 3.42, 3.45, 3.48, 3.5,  3.5,  3.49, 3.51, 3.54,
                     3.57, 3.6,  3.65, 3.7,  3.76, 3.82, 3.85, 3.84, 3.78, 3.67, 3.56, 3.48};
  expect_color(mitsuba_rgb(tungsten, SeenUnder::kEqualEnergy), find_metal_color("W")->eta);
}

TEST(MetalColors, AllOfMitsubasConductorsAreThere) {
  for (const char* name :
       {"a-C",      "Ag",   "Al",       "AlAs", "AlSb", "Au",     "Be",  "Cr",      "CsI", "Cu",
        "Cu2O",     "CuO",  "d-C",      "Hg",   "HgTe", "Ir",     "K",   "Li",      "MgO", "Mo",
        "Na_palik", "Nb",   "Ni_palik", "Rh",   "Se",   "Se-e",   "SiC", "SnTe",    "Ta",  "Te",
        "Te-e",     "ThF4", "TiC",      "TiN",  "TiO2", "TiO2-e", "VC",  "V_palik", "VN",  "W"}) {
    const bool spectrum = find_named_spectrum(std::string("metal-") + name + "-eta").has_value();
    const std::optional<MetalColor> color = find_metal_color(name);
    ASSERT_NE(spectrum, color.has_value()) << name;
    if (!color) continue;
    for (const double component : color->eta) EXPECT_GE(component, 0) << name;
    for (const double component : color->k) EXPECT_GE(component, 0) << name;
    EXPECT_GT(color->eta[1], 0) << name;
  }
  EXPECT_FALSE(find_metal_color("Unobtainium").has_value());
}

TEST(NamedSpectra, FluorescentLampsKeepTheirMercuryLines) {
  for (int i = 1; i <= 12; ++i) {
    const std::string name = "stdillum-F" + std::to_string(i);
    EXPECT_GT(value_of(name, 435), 2 * value_of(name, 425)) << name;
    EXPECT_GT(value_of(name, 545), 1.5 * value_of(name, 535)) << name;
  }
}

TEST(Photometry, LuminanceIsNormalised) {
  EXPECT_DOUBLE_EQ(pbrt_luminance([](double) { return 1.0; }), 1);
  for (const char* name : {"stdillum-A", "stdillum-D65", "stdillum-F4"}) {
    // Tables hold floats: 24 bits.
    EXPECT_NEAR(pbrt_luminance(*find_named_spectrum(name)), 1, 1e-6) << name;
  }
}

TEST(Photometry, BlackbodyPeaksAtWiensWavelength) {
  // Wien's displacement: 2897771.955 nm K.
  const double peak = 2897771.955 / 5000;
  EXPECT_NEAR(relative_planck(peak, 5000), 1, 1e-9);
  EXPECT_LT(relative_planck(peak - 20, 5000), 1);
  EXPECT_LT(relative_planck(peak + 20, 5000), 1);
}

}  // namespace
}  // namespace tessera::spectra
