#include "spectra/rgb/scene_rgb.h"

#include <gtest/gtest.h>

#include <cmath>

#include "spectra/light/daylight.h"
#include "spectra/matter/metals.h"
#include "spectra/observer/cie1931.h"

namespace tessera::spectra {
namespace {

Curve constant(float c) { return {{550}, {c}}; }

TEST(Cie1931, MatchesPublishedSums) {
  // Sums over 380..780 nm, every 5 nm [CIE 15:2004, table T.4].
  double x = 0, y = 0, z = 0;
  for (int i = 4; i <= 84; ++i) {
    x += kCie1931[static_cast<std::size_t>(i)][0];
    y += kCie1931[static_cast<std::size_t>(i)][1];
    z += kCie1931[static_cast<std::size_t>(i)][2];
  }
  // The table is rounded to six decimals: 81 values are off by 4e-5 at most.
  EXPECT_NEAR(x, 21.371524, 5e-5);
  EXPECT_NEAR(y, 21.371327, 5e-5);
  EXPECT_NEAR(z, 21.371540, 5e-5);
}

TEST(EmissionRgb, D65IsWhite) {
  const Curve d65 = illuminant_d65();
  const Rgb rgb = emission_rgb(d65);
  const double y = emission_luminance(d65);
  // The white point that Rec.709's matrix is made for is rounded to four digits: (0.3127, 0.3290).
  EXPECT_NEAR(rgb.r / y, 1, 1e-3);
  EXPECT_NEAR(rgb.g / y, 1, 1e-3);
  EXPECT_NEAR(rgb.b / y, 1, 1e-3);
}

TEST(EmissionRgb, EqualEnergyIsSlightlyPink) {
  // The rows of the XYZ to Rec.709 matrix, summed.
  const Rgb rgb = emission_rgb(constant(2));
  EXPECT_NEAR(rgb.r, 2 * 1.2048, 2e-3);
  EXPECT_NEAR(rgb.g, 2 * 0.9483, 2e-3);
  EXPECT_NEAR(rgb.b, 2 * 0.9088, 2e-3);
  EXPECT_NEAR(emission_luminance(constant(2)), 2, 1e-6);
}

TEST(EmissionRgb, LaserLinesStayInGamut) {
  const Rgb green = emission_rgb({{519, 520, 521}, {0, 1, 0}});
  EXPECT_EQ(green.r, 0);  // outside Rec.709
  EXPECT_GT(green.g, 0);
}

TEST(ReflectanceRgb, ConstantIsGrey) {
  for (const float c : {0.0f, 0.18f, 1.0f}) {
    const Rgb rgb = reflectance_rgb(constant(c));
    EXPECT_NEAR(rgb.r, c, 1e-6);
    EXPECT_NEAR(rgb.g, c, 1e-6);
    EXPECT_NEAR(rgb.b, c, 1e-6);
  }
  EXPECT_EQ(reflectance_rgb(constant(7)).g, 1);
}

TEST(ReflectanceRgb, EdgesHaveTheirColours) {
  const Rgb red = reflectance_rgb({{590, 600}, {0, 1}});
  EXPECT_GT(red.r, 0.7);
  EXPECT_LT(red.g, 0.1);
  EXPECT_LT(red.b, 0.05);
  const Rgb blue = reflectance_rgb({{480, 490}, {1, 0}});
  EXPECT_GT(blue.b, 0.7);
  EXPECT_LT(blue.r, 0.15);
}

TEST(BlackbodyRgb, FollowsThePlanckianLocus) {
  // 6504 K is the correlated temperature of D65, which lies beside the locus by 0.003 in u'v': white to some
  // 5 %.
  const Rgb white = blackbody_rgb(6504);
  EXPECT_NEAR(white.r / white.g, 1, 0.07);
  EXPECT_NEAR(white.b / white.g, 1, 0.07);
  // Chromaticity of a blackbody at 2856 K (illuminant A): x = 0.44758, y = 0.40745 [ISO 11664-2].
  const Rgb warm = blackbody_rgb(2855.54f);
  const double x = 0.4123908 * warm.r + 0.3575843 * warm.g + 0.1804808 * warm.b;
  const double y = 0.2126390 * warm.r + 0.7151687 * warm.g + 0.0721923 * warm.b;
  const double z = 0.0193308 * warm.r + 0.1191948 * warm.g + 0.9505322 * warm.b;
  EXPECT_NEAR(x / (x + y + z), 0.44758, 5e-4);
  EXPECT_NEAR(y / (x + y + z), 0.40745, 5e-4);
  EXPECT_GT(warm.r, warm.g);
  EXPECT_GT(warm.g, warm.b);
}

TEST(BlackbodyRgb, HasAMaximumOfOne) {
  // At 2.8977719e-3 m K / 555 nm the peak lies where the eye is most sensitive: the luminance is a mean over
  // values up to 1 near that peak.
  EXPECT_NEAR(blackbody_luminance(2.8977719e-3f / 555e-9f), 0.99, 0.01);
  // Far from the peak almost nothing is visible.
  EXPECT_LT(blackbody_luminance(800), 1e-2);
  EXPECT_GT(blackbody_luminance(800), 0);
  for (const float kelvin : {0.0f, -5.0f, std::nanf("")}) EXPECT_EQ(blackbody_rgb(kelvin).r, 0);
  const Rgb hot = blackbody_rgb(1e7f);
  EXPECT_TRUE(std::isfinite(hot.r) && std::isfinite(hot.g) && std::isfinite(hot.b));
  EXPECT_TRUE(std::isfinite(blackbody_rgb(1e-3f).r));
}

/// Measured indices of evaporated films [Johnson & Christy 1972].
struct MeasuredMetal {
  std::vector<float> eta, k;

