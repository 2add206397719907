#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "photometry/lamps/lamp_file.h"
#include "unit/lib/photometry/sample_lamps.h"

namespace tessera::photometry {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180;

/// Integral of a function of directions by the midpoints of n x 2n cells of equal solid angle.
double integral(const std::function<double(double x, double y, double z)>& f, int n) {
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double z = (2 * i + 1.0) / n - 1, r = std::sqrt(1 - z * z);
    for (int k = 0; k < 2 * n; ++k) {
      const double phi = kPi * (k + 0.5) / n;
      sum += f(r * std::cos(phi), r * std::sin(phi), z);
    }
  }
  return sum * 4 * kPi / (2.0 * n * n);
}

TEST(Ies, SymmetricFilesAreReadWhole) {
  const ReadLamp found = read_lamp(symmetric_ies(), "lamp.ies");
  ASSERT_TRUE(found.luminaire.ok()) << found.luminaire.status();
  EXPECT_THAT(found.warnings, IsEmpty());
  const Luminaire& l = *found.luminaire;
  EXPECT_EQ(l.ies_year, 2002);
  EXPECT_THAT(l.labels,
              Contains(std::pair<std::string, std::string>("LUMINAIRE", "Downlight with\na wide reflector")));
  EXPECT_EQ(l.system, PlaneSystem::kC);
  EXPECT_TRUE(l.is_absolute());
  EXPECT_THAT(l.plane_degrees, ElementsAre(0));
  EXPECT_EQ(l.width, -0.1);
  EXPECT_EQ(l.watts, 12.5);
  EXPECT_EQ(intensity(l, 0, 0, -1), 800);
  // Half-way between 15 and 30 degrees, in any plane; none upwards.
  EXPECT_NEAR(intensity(l, std::sin(22.5 * kDegree), 0, -std::cos(22.5 * kDegree)), (760.5 + 600) / 2, 1e-9);
  EXPECT_NEAR(intensity(l, 0, -std::sin(22.5 * kDegree), -std::cos(22.5 * kDegree)), (760.5 + 600) / 2, 1e-9);
  EXPECT_EQ(intensity(l, 0, 0, 1), 0);
}

TEST(Ies, FluxIsTheExactIntegralOfWhatIsInterpolated) {
  for (const std::string& text :
       {symmetric_ies(), quadrant_ies(), bilateral_ies(), full_ies(), beam_ies(2), beam_ies(3)}) {
    const ReadLamp found = read_lamp(text, "lamp.ies");
    ASSERT_TRUE(found.luminaire.ok()) << found.luminaire.status();
    const Luminaire& l = *found.luminaire;
    // The integrand is continuous with kinks, but for the edges of beams: midpoints are off by n^-2, there by
    // n^-1 of what leaves at the edge.
    const double summed = integral([&](double x, double y, double z) { return intensity(l, x, y, z); }, 720);
    const bool has_edges = l.system != PlaneSystem::kC;
    EXPECT_NEAR(flux(l) / summed, 1, has_edges ? 1e-3 : 2e-5) << text;
  }
}

TEST(Ies, FluxHasItsClosedForms) {
  // The same in all directions.
  EXPECT_NEAR(flux(luminaire_of([](double, double) { return 2.0; }, 90, 180)), 8 * kPi, 1e-12);
  // I0 cos(gamma) downwards: pi I0; a table in steps of h is below it by h^2 / 6 of itself at most (the chord
  // of a cosine).
  const auto cosine = [](double, double gamma) { return gamma < 90 ? 3 * std::cos(gamma * kDegree) : 0.0; };
  const double step = kDegree;
  EXPECT_NEAR(flux(luminaire_of(cosine, 360, 1)) / (3 * kPi), 1, step * step / 6);
  EXPECT_LT(flux(luminaire_of(cosine, 360, 1)), 3 * kPi);
  // A half of space: 2 pi (plus the ramp of one step beyond the horizon).
  EXPECT_NEAR(downward_flux(luminaire_of([](double, double) { return 1.0; }, 90, 10)), 2 * kPi, 1e-12);
  // One quarter turn lit alone, with ramps of one step at both sides, which make one step together.
  const auto quarter = [](double c, double) { return c <= 90 ? 1.0 : 0.0; };
  EXPECT_NEAR(flux(luminaire_of(quarter, 15, 10, 345)), 4 * kPi * (90 + 15) / 360, 1e-12);
}

