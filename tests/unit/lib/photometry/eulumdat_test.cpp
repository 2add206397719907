#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "photometry/lamps/lamp_file.h"
#include "unit/lib/photometry/sample_lamps.h"

namespace tessera::photometry {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

/// The sample's intensity in a plane of its own, cd.
double told(int symmetry, int c, int gamma) {
  const double a = c * std::numbers::pi / 180, g = gamma * std::numbers::pi / 180;
  const double lobe = symmetry == 0   ? std::cos(a - 0.7)
                      : symmetry == 2 ? std::cos(a)
                      : symmetry == 3 ? std::sin(a)
                      : symmetry == 4 ? std::cos(2 * a)
                                      : 0;
  return std::round(10 * 250 * std::cos(g) * (1 + 0.4 * std::sin(g) * lobe)) / 10 * 5.2;
}

TEST(Eulumdat, AllSymmetriesTellAllPlanes) {
  for (int symmetry = 0; symmetry <= 4; ++symmetry) {
    const ReadLamp found = read_lamp(eulumdat(symmetry), "lamp.ldt");
    ASSERT_TRUE(found.luminaire.ok()) << found.luminaire.status();
    EXPECT_THAT(found.warnings, ElementsAre(HasSubstr("decimal commas"))) << symmetry;
    for (int c = 0; c < 360; c += 15) {
      for (int gamma = 0; gamma <= 90; gamma += 10)
        EXPECT_NEAR(intensity_at(*found.luminaire, {double(c), double(gamma)}), told(symmetry, c, gamma),
                    1e-9)
            << "symmetry " << symmetry << ", C " << c << ", gamma " << gamma;
    }
    EXPECT_EQ(intensity_at(*found.luminaire, {0, 91}), 0);
  }
}

TEST(Eulumdat, IsReadWithItsLabelsAndLamps) {
  const Luminaire l = *read_lamp(eulumdat(4), "lamp.ldt").luminaire;
  EXPECT_TRUE(l.is_eulumdat);
  EXPECT_THAT(l.labels, Contains(std::pair<std::string, std::string>("LUMINAIRE", "Louvre")));
  ASSERT_EQ(l.eulumdat.sets.size(), 1u);
  EXPECT_EQ(l.eulumdat.sets[0].type, "T16 28 W");
  EXPECT_EQ(l.watts, 62.5);
  EXPECT_EQ(l.lamps, 2);
  EXPECT_EQ(l.lamp_lumens(), 5200);
  EXPECT_EQ(l.length, 1200);
  EXPECT_FALSE(l.is_absolute());
}

TEST(Eulumdat, WrittenFilesReadBackEqual) {
  for (int symmetry = 0; symmetry <= 4; ++symmetry) {
    for (const char* const end : {"\r\n", "\n"}) {
      const Luminaire first = *read_lamp(eulumdat(symmetry, 73.25, end), "lamp.ldt").luminaire;
      const auto written = write_eulumdat(first);
      ASSERT_TRUE(written.ok()) << written.status();
      const ReadLamp second = read_lamp(*written, "lamp.ldt");
      ASSERT_TRUE(second.luminaire.ok()) << second.luminaire.status();
      EXPECT_EQ(*second.luminaire, first) << symmetry;
      EXPECT_EQ(*write_eulumdat(*second.luminaire), *written);
    }
  }
}

TEST(Eulumdat, EachFormatIsWrittenAsTheOther) {
  // To the last digits of cd/klm: a division by the flux and a multiplication.
  constexpr double kRounding = 1e-13;
  for (const std::string& text : {symmetric_ies(), quadrant_ies(), bilateral_ies(), full_ies()}) {
    std::vector<std::string> warnings;
    const Luminaire ies = *read_ies(text, {.name = "lamp.ies"}, warnings);
    const auto written = write_eulumdat(ies);
    ASSERT_TRUE(written.ok()) << written.status();
    const ReadLamp found = read_lamp(*written, "lamp.ldt");
    ASSERT_TRUE(found.luminaire.ok()) << found.luminaire.status() << *written;
    for (double c = 0; c < 360; c += 7.5) {
      for (double gamma = 0; gamma <= 180; gamma += 7.5)
        EXPECT_NEAR(intensity_at(*found.luminaire, {c, gamma}), intensity_at(ies, {c, gamma}),
                    kRounding * 2000);
    }
    EXPECT_NEAR(flux(*found.luminaire) / flux(ies), 1, kRounding);
    EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
  }
  for (int symmetry = 0; symmetry <= 4; ++symmetry) {
    const Luminaire ldt = *read_lamp(eulumdat(symmetry), "lamp.ldt").luminaire;
    const auto written = write_ies(ldt);
    ASSERT_TRUE(written.ok()) << written.status();
    std::vector<std::string> warnings;
    const auto ies = read_ies(*written, {.name = "lamp.ies"}, warnings);
    ASSERT_TRUE(ies.ok()) << ies.status();
    EXPECT_NEAR(flux(*ies) / flux(ldt), 1, kRounding);
  }
  std::vector<std::string> warnings;
  const Luminaire beam = *read_ies(beam_ies(2), {.name = "beam.ies"}, warnings);
  EXPECT_THAT(std::string(write_eulumdat(beam).status().message()), HasSubstr("EULUMDAT has C planes alone"));
}

TEST(Eulumdat, FilesThatLieAboutTheirFluxAreTold) {
  const double ratio = 100 * flux(*read_lamp(eulumdat(1), "lamp.ldt").luminaire) / 5200;
  EXPECT_THAT(read_lamp(eulumdat(1, std::round(10 * ratio) / 10), "lamp.ldt").warnings,
              ElementsAre(HasSubstr("decimal commas")));
  EXPECT_THAT(read_lamp(eulumdat(1, 2 * ratio), "lamp.ldt").warnings,
              Contains(HasSubstr("its intensities make")));
  const std::string half = with(eulumdat(1), "\r\n100\r\n0\r\n1.0\r\n", "\r\n50\r\n0\r\n1.0\r\n");
  EXPECT_THAT(read_lamp(half, "lamp.ldt").warnings,
              Contains(HasSubstr("it says that 50 % of its flux goes downward; its intensities send 100 %")));
}

TEST(Eulumdat, AbsoluteFilesHaveTheFluxOfTheLuminaire) {
  const std::string text =
      with(eulumdat(1, 100), "\r\n2\r\nT16 28 W\r\n5200\r\n", "\r\n-1\r\nLED\r\n800\r\n");
  const Luminaire l = *read_lamp(text, "lamp.ldt").luminaire;
  EXPECT_TRUE(l.is_absolute());
  EXPECT_NEAR(intensity_at(l, {0, 0}), 250 * 0.8, 1e-9);
  EXPECT_EQ(*read_lamp(*write_eulumdat(l), "lamp.ldt").luminaire, l);
}

TEST(Eulumdat, FaultsNameTheirLine) {
  const auto refusal = [](const std::string& text) {
    return std::string(read_lamp(text, "lamp.ldt").luminaire.status().message());
  };
  EXPECT_THAT(refusal(""), HasSubstr("lamp.ldt:1: the file ends where the company was expected"));
  EXPECT_THAT(refusal("a\nb\n"),
              HasSubstr("lamp.ldt:2: 'b' is no number; the type of light source was expected"));
  EXPECT_THAT(refusal("a\n1\n7\n"), HasSubstr("lamp.ldt:3: 7 cannot be the symmetry; 0 to 4 was expected"));
  EXPECT_THAT(refusal(with(eulumdat(4), "\r\n24\r\n", "\r\n22\r\n")),
              HasSubstr("22 C planes have no symmetry 4"));
  const std::string whole = eulumdat(2);
  EXPECT_THAT(refusal(whole.substr(0, whole.size() - 10)),
              HasSubstr("the file ends where intensity 129 of 130 was expected"));
  EXPECT_THAT(refusal(with(whole, "\r\n180\r\n", "\r\n185\r\n")),
              HasSubstr("planes of symmetry 2 go from 0 to 185 degrees; 0 to 180 was expected"));
  EXPECT_THAT(refusal(with(whole, "\r\n30\r\n40\r\n", "\r\n40\r\n40\r\n")),
              HasSubstr("is not above the one before"));
}

}  // namespace
}  // namespace tessera::photometry
