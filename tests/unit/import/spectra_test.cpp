#include "import/spectra/named_spectra.h"

#include "gtest/gtest.h"
#include "import/spectra/photometry.h"

namespace tessera::client {
namespace {

double value_of(std::string_view name, double nm) {
  const std::optional<SpectrumTable> table = find_named_spectrum(name);
  EXPECT_TRUE(table.has_value()) << name;
  return table ? evaluate(*table, nm) : 0;
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
    const std::optional<SpectrumTable> table = find_named_spectrum(name);
    ASSERT_TRUE(table.has_value()) << name;
    ASSERT_EQ(table->wavelengths_nm.size(), table->values.size()) << name;
    for (std::size_t i = 1; i < table->values.size(); ++i) {
      EXPECT_GT(table->wavelengths_nm[i], table->wavelengths_nm[i - 1]) << name;
    }
    // A table that lost an entry would end in a zero.
    if (!name.ends_with("-k")) {
      EXPECT_GT(table->values.back(), 0) << name;
    }
  }
  for (const char* unknown : {"metal-Unobtainium-eta", "metal-Cu", "glass-", "stdillum-F13", "stdillum-acesD60", ""}) {
    EXPECT_FALSE(find_named_spectrum(unknown).has_value()) << unknown;
  }
}

TEST(NamedSpectra, KnownValues) {
  // The sodium D line, 589.3 nm: Schott's n_D of BK7 is 1.51673, of SF11 1.78446. The tables are linear over 22 nm,
  // where the dispersion's curvature leaves less than 2e-4.
  EXPECT_NEAR(value_of("glass-BK7", 589.3), 1.51673, 2e-4);
  EXPECT_NEAR(value_of("glass-SF11", 589.3), 1.78446, 4e-4);
  // Gold turns from absorbing to reflecting at 500 nm.
  EXPECT_NEAR(value_of("metal-Au-eta", 495.94), 0.916, 1e-3);
  EXPECT_NEAR(value_of("metal-Au-k", 652.55), 3.15, 1e-3);
  EXPECT_NEAR(value_of("metal-Cu-eta", 563.56), 0.826, 1e-3);
}

TEST(NamedSpectra, FluorescentLampsKeepTheirMercuryLines) {
  for (int i = 1; i <= 12; ++i) {
    const std::string name = "stdillum-F" + std::to_string(i);
    EXPECT_GT(value_of(name, 435), 2 * value_of(name, 425)) << name;
    EXPECT_GT(value_of(name, 545), 1.5 * value_of(name, 535)) << name;
  }
}

TEST(Photometry, LuminanceIsNormalised) {
  EXPECT_DOUBLE_EQ(luminance([](double) { return 1.0; }), 1);
  for (const char* name : {"stdillum-A", "stdillum-D65", "stdillum-F4"}) {
    // Tables hold floats: 24 bits.
    EXPECT_NEAR(luminance(*find_named_spectrum(name)), 1, 1e-6) << name;
  }
}

TEST(Photometry, BlackbodyPeaksAtWiensWavelength) {
  // Wien's displacement: 2897771.955 nm K.
  const double peak = 2897771.955 / 5000;
  EXPECT_NEAR(normalized_blackbody(peak, 5000), 1, 1e-9);
  EXPECT_LT(normalized_blackbody(peak - 20, 5000), 1);
  EXPECT_LT(normalized_blackbody(peak + 20, 5000), 1);
}

}  // namespace
}  // namespace tessera::client