TEST(Ies, FactorsOfLampAndBallastCount) {
  const ReadLamp found = read_lamp(quadrant_ies(), "lamp.ies");
  ASSERT_TRUE(found.luminaire.ok()) << found.luminaire.status();
  EXPECT_THAT(found.warnings, IsEmpty());
  const Luminaire& l = *found.luminaire;
  EXPECT_NEAR(intensity(l, 0, 0, -1), 200 * 2.5 * 0.9 * 0.98, 1e-9);
  EXPECT_TRUE(l.feet);
  EXPECT_EQ(l.lamp_lumens(), 2000);
  EXPECT_THAT(l.tilt.degrees, ElementsAre(0, 45, 90));
  EXPECT_THAT(l.tilt.factors, ElementsAre(1, 0.95, 0.9));
  // Quadrants are the same: C 30, 150, 210 and 330.
  const double s = std::sin(1.0), c = -std::cos(1.0), x = std::cos(30 * kDegree) * s,
               y = std::sin(30 * kDegree) * s;
  for (const double sign_x : {1.0, -1.0}) {
    for (const double sign_y : {1.0, -1.0})
      EXPECT_NEAR(intensity(l, sign_x * x, sign_y * y, c), intensity(l, x, y, c), 1e-9);
  }
}

TEST(Ies, BilateralFilesAreTheSameOnBothSides) {
  const ReadLamp found = read_lamp(bilateral_ies(), "lamp.ies");
  ASSERT_TRUE(found.luminaire.ok()) << found.luminaire.status();
  EXPECT_THAT(found.warnings, ElementsAre(HasSubstr("commas stand between numbers")));
  const Luminaire& l = *found.luminaire;
  EXPECT_EQ(l.ies_year, 1986);
  EXPECT_EQ(l.labels.size(), 2u);
  EXPECT_NEAR(intensity_at(l, {45, 30}), 420, 1e-9);
  EXPECT_NEAR(intensity_at(l, {315, 30}), 420, 1e-9);
  EXPECT_NEAR(intensity_at(l, {180, 60}), 30, 1e-9);
}

TEST(Ies, HalvesAboutTheOtherPlaneAreMirroredThere) {
  // From 90 to 270: the same on both sides of the plane C90-C270.
  std::string text = bilateral_ies();
  text = with(text, "0,45,90,135,180\n", "90,135,180,225,270\n");
  const ReadLamp found = read_lamp(text, "lamp.ies");
  ASSERT_TRUE(found.luminaire.ok()) << found.luminaire.status();
  EXPECT_NEAR(intensity_at(*found.luminaire, {180, 60}), 120, 1e-9);
  EXPECT_NEAR(intensity_at(*found.luminaire, {0, 60}), 120, 1e-9);
  EXPECT_NEAR(intensity_at(*found.luminaire, {45, 60}), 300, 1e-9);
  EXPECT_NEAR(intensity_at(*found.luminaire, {315, 60}), 60, 1e-9);
}

TEST(Ies, WithoutTheLastPlaneTheTurnIsClosed) {
  Luminaire open = luminaire_of([](double c, double) { return c < 180 ? c : 360 - c; }, 30, 90, 330);
  const Luminaire closed = luminaire_of([](double c, double) { return c < 180 ? c : 360 - c; }, 30, 90);
  EXPECT_NEAR(intensity_at(open, {345, 90}), 15, 1e-9);
  EXPECT_NEAR(flux(open), flux(closed), 1e-9);
}

TEST(Ies, BeamsOfAAndBPlanesAreAboutTheirAxis) {
  const ReadLamp b = read_lamp(beam_ies(2), "lamp.ies"), a = read_lamp(beam_ies(3), "lamp.ies");
  ASSERT_TRUE(b.luminaire.ok()) << b.luminaire.status();
  ASSERT_TRUE(a.luminaire.ok()) << a.luminaire.status();
  EXPECT_EQ(b.luminaire->system, PlaneSystem::kB);
  EXPECT_EQ(intensity(*b.luminaire, 0, 0, -1), 1000);
  EXPECT_EQ(intensity(*a.luminaire, 0, 0, -1), 1000);
  const auto told = [](int h, int v) {
    return std::round(1000 * std::exp(-h * h / 800.0 - v * v / 200.0) * (1 + 0.004 * h + 0.01 * v));
  };
  const double h = 30 * kDegree, v = 10 * kDegree;
  // B planes are about the horizontal axis: the vertical angle is that of the plane. A planes are about the
  // vertical one: it is that above the horizon.
  EXPECT_NEAR(intensity(*b.luminaire, std::sin(h), std::cos(h) * std::sin(v), -std::cos(h) * std::cos(v)),
              told(30, 10), 1e-9);
  EXPECT_NEAR(intensity(*a.luminaire, std::cos(v) * std::sin(h), std::sin(v), -std::cos(v) * std::cos(h)),
              told(30, 10), 1e-9);
  EXPECT_EQ(intensity(*b.luminaire, 1, 0, 0), 0);
  EXPECT_EQ(intensity(*b.luminaire, 0, 0, 1), 0);
}

