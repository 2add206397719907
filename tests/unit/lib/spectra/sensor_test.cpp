// Sensors by their names, against integrals that are computed here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "spectra/color/lab.h"
#include "spectra/color/tristimulus.h"
#include "spectra/light/daylight.h"
#include "spectra/light/illuminants.h"
#include "spectra/sensor/bands.h"
#include "spectra/sensor/sensor_name.h"
#include "spectra/sensor/sensor_response.h"
#include "unit/lib/spectra/macbeth.h"

namespace tessera::spectra {
namespace {

using testing::HasSubstr;

SensorResponse response_of(const std::string& sensor, const std::string& white = "D65",
                           const RgbSpace& space = kRec709) {
  return *sensor_response(*parse_sensor(sensor), *parse_white_balance(white), space);
}

Curve of_luminance_one(const std::string& illuminant) { return **parse_white_balance(illuminant); }

/// The sum over half nanometres of an observer's sensitivities times f(nm).
template <class F>
Triple summed(const Observer& observer, F&& f) {
  Triple sums = {0, 0, 0};
  for (double nm = 300.25; nm < 1000; nm += 0.5) {
    const Triple at = observer.at(nm);
    for (std::size_t c = 0; c < 3; ++c) sums[c] += 0.5 * at[c] * f(nm);
  }
  return sums;
}

std::string refusal(const absl::Status& status) { return std::string(status.message()); }

TEST(Sensors, DaylightIsWhiteInEverySpace) {
  for (const char* sensor :
       {"cie1931", "cie2006", "cie2006-10", "nikon-d5100", "Nikon D5100", "band:550-560"}) {
    const Triple white = seen(response_of(sensor), unit_d65());
    for (const double channel : white) EXPECT_NEAR(channel, 1, 1e-9) << sensor;
  }
  for (const RgbSpace& space : {kRec2020, kP3D65, kAcesCg}) {
    for (const double channel : seen(response_of("cie1931", "D65", space), unit_d65()))
      EXPECT_NEAR(channel, 1, 1e-9);
  }
}

TEST(Sensors, ChromaticityOfDaylightIsThePublishedOne) {
  const Triple rgb = seen(response_of("cie1931", "none"), unit_d65());
  const Chromaticity white = chromaticity(times(xyz_from_rgb(kRec709), rgb));
  EXPECT_NEAR(white.x, 0.31272, 1e-4);
  EXPECT_NEAR(white.y, 0.32903, 1e-4);
  EXPECT_NEAR(times(xyz_from_rgb(kRec709), rgb)[1], 1, 1e-6);
  // To the 10-degree observer of 2006 it has others [CIE 170-2:2015], which its own sums have, too.
  const Triple other = seen(response_of("cie2006-10", "none"), unit_d65());
  const Chromaticity expected =
      chromaticity(summed(cie2006_10(), [](double nm) { return unit_d65().at(nm); }));
  const Chromaticity actual = chromaticity(times(xyz_from_rgb(kRec709), other));
  EXPECT_NEAR(actual.x, expected.x, 1e-4);
  EXPECT_NEAR(actual.y, expected.y, 1e-4);
  EXPECT_GT(std::abs(actual.x - white.x) + std::abs(actual.y - white.y), 5e-4);
}

TEST(Sensors, PatchesHaveTheirColoursUnderEachLight) {
  for (const char* light : {"A", "D50", "D65", "F2"}) {
    const Curve lamp = *find_illuminant(light);
    const Triple lamp_sum = summed(cie1931(), [&](double nm) { return lamp.at(nm); });
    const SensorResponse as_it_is = response_of("cie1931", "none"), balanced = response_of("cie1931", light);
    const double luminance = seen(as_it_is, lamp)[0] * 0.212639 + seen(as_it_is, lamp)[1] * 0.715169 +
                             seen(as_it_is, lamp)[2] * 0.072192;
    for (const MacbethPatch& patch : kMacbeth) {
      const Curve reflectance = patch.curve();
      // The sum of what the sensor sees, in steps of a nanometre, of light from the patch.
      Curve reflected;
      for (float nm = 360; nm <= 830; ++nm) {
        reflected.nm.push_back(nm);
        reflected.values.push_back(static_cast<float>(reflectance.at(nm) * lamp.at(nm) / luminance));
      }
      Triple expected = summed(cie1931(), [&](double nm) { return reflectance.at(nm) * lamp.at(nm); }),
             white{};
      for (std::size_t c = 0; c < 3; ++c) white[c] = lamp_sum[c] / lamp_sum[1], expected[c] /= lamp_sum[1];
      const Lab published = lab_of(expected, white);
      const Triple plain = times(xyz_from_rgb(kRec709), seen(as_it_is, reflected));
      EXPECT_LT(delta_e2000(lab_of(plain, white), published), 0.05) << patch.name << " under " << light;
      // White on white, with the cones of Bradford.
      const Triple adapted = times(bradford(chromaticity(white), kWhiteD65), expected);
      const Triple shown = times(xyz_from_rgb(kRec709), seen(balanced, reflected));
      EXPECT_LT(delta_e2000(lab_of(shown, xyz_of(kWhiteD65)), lab_of(adapted, xyz_of(kWhiteD65))), 0.05)
          << patch.name << " balanced for " << light;
    }
  }
}

TEST(Sensors, GreyIsGreyToACameraThatIsBalanced) {
  for (const char* light : {"A", "F2", "3200K", "5600K"}) {
    const Curve lamp = of_luminance_one(light);
    for (const double channel : seen(response_of("nikon-d5100", light), lamp)) EXPECT_NEAR(channel, 1, 1e-6);
  }
  const Triple without = seen(response_of("nikon-d5100", "none"), of_luminance_one("A"));
  EXPECT_GT(without[0] / without[2], 2);
  EXPECT_NEAR(seen(response_of("nikon-d5100", "none"), unit_d65())[1], 1, 1e-9);
}

TEST(Sensors, ABandSeesItsLinesAndNoOthers) {
  const SensorResponse sensor = response_of("band:550.5-560");
  const auto line = [](float nm) { return Curve{{nm - 1, nm, nm + 1}, {0, 3, 0}}; };  // zero beyond its ends
  // The line's area over that of daylight in the band, each by its own sum.
  double daylight = 0;
  for (double nm = 550.505; nm < 560; nm += 0.01) daylight += 0.01 * unit_d65().at(nm);
  for (const double channel : seen(sensor, line(555))) EXPECT_NEAR(channel, 3 / daylight, 1e-4);
  EXPECT_EQ(seen(sensor, line(548))[0], 0);
  EXPECT_EQ(seen(sensor, line(562))[0], 0);
  // Half of it is in the band.
  EXPECT_NEAR(seen(sensor, line(560))[0], 1.5 / daylight, 1e-4);
}

TEST(Sensors, BandsThatMeetSeeAsOne) {
  const SensorResponse camera = response_of("nikon-d5100");
  const Bands bands = *parse_film("spectral:13:333.3-901.7");
  Triple sum = {0, 0, 0};
  for (int b = 0; b < bands.count; ++b) {
    const Triple part = seen(camera, bands.begin(b), bands.begin(b + 1));
    for (std::size_t c = 0; c < 3; ++c) sum[c] += part[c];
  }
  const Triple all = seen(camera, camera.from_nm, camera.to_nm);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], all[c], 1e-9 * all[c]);
}

