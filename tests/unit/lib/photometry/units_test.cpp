#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "photometry/units/light_unit.h"
#include "photometry/units/weighting.h"
#include "spectra/light/daylight.h"
#include "spectra/light/illuminants.h"
#include "spectra/observer/action_spectrum.h"

namespace tessera::photometry {
namespace {

using testing::HasSubstr;

struct Spelling {
  const char* text;
  Quantity quantity;
  Weighting weighting;
  double factor;
};

TEST(LightUnits, AreReadInAllSpellings) {
  constexpr auto kFlux = Quantity::kFlux, kIntensity = Quantity::kIntensity,
                 kIrradiance = Quantity::kIrradiance, kRadiance = Quantity::kRadiance;
  constexpr auto kWatt = Weighting::kRadiometric, kLumen = Weighting::kPhotopic;
  constexpr double kFoot2 = 0.3048 * 0.3048;
  const Spelling spellings[] = {{"W", kFlux, kWatt, 1},
                                {"lm", kFlux, kLumen, 1},
                                {"klm", kFlux, kLumen, 1e3},
                                {"lumens", kFlux, kLumen, 1},
                                {"Lumen", kFlux, kLumen, 1},
                                {"mW", kFlux, kWatt, 1e-3},
                                {"MW", kFlux, kWatt, 1e6},
                                {"cd", kIntensity, kLumen, 1},
                                {"mcd", kIntensity, kLumen, 1e-3},
                                {"lm/sr", kIntensity, kLumen, 1},
                                {"W/sr", kIntensity, kWatt, 1},
                                {"W\u00b7sr\u207b\u00b9", kIntensity, kWatt, 1},
                                {"W sr^-1", kIntensity, kWatt, 1},
                                {"lx", kIrradiance, kLumen, 1},
                                {"lux", kIrradiance, kLumen, 1},
                                {"LX", kIrradiance, kLumen, 1},
                                {"lm/m2", kIrradiance, kLumen, 1},
                                {"lm/ft^2", kIrradiance, kLumen, 1 / kFoot2},
                                {"fc", kIrradiance, kLumen, 1 / kFoot2},
                                {"footcandles", kIrradiance, kLumen, 1 / kFoot2},
                                {"W/m2", kIrradiance, kWatt, 1},
                                {"W/m^2", kIrradiance, kWatt, 1},
                                {"W/m**2", kIrradiance, kWatt, 1},
                                {"W/m\u00b2", kIrradiance, kWatt, 1},
                                {"W m-2", kIrradiance, kWatt, 1},
                                {"W/cm2", kIrradiance, kWatt, 1e4},
                                {"\u00b5W/cm\u00b2", kIrradiance, kWatt, 1e-2},
                                {"watts per m2", kIrradiance, kWatt, 1},
                                {"cd/m2", kRadiance, kLumen, 1},
                                {"cd/m\u00b2", kRadiance, kLumen, 1},
                                {"nit", kRadiance, kLumen, 1},
                                {"nits", kRadiance, kLumen, 1},
                                {"knt", kRadiance, kLumen, 1e3},
                                {"fL", kRadiance, kLumen, 1 / (std::numbers::pi * kFoot2)},
                                {"lm/(m2 sr)", kRadiance, kLumen, 1},
                                {"W/(m2 sr)", kRadiance, kWatt, 1},
                                {"W/(m^2*sr)", kRadiance, kWatt, 1},
                                {"W/m2/sr", kRadiance, kWatt, 1},
                                {"W/m2 sr", kRadiance, kWatt, 1},
                                {" W m-2 sr-1 ", kRadiance, kWatt, 1},
                                {"W\u22c5m\u207b\u00b2\u22c5sr\u207b\u00b9", kRadiance, kWatt, 1},
                                {"scotopic lx", kIrradiance, Weighting::kScotopic, 1},
                                {"melanopic lx", kIrradiance, Weighting::kMelanopic, 1},
                                {"Melanopic W/m2", kIrradiance, Weighting::kMelanopic, 1 / 1.3262e-3},
                                {"photopic cd/m2", kRadiance, kLumen, 1}};
  for (const Spelling& spelling : spellings) {
    const auto unit = parse_light_unit(spelling.text);
    ASSERT_TRUE(unit.ok()) << spelling.text << ": " << unit.status();
    EXPECT_EQ(unit->quantity, spelling.quantity) << spelling.text;
    EXPECT_EQ(unit->weighting, spelling.weighting) << spelling.text;
    EXPECT_NEAR(unit->factor / spelling.factor, 1, 1e-14) << spelling.text;
  }
}

TEST(LightUnits, ThatAreNoneAreRefusedWithTheNearest) {
  const auto refusal = [](const char* text) {
    return std::string(parse_light_unit(text).status().message());
  };
  EXPECT_THAT(refusal("lumne"), HasSubstr("no unit of light is called 'lumne'; did you mean 'lumen'?"));
  EXPECT_THAT(refusal("candle"), HasSubstr("did you mean 'candela'?"));
  for (const char* const text :
       {"",         " ",          "m",        "sr",        "W/",    "/m2",      "W m",
        "lm/W",     "W2",         "lm lm",    "W/m3",      "cd/sr", "W/(m2 sr", "W)",
        "W//m2",    "W^",         "W^-",      "W/m22",     "1 W",   "kkW",      "W/((((((m2))))))",
        "\xff\xfe", "scotopic W", "scotopic", "melanopic "})
    EXPECT_FALSE(parse_light_unit(text).ok()) << text;
}

TEST(LightUnits, BaseUnitsAndQuantitiesHaveTheirNames) {
  for (const Quantity quantity :
       {Quantity::kFlux, Quantity::kIntensity, Quantity::kIrradiance, Quantity::kRadiance}) {
    for (const Weighting weighting :
         {Weighting::kRadiometric, Weighting::kPhotopic, Weighting::kScotopic, Weighting::kMelanopic}) {
      const LightUnit unit = base_unit(quantity, weighting);
      const auto read = parse_light_unit(unit.name);
      ASSERT_TRUE(read.ok()) << unit.name;
      EXPECT_EQ(*read, unit) << unit.name;
    }
  }
  EXPECT_EQ(name_of_quantity(Quantity::kIrradiance, Weighting::kPhotopic), "illuminance");
  EXPECT_EQ(name_of_quantity(Quantity::kIrradiance, Weighting::kRadiometric), "irradiance");
  EXPECT_EQ(name_of_quantity(Quantity::kFlux, Weighting::kScotopic), "scotopic luminous flux");
}

TEST(LightUnits, AreConvertedWithinAQuantity) {
  const auto unit = [](const char* text) { return *parse_light_unit(text); };
  EXPECT_NEAR(*conversion(unit("fc"), unit("lx")), 10.763910416709722, 1e-12);
  EXPECT_NEAR(*conversion(unit("kW"), unit("lm")), 683e3, 1e-6);
  EXPECT_NEAR(*conversion(unit("cd"), unit("W/sr")), 1 / 683.0, 1e-15);
  EXPECT_FALSE(conversion(unit("lx"), unit("cd")));
  EXPECT_FALSE(conversion(unit("scotopic lx"), unit("lx")));
}

TEST(LengthUnits, AreNamesAndNumbersOfMetres) {
  const std::vector<std::pair<const char*, double>> units = {
      {"m", 1},       {"mm", 1e-3},  {"cm", 1e-2},       {"km", 1e3},        {"in", 0.0254}, {"ft", 0.3048},
      {"yd", 0.9144}, {"Metres", 1}, {"inches", 0.0254}, {" feet ", 0.3048}, {"0.01", 0.01}, {"1e-3", 1e-3}};
  for (const auto& [text, metres] : units) {
    const auto found = parse_length_unit(text);
    ASSERT_TRUE(found.ok()) << text;
    EXPECT_DOUBLE_EQ(*found, metres) << text;
  }
  EXPECT_EQ(name_of_length(0.01), "cm");
  EXPECT_EQ(name_of_length(0.5), "0.5 m");
  const auto refusal = [](const char* text) {
    return std::string(parse_length_unit(text).status().message());
  };
  EXPECT_THAT(refusal("metrse"), HasSubstr("did you mean 'metre"));
  EXPECT_THAT(refusal("0"), HasSubstr("is not above 0"));
  EXPECT_THAT(refusal("-2"), HasSubstr("is not above 0"));
  for (const char* const text : {"", "inf", "nan", "1e999", "1 m", "M"})
    EXPECT_FALSE(parse_length_unit(text).ok()) << text;
}

/// Sum of a spectrum times a weight, in steps of a nanometre.
double weighted_by(Weighting weighting, const spectra::Curve& spectrum) {
  std::vector<double> bands;
  for (int nm = 360; nm < 830; ++nm) bands.push_back(spectrum.at(nm + 0.5));
  return weighted(weighting, bands, 360, 1);
}

TEST(Weightings, HaveThePublishedEfficacies) {
  // CIE 15: the integral of V(lambda) is 106.857 nm, that of V'(lambda) 97.074 nm (sums of the tables'
  // steps).
  EXPECT_NEAR(spectra::photopic().integral(0, 2000), 106.857, 1e-3);
  EXPECT_NEAR(spectra::scotopic().integral(0, 2000), 97.074, 2e-3);
  EXPECT_NEAR(band_weight(Weighting::kPhotopic, 300, 1000), 72983, 2);
  // CIE S 026: 1 lx of D65 is 1 lx of melanopic equivalent daylight, by definition of the constant, which has
  // five digits; the table in steps of 5 nm is 1e-4 off that of 1 nm.
  const spectra::Curve d65 = spectra::illuminant_d65();
  EXPECT_NEAR(weighted_by(Weighting::kMelanopic, d65) / weighted_by(Weighting::kPhotopic, d65), 1, 3e-4);
  // The melanopic ratio of illuminant A is 0.49581 (public calculators by CIE S 026).
  const spectra::Curve a = *spectra::find_illuminant("A");
  EXPECT_NEAR(weighted_by(Weighting::kMelanopic, a) / weighted_by(Weighting::kPhotopic, a), 0.49581, 3e-4);
  // Scotopic to photopic ratio of illuminant A: 1.41, of D65 2.46.
  EXPECT_NEAR(weighted_by(Weighting::kScotopic, a) / weighted_by(Weighting::kPhotopic, a), 1.41, 0.005);
  EXPECT_NEAR(weighted_by(Weighting::kScotopic, d65) / weighted_by(Weighting::kPhotopic, d65), 2.46, 0.005);
  EXPECT_DOUBLE_EQ(band_weight(Weighting::kRadiometric, 400, 450), 50);
}

TEST(ActionSpectra, AreIntegratedExactlyBetweenAnyWavelengths) {
  for (const spectra::ActionSpectrum* const spectrum :
       {&spectra::photopic(), &spectra::scotopic(), &spectra::melanopic()}) {
    // Parts add up to the whole, and a narrow one is the value.
    const double parts =
        spectrum->integral(100, 433.3) + spectrum->integral(433.3, 433.4) + spectrum->integral(433.4, 3000);
    EXPECT_NEAR(parts, spectrum->integral(spectrum->first_nm, spectrum->last_nm()), 1e-10);
    EXPECT_NEAR(spectrum->integral(502, 502.5) / 0.5, spectrum->at(502.25), 1e-12);
    EXPECT_EQ(spectrum->integral(600, 500), 0);
    EXPECT_EQ(spectrum->at(200), 0);
  }
  EXPECT_EQ(spectra::photopic().at(555), 1);
  EXPECT_EQ(spectra::melanopic().at(490), 1);
}

}  // namespace
}  // namespace tessera::photometry