TEST(Ies, WrittenFilesReadBackEqual) {
  for (const std::string& text :
       {symmetric_ies(), quadrant_ies(), bilateral_ies(), full_ies(), beam_ies(2), beam_ies(3)}) {
    const ReadLamp first = read_lamp(text, "lamp.ies");
    ASSERT_TRUE(first.luminaire.ok()) << first.luminaire.status();
    const auto written = write_ies(*first.luminaire);
    ASSERT_TRUE(written.ok()) << written.status();
    const ReadLamp second = read_lamp(*written, "lamp.ies");
    ASSERT_TRUE(second.luminaire.ok()) << second.luminaire.status() << "\n" << *written;
    EXPECT_EQ(*second.luminaire, *first.luminaire) << *written;
    EXPECT_EQ(*write_ies(*second.luminaire), *written);
  }
}

TEST(Ies, ArbitraryNumbersKeepAllTheirDigits) {
  Luminaire l =
      luminaire_of([](double c, double gamma) { return 1000 / (7 + c) + gamma / 3; }, 40, 7.3, 320, 175.2);
  l.multiplier = 1.0 / 3, l.watts = 0.1 + 0.2, l.ies_year = 2019;
  const auto written = write_ies(l);
  ASSERT_TRUE(written.ok()) << written.status();
  const ReadLamp found = read_lamp(*written, "lamp.ies");
  ASSERT_TRUE(found.luminaire.ok()) << found.luminaire.status();
  EXPECT_EQ(*found.luminaire, l);
}

TEST(Ies, OtherStandardsKeepTheIntensities) {
  const Luminaire l = *read_lamp(quadrant_ies(), "lamp.ies").luminaire;
  for (const int year : {1986, 1991, 1995, 2002, 2019}) {
    const auto written = write_ies(l, year);
    ASSERT_TRUE(written.ok()) << written.status();
    const ReadLamp found = read_lamp(*written, "lamp.ies");
    ASSERT_TRUE(found.luminaire.ok()) << found.luminaire.status();
    EXPECT_EQ(found.luminaire->ies_year, year);
    EXPECT_NEAR(flux(*found.luminaire) / flux(l), 1, 1e-14) << year;
  }
  EXPECT_FALSE(write_ies(l, 2001).ok());
}

TEST(Ies, TiltFilesAreReadWhereTheyAre) {
  const std::string text = with(symmetric_ies(), "TILT=NONE", "TILT=lamp.tlt");
  const ReadLamp found =
      read_lamp(text, "lamp.ies", [](const std::string& name) -> absl::StatusOr<std::string> {
        EXPECT_EQ(name, "lamp.tlt");
        return "2\n2\n0 90\n1 0.8\n";
      });
  ASSERT_TRUE(found.luminaire.ok()) << found.luminaire.status();
  EXPECT_THAT(found.luminaire->tilt.factors, ElementsAre(1, 0.8));
  EXPECT_EQ(found.luminaire->tilt.geometry, 2);
  EXPECT_THAT(read_lamp(text, "lamp.ies").warnings,
              ElementsAre(HasSubstr("lamp.ies:8: 'lamp.tlt', which TILT= names, is not read")));
  const ReadLamp broken = read_lamp(
      text, "lamp.ies", [](const std::string&) -> absl::StatusOr<std::string> { return "1\n2\n0\n"; });
  EXPECT_THAT(std::string(broken.luminaire.status().message()),
              HasSubstr("lamp.tlt:3: the file ends where the tilt angle 2 of 2"));
}

TEST(Ies, FilesThatLieAboutTheirFluxAreTold) {
  const double truth = flux(*read_lamp(symmetric_ies(), "lamp.ies").luminaire);
  const ReadLamp lamp = read_lamp(with(symmetric_ies(), "1 -1 1 7", "1 500 1 7"), "lamp.ies");
  ASSERT_TRUE(lamp.luminaire.ok());
  EXPECT_THAT(lamp.warnings, ElementsAre(AllOf(HasSubstr("more than the 500 lm of its lamps"),
                                               HasSubstr(absl::StrCat(std::round(truth * 1000) / 1000)))));
  EXPECT_NEAR(flux(*lamp.luminaire), truth, 1e-9) << "it emits what its intensities make";
  const ReadLamp dim = read_lamp(with(symmetric_ies(), "1 -1 1 7", "1 90000 1 7"), "lamp.ies");
  EXPECT_THAT(dim.warnings, ElementsAre(HasSubstr("of the 90000 lm of its lamps")));
  const ReadLamp label =
      read_lamp(with(symmetric_ies(), "[TEST] T-1", "[TOTALLUMINAIRELUMENS] 2000"), "lamp.ies");
  EXPECT_THAT(label.warnings,
              ElementsAre(HasSubstr("[TOTALLUMINAIRELUMENS] says 2000 lm; its intensities make")));
}

