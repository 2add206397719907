#include "spectra/light/daylight.h"

#include <gtest/gtest.h>

#include "spectra/color/tristimulus.h"
#include "spectra/light/illuminants.h"

namespace tessera::spectra {
namespace {

TEST(Daylight, D65IsTheDaylightOfItsTemperature) {
  const Curve formula = *daylight(6500 * 1.4388 / 1.4380), table = illuminant_d65();
  // The table was computed from factors with more digits than three: 5e-4 times up to 42, and 5e-4 times up
  // to 10.
  for (std::size_t i = 0; i < table.nm.size(); ++i)
    EXPECT_NEAR(formula.values[i], table.values[i], 0.05) << table.nm[i];
}

TEST(Daylight, NominalOnesAreThePublishedTables) {
  // [CIE 15:2004], with three digits.
  const Curve d50 = *find_illuminant("D50"), d55 = *find_illuminant("D55");
  const float nm[] = {300, 350, 400, 450, 500, 550, 560, 600, 650, 700, 750, 780};
  const double d50_published[] = {0.019, 21.010, 49.308, 87.247, 95.724, 102.317,
                                  100,   97.688, 95.667, 91.604, 78.230, 78.274};
  const double d55_published[] = {0.024, 27.817, 60.949, 97.993, 100.680, 102.968,
                                  100,   94.419, 88.854, 82.840, 71.880,  71.818};
  for (std::size_t i = 0; i < std::size(nm); ++i) {
    EXPECT_NEAR(d50.at(nm[i]), d50_published[i], 6e-4) << nm[i];
    EXPECT_NEAR(d55.at(nm[i]), d55_published[i], 6e-4) << nm[i];
  }
}

TEST(Daylight, IsForTemperaturesOfTheSky) {
  EXPECT_TRUE(daylight(4000).has_value());
  EXPECT_TRUE(daylight(25000).has_value());
  EXPECT_FALSE(daylight(3999).has_value());
  EXPECT_FALSE(daylight(25001).has_value());
  EXPECT_FALSE(daylight(-1).has_value());
  // Both polynomials meet at 7000 K, and the bluer is the hotter.
  EXPECT_NEAR(daylight(7000)->at(400), daylight(7000.01)->at(400), 0.3);
  EXPECT_GT(daylight(20000)->at(400), daylight(7000)->at(400));
}

TEST(Daylight, OfUnitLuminanceIsSo) { EXPECT_NEAR(tristimulus(unit_d65(), cie1931())[1], 1, 1e-6); }

TEST(Daylight, PbrtsD50IsAnother) {
  EXPECT_NEAR(pbrt_d50().at(600), 91.6744, 1e-4);
  EXPECT_NEAR(find_illuminant("D50")->at(600), 97.688, 1e-3);
}

TEST(Illuminants, UnknownNamesAreNothing) {
  for (const char* name : {"", "B", "D", "D51", "F0", "F13", "LED", "LED-B6", "led-b1", "d65"})
    EXPECT_FALSE(find_illuminant(name).has_value()) << name;
}

}  // namespace
}  // namespace tessera::spectra