TEST(Sensors, OwnSensitivitiesAreOneOrThree) {
  const Curve red{{600, 650, 700}, {0, 1, 0}}, green{{500, 550, 600}, {0, 1, 0}},
      blue{{400, 450, 500}, {0, 1, 0}};
  const NamedSensor film = *parse_sensor("film");
  const Curve all[] = {red, green, blue};
  const auto three = sensor_response(film, unit_d65(), kRec709, all);
  ASSERT_TRUE(three.ok());
  EXPECT_EQ(three->from_nm, 400);
  EXPECT_EQ(three->to_nm, 700);
  EXPECT_GT(three->at(650)[0], 0);
  EXPECT_EQ(three->at(650)[1], 0);
  const auto one = sensor_response(film, unit_d65(), kRec709, {&green, 1});
  ASSERT_TRUE(one.ok());
  EXPECT_EQ(one->at(540)[0], one->at(540)[2]);
  EXPECT_EQ(one->at(610)[1], 0);
  // Light that ends before the sensor begins.
  const Curve far{{900, 950}, {1, 1}}, near{{400, 500, 500.5f}, {1, 1, 0}};
  EXPECT_THAT(refusal(sensor_response(film, near, kRec709, {&far, 1}).status()), HasSubstr("white balance"));
}

TEST(Sensors, UnknownNamesAreToldWithTheNearest) {
  EXPECT_THAT(refusal(parse_sensor("cie1932").status()), HasSubstr("did you mean 'cie1931'?"));
  EXPECT_THAT(refusal(parse_sensor("nikon d5200").status()), HasSubstr("did you mean 'nikon-d5100'?"));
  EXPECT_THAT(refusal(parse_white_balance("D56").status()), HasSubstr("did you mean 'D50'?"));
  EXPECT_THAT(refusal(parse_white_balance("900K").status()), HasSubstr("1000 to 25000 K"));
  EXPECT_THAT(refusal(parse_white_balance("1e9").status()), HasSubstr("1000 to 25000 K"));
  EXPECT_THAT(refusal(parse_sensor("band:560-550").status()),
              HasSubstr("begins at 560 nm and ends at 550 nm"));
  EXPECT_THAT(refusal(parse_sensor("band:250-560").status()), HasSubstr("300 to 1000 nm"));
  EXPECT_THAT(refusal(parse_sensor("band:550").status()), HasSubstr("FROM-TO"));
  EXPECT_THAT(refusal(parse_sensor("band:nan-560").status()), HasSubstr("FROM-TO"));
  EXPECT_FALSE(parse_white_balance("none")->has_value());
}