TEST(Ies, WhatRealFilesHaveIsReadWithAWarning) {
  const auto warnings = [](const std::string& text) {
    const ReadLamp found = read_lamp(text, "lamp.ies");
    EXPECT_TRUE(found.luminaire.ok()) << found.luminaire.status() << text;
    return found.warnings;
  };
  EXPECT_THAT(warnings(with(symmetric_ies(), "[TEST] T-1", "[TEST T-1")),
              ElementsAre(HasSubstr("lamp.ies:2: a keyword without ']'")));
  EXPECT_THAT(warnings(with(symmetric_ies(), "[TEST] T-1", "just text")),
              ElementsAre(HasSubstr("lamp.ies:2: a line without a keyword")));
  EXPECT_THAT(warnings(with(symmetric_ies(), "IESNA:LM-63-2002", "IESNA:LM-63-2057")),
              ElementsAre(HasSubstr("names no version of LM-63")));
  EXPECT_THAT(warnings(with(symmetric_ies(), "800 760.5", "800 -760.5")),
              ElementsAre(HasSubstr("1 intensities are negative")));
  EXPECT_THAT(warnings(symmetric_ies() + "more text\n"),
              ElementsAre(HasSubstr("lamp.ies:14: what follows the last intensity")));
  EXPECT_THAT(warnings(with(symmetric_ies(), "1 1 12.5", "0 1 12.5")),
              ElementsAre(HasSubstr("a ballast factor of 0 is read as 1")));
  EXPECT_THAT(warnings(with(symmetric_ies(), "\n0\n800", "\n45\n800")),
              ElementsAre(HasSubstr("the only plane is at 45 degrees")));
  EXPECT_THAT(warnings(with(symmetric_ies(), "TILT=NONE", "  tilt = none")), IsEmpty());
  EXPECT_THAT(warnings(with(symmetric_ies(), "800 760.5", "8.0D+2 760.5")), IsEmpty());
  // Numbers may be on any lines.
  EXPECT_THAT(warnings(with(symmetric_ies(), "1 -1 1 7 1 1 2 -0.1 -0.1 0\n1 1 12.5\n",
                            "1 -1 1\n7 1 1 2 -0.1\n-0.1 0 1 1 12.5\n")),
              IsEmpty());
}

TEST(Ies, FaultsNameTheirPlace) {
  const auto refusal = [](const std::string& text) {
    std::vector<std::string> warnings;
    return std::string(read_ies(text, {.name = "lamp.ies"}, warnings).status().message());
  };
  EXPECT_THAT(refusal(""), HasSubstr("lamp.ies:1: the file is empty"));
  EXPECT_THAT(refusal("IESNA:LM-63-2002\n[TEST]\n"), HasSubstr("lamp.ies:2: there is no line TILT="));
  EXPECT_THAT(refusal(with(symmetric_ies(), "760.5", "7x0.5")),
              HasSubstr("lamp.ies:13:5: '7x0.5' is no number; the intensity 2 of 7 was expected"));
  EXPECT_THAT(refusal(with(symmetric_ies(), "760.5", "nan")), HasSubstr("'nan' is no number"));
  EXPECT_THAT(refusal(with(symmetric_ies(), "300 0 0 0\n", "300 0 0\n")),
              HasSubstr("lamp.ies:13: the file ends where the intensity 7 of 7"));
  EXPECT_THAT(refusal(with(symmetric_ies(), "45 60 75", "45 40 75")),
              HasSubstr("polar angle 5, 40, is not above the one before, 45"));
  EXPECT_THAT(refusal(with(symmetric_ies(), "75 90", "75 190")),
              HasSubstr("polar angle 7, 190, is not within 0 and 180 degrees"));
  EXPECT_THAT(refusal(with(symmetric_ies(), "7 1 1 2", "7 1 4 2")),
              HasSubstr("lamp.ies:9:12: there is no photometric type 4"));
  EXPECT_THAT(refusal(with(symmetric_ies(), "7 1 1 2", "7000000 999999 1 2")),
              HasSubstr("the file is too short for 7e+06 x 999999 intensities"));
  EXPECT_THAT(refusal(with(symmetric_ies(), "7 1 1 2", "6.5 1 1 2")),
              HasSubstr("6.5 cannot be the number of vertical angles"));
  EXPECT_THAT(refusal(with(symmetric_ies(), "1 -1 1 7", "1 -1 0 7")),
              HasSubstr("a candela multiplier of 0 is not above 0"));
  EXPECT_THAT(refusal(with(bilateral_ies(), "0,45,90,135,180\n", "0,45,90,135,170\n")),
              HasSubstr("its planes go from 0 to 170 degrees"));
  EXPECT_THAT(refusal(with(quadrant_ies(), "\r\n3\r\n", "\r\n1e9\r\n")),
              HasSubstr("is no number of tilt angles"));
}

}  // namespace
}  // namespace tessera::photometry
