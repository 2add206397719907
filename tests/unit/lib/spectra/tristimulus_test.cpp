#include "spectra/color/tristimulus.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "spectra/color/lab.h"
#include "spectra/light/illuminants.h"
#include "spectra/light/planck.h"
#include "unit/lib/spectra/macbeth.h"

namespace tessera::spectra {
namespace {

const Curve kOne{{550}, {1}};

/// The sum in steps of the observer's table, as lamps are told in print.
Triple summed(const Curve& reflectance, const Curve& light, const Observer& observer) {
  Triple sum = {0, 0, 0};
  double white = 0;
  for (std::size_t i = 0; i < observer.rows.size(); ++i) {
    const double nm = observer.first_nm + observer.step_nm * static_cast<double>(i);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += observer.rows[i][c] * light.at(nm) * reflectance.at(nm);
    white += observer.rows[i][1] * light.at(nm);
  }
  for (double& component : sum) component /= white;
  return sum;
}

TEST(Observer, EqualEnergyIsWhite) {
  // This is so by definition. The table of 2006 begins at 390 nm, where z is 0.018: half of a step of that is
  // 4e-4 of all.
  for (const Observer* observer : {&cie1931(), &cie2006()}) {
    const Triple xyz = tristimulus(kOne, *observer);
    EXPECT_NEAR(xyz[0], 1, 4e-4);
    EXPECT_DOUBLE_EQ(xyz[1], 1);
    EXPECT_NEAR(xyz[2], 1, 4e-4);
  }
  EXPECT_EQ(cie1931().at(555)[1], 1);
  EXPECT_EQ(cie1931().at(359.9)[1], 0);
  EXPECT_EQ(cie1931().at(830.1)[1], 0);
  EXPECT_NEAR(cie2006().at(557.5)[1], (0.9994608 + 0.9967737) / 2, 1e-12);
}

TEST(Tristimulus, NarrowLinesAreNotMissed) {
  // A triangle of 2 nm at 532 nm, between the rows of every table: its area times the line through the rows.
  const Curve line{{531, 532, 533}, {0, 1, 0}};
  double of_one = 0;
  for (std::size_t i = 0; i + 1 < cie1931().rows.size(); ++i)
    of_one += 2.5 * (cie1931().rows[i][1] + cie1931().rows[i + 1][1]);
  EXPECT_NEAR(tristimulus(line, cie1931())[1], cie1931().at(532)[1] / of_one, 1e-9);
  // A step, exactly where it is.
  const Curve below{{532, 532}, {1, 0}}, above{{532, 532}, {0, 1}};
  EXPECT_NEAR(tristimulus(below, cie1931())[1] + tristimulus(above, cie1931())[1], 1, 1e-12);
}

TEST(Tristimulus, ReflectancesAreRelativeToWhite) {
  const Curve light = *find_illuminant("F2");
  const Triple white = tristimulus(kOne, light, cie1931()),
               grey = tristimulus({{550}, {0.25f}}, light, cie1931());
  EXPECT_DOUBLE_EQ(white[1], 1);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(grey[c], 0.25 * white[c], 1e-12);
}

struct White {
  const char* name;
  Chromaticity published;
};

/// [CIE 15:2004; CIE 15:2018], with five decimals and four.
constexpr White kWhites[] = {
    {"A", {0.44758, 0.40745}},       {"C", {0.31006, 0.31616}},      {"D50", {0.34567, 0.35851}},
    {"D55", {0.33243, 0.34744}},     {"D65", {0.31272, 0.32903}},    {"D75", {0.29903, 0.31488}},
    {"acesD60", {0.32168, 0.33767}}, {"E", {1.0 / 3, 1.0 / 3}},      {"F1", {0.3131, 0.3371}},
    {"F2", {0.3721, 0.3751}},        {"F3", {0.4091, 0.3941}},       {"F4", {0.4402, 0.4031}},
    {"F5", {0.3138, 0.3452}},        {"F6", {0.3779, 0.3882}},       {"F7", {0.3129, 0.3292}},
    {"F8", {0.3458, 0.3586}},        {"F9", {0.3741, 0.3727}},       {"F11", {0.3805, 0.3769}},
    {"F12", {0.4370, 0.4042}},       {"LED-B1", {0.4560, 0.4078}},   {"LED-B2", {0.4357, 0.4012}},
    {"LED-B3", {0.3756, 0.3723}},    {"LED-B4", {0.3422, 0.3502}},   {"LED-B5", {0.3118, 0.3236}},
    {"LED-BH1", {0.4474, 0.4066}},   {"LED-RGB1", {0.4557, 0.4211}}, {"LED-V1", {0.4548, 0.4044}},
    {"LED-V2", {0.3781, 0.3775}}};

TEST(Illuminants, HaveThePublishedChromaticities) {
  for (const White& white : kWhites) {
    const Curve light = *find_illuminant(white.name);
    // Summed as in print: to the digits there.
    const Chromaticity told = chromaticity(summed(kOne, light, cie1931()));
    EXPECT_NEAR(told.x, white.published.x, 6e-5) << white.name;
    EXPECT_NEAR(told.y, white.published.y, 6e-5) << white.name;
    // Integrated, with lines between the samples of lamps: these lower the peaks of the observer.
    const bool is_lamp = white.name[0] == 'F' || white.name[0] == 'L';
    const Chromaticity seen = chromaticity(tristimulus(light, cie1931()));
    EXPECT_NEAR(seen.x, white.published.x, is_lamp ? 6e-4 : 1.5e-4) << white.name;
    EXPECT_NEAR(seen.y, white.published.y, is_lamp ? 6e-4 : 1.5e-4) << white.name;
  }
  // F10 is printed as x = 0.3458, which no sum of its table gives.
  EXPECT_NEAR(chromaticity(summed(kOne, *find_illuminant("F10"), cie1931())).x, 0.3461, 1e-4);
}

TEST(Illuminants, D65IsWhereItIsPublished) {
  const Chromaticity white = chromaticity(tristimulus(*find_illuminant("D65"), cie1931()));
  EXPECT_NEAR(white.x, 0.31272, 1e-4);
  EXPECT_NEAR(white.y, 0.32903, 1e-4);
}

TEST(Planck, ARadiatorOf2856KelvinIsIlluminantA) {
  Curve radiator;
  for (float nm = 360; nm <= 830; nm += 1) {
    radiator.nm.push_back(nm);
    radiator.values.push_back(static_cast<float>(relative_planck(nm, 2855.54)));
  }
  const Chromaticity seen = chromaticity(tristimulus(radiator, cie1931()));
  EXPECT_NEAR(seen.x, 0.44758, 1e-4);
  EXPECT_NEAR(seen.y, 0.40745, 1e-4);
  // Wien's displacement, and the values of Planck's law beside it by hand: x = h c / (l k T) = 2.482557 at
  // twice the wavelength of the peak; (x / 4.965114)^5 (e^4.965114 - 1) / (e^x - 1) = 0.405370.
  const double peak = 2897771.955 / 5000;
  EXPECT_NEAR(relative_planck(peak, 5000), 1, 1e-9);
  EXPECT_NEAR(relative_planck(2 * peak, 5000),
              std::pow(0.5, 5) * std::expm1(4.965114231744276) / std::expm1(4.965114231744276 / 2), 1e-9);
}

TEST(Macbeth, PatchesAreThePublishedColoursUnderD50) {
  // The white of ICC profiles, to which the published values refer.
  const Triple white = {0.9642, 1, 0.8249};
  const Curve light = *find_illuminant("D50");
  const Triple seen_white = tristimulus(kOne, light, cie1931());
  for (const MacbethPatch& patch : kMacbeth) {
    Triple published = xyz_of(patch.chromaticity);
    for (double& component : published) component *= patch.luminance;
    const Triple seen = tristimulus(patch.curve(), light, cie1931());
    EXPECT_LT(delta_e2000(lab_of(seen, seen_white), lab_of(published, white)), 0.25) << patch.name;
  }
}

TEST(Macbeth, PatchesAreThoseOfSumsUnderOtherLights) {
  // Sums over the observer's table are how CIE 15 integrates; they and lines between samples differ by some
  // 0.1.
  for (const char* name : {"A", "D65", "F2", "F11", "LED-RGB1"}) {
    const Curve light = *find_illuminant(name);
    const Triple white = tristimulus(kOne, light, cie1931()), summed_white = summed(kOne, light, cie1931());
    for (const MacbethPatch& patch : kMacbeth) {
      const Lab seen = lab_of(tristimulus(patch.curve(), light, cie1931()), white);
      EXPECT_LT(delta_e2000(seen, lab_of(summed(patch.curve(), light, cie1931()), summed_white)), 0.12)
          << patch.name << " under " << name;
    }
  }
}

}  // namespace
}  // namespace tessera::spectra