TEST(Bands, AreReadAndNamed) {
  EXPECT_EQ(parse_film("rgb")->count, 0);
  const Bands bands = *parse_film("spectral:4:400-800");
  EXPECT_EQ(bands.width(), 100);
  EXPECT_EQ(band_channel(bands.centre(1)), "S0.550,000000nm");
  EXPECT_EQ(centre_of_channel("S0.550,000000nm"), 550);
  for (const char* other : {"S0.nm", "S1.550,0nm", "S0.550,0m", "R", "S0.abcnm"})
    EXPECT_FALSE(centre_of_channel(other).has_value()) << other;
  EXPECT_EQ(parse_film("spectral:31")->from_nm, 380);
  EXPECT_THAT(refusal(parse_film("spectral:0").status()), HasSubstr("1 to 512 bands"));
  EXPECT_THAT(refusal(parse_film("spectral:10000").status()), HasSubstr("1 to 512 bands"));
  EXPECT_THAT(refusal(parse_film("spectral:8:200-700").status()), HasSubstr("300 to 1000 nm"));
  EXPECT_THAT(refusal(parse_film("spectral:8:700-400").status()), HasSubstr("begins at 700"));
  EXPECT_THAT(refusal(parse_film("spectral").status()), HasSubstr("spectral:N"));
  EXPECT_THAT(refusal(parse_film("spektral:8").status()), HasSubstr("did you mean 'spectral'?"));
  EXPECT_THAT(refusal(parse_film("spectral:8:").status()), HasSubstr("FROM-TO"));
}

}  // namespace
}  // namespace tessera::spectra