  ConductorRgb rgb() const {
    const std::vector<float> nm = {397.4f, 413.3f, 430.5f, 450.9f, 471.4f, 495.9f,
                                   520.9f, 548.6f, 579.4f, 616.8f, 659.5f, 704.5f};
    return conductor_rgb({nm, eta}, {nm, k});
  }
  Rgb reflectance() const {
    const ConductorRgb c = rgb();
    const auto f = [](float n, float absorption) {
      return static_cast<float>(normal_reflectance(n, absorption));
    };
    return {f(c.eta.r, c.k.r), f(c.eta.g, c.k.g), f(c.eta.b, c.k.b)};
  }
};

const MeasuredMetal kGold{
    {1.47f, 1.46f, 1.45f, 1.38f, 1.31f, 1.04f, 0.62f, 0.43f, 0.29f, 0.21f, 0.14f, 0.13f},
    {1.952f, 1.958f, 1.948f, 1.914f, 1.849f, 1.833f, 2.081f, 2.455f, 2.863f, 3.272f, 3.697f, 4.103f}};
const MeasuredMetal kCopper{
    {1.32f, 1.28f, 1.25f, 1.24f, 1.25f, 1.22f, 1.18f, 1.02f, 0.70f, 0.30f, 0.22f, 0.21f},
    {2.116f, 2.207f, 2.305f, 2.397f, 2.483f, 2.564f, 2.608f, 2.577f, 2.704f, 3.205f, 3.747f, 4.205f}};
const MeasuredMetal kSilver{
    {0.05f, 0.05f, 0.04f, 0.04f, 0.05f, 0.05f, 0.05f, 0.06f, 0.05f, 0.06f, 0.05f, 0.04f},
    {2.070f, 2.275f, 2.462f, 2.657f, 2.869f, 3.093f, 3.324f, 3.586f, 3.858f, 4.152f, 4.483f, 4.838f}};

TEST(ConductorRgb, MetalsLookLikeThemselves) {
  const Rgb gold = kGold.reflectance();  // yellow
  EXPECT_GT(gold.r, 0.95);
  EXPECT_GT(gold.r, gold.g);
  EXPECT_GT(gold.g, 2 * gold.b);
  EXPECT_GT(gold.g, 0.65);
  const Rgb copper = kCopper.reflectance();  // reddish
  EXPECT_GT(copper.r, 0.9);
  EXPECT_GT(copper.r, 1.3 * copper.g);
  EXPECT_GT(copper.g, copper.b);
  const Rgb silver = kSilver.reflectance();  // nearly white
  EXPECT_GT(silver.b, 0.93);
  EXPECT_GT(silver.g, 0.95);
  EXPECT_GT(silver.r, 0.95);
}

TEST(ConductorRgb, ReflectsWhatTheSpectrumReflects) {
  // One constant index is returned as it is.
  const ConductorRgb flat = conductor_rgb(constant(0.2f), constant(3));
  EXPECT_NEAR(flat.eta.g, 0.2, 1e-5);
  EXPECT_NEAR(flat.k.g, 3, 1e-4);
  EXPECT_NEAR(flat.k.r, 3, 1e-4);
  // No absorption at all.
  const ConductorRgb glass = conductor_rgb(constant(1.5f), constant(0));
  EXPECT_NEAR(glass.eta.b, 1.5, 1e-4);
  EXPECT_NEAR(glass.k.b, 0, 1e-2);
  // Any input gives indices that are numbers, and reflectances in [0, 1).
  for (const float eta : {0.0f, 1e-4f, 1.0f, 50.0f}) {
    for (const float k : {0.0f, 1.0f, 1e4f}) {
      const ConductorRgb c = conductor_rgb(constant(eta), constant(k));
      const double r = normal_reflectance(c.eta.g, c.k.g);
      EXPECT_TRUE(r >= 0 && r < 1) << eta << " " << k << " " << r;
      EXPECT_NEAR(r, std::min(normal_reflectance(eta, k), 0.9999), 1e-3) << eta << " " << k;
    }
  }
}

TEST(DielectricEta, IsTakenAtTheSodiumLine) {
  EXPECT_NEAR(dielectric_eta({{486.1f, 587.6f, 656.3f}, {1.5224f, 1.5168f, 1.5143f}}), 1.5167,
              1e-4);  // N-BK7
}

}  // namespace
}  // namespace tessera::spectra
