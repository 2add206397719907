#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "photometry/sun/sun_irradiance.h"
#include "photometry/sun/sun_position.h"

namespace tessera::photometry {
namespace {

using testing::HasSubstr;

/// The example of [Reda2004], at 1830 m with 820 mbar: zenith 50.11162, azimuth 194.34024. Refraction at sea
/// level is 0.004 degrees more, and the theory is good to 0.01.
TEST(SunPosition, IsThatOfTheSolarPositionAlgorithm) {
  const SunPosition sun =
      sun_position({39.742476, -105.1786}, {2003, 10, 17, 12 + 30.0 / 60 + 30.0 / 3600, -7});
  EXPECT_NEAR(90 - sun.altitude_degrees, 50.11162, 0.02);
  EXPECT_NEAR(sun.azimuth_degrees, 194.34024, 0.02);
  EXPECT_NEAR(sun.distance_au, 0.9965422974, 1e-4);
}

/// [Meeus1998, example 25.b]: 13 October 1992, 0:00 dynamical time (59 s before universal time, in which
/// declination changes by 0.0003): declination -7.7838, distance 0.99760775. At the pole that is the
/// altitude, less 0.0024 of parallax; refraction ends above.
TEST(SunPosition, IsThatOfMeeus) {
  const SunPosition sun = sun_position({90, 0}, {1992, 10, 13, 0, 0});
  EXPECT_NEAR(sun.altitude_degrees, -7.7838 - 0.0024, 0.01);
  EXPECT_NEAR(sun.distance_au, 0.99760775, 1e-4);
}

/// Equinoxes and solstices of 2024 (USNO), universal time: 20 March 3:06, 20 June 20:51, 22 September 12:44,
/// 21 December 9:21. At the pole the altitude is the declination; refraction lifts 0 by 0.47 to 0.49.
TEST(SunPosition, HasTheSeasons) {
  const auto at_pole = [](int month, int day, double hour) {
    return sun_position({90, 0}, {2024, month, day, hour, 0}).altitude_degrees;
  };
  EXPECT_NEAR(at_pole(3, 20, 3.1), 0.48, 0.03);
  EXPECT_NEAR(at_pole(6, 20, 20.85), 23.436 + 0.04, 0.02);
  EXPECT_NEAR(at_pole(9, 22, 12.73), 0.48, 0.03);
  EXPECT_NEAR(at_pole(12, 21, 9.35), -23.436, 0.02);
}

TEST(SunPosition, GoesThroughTheSouthAtNoonAndTheWestBehindIt) {
  // Greenwich, 15 April, when clocks and the sun agree to half a minute, in which it turns by 0.2 degrees.
  const SunPosition noon = sun_position({51.48, 0}, {2023, 4, 15, 12, 0});
  EXPECT_NEAR(noon.azimuth_degrees, 180, 0.2);
  EXPECT_LT(sun_position({51.48, 0}, {2023, 4, 15, 8, 0}).azimuth_degrees, 120);
  EXPECT_GT(sun_position({51.48, 0}, {2023, 4, 15, 16, 0}).azimuth_degrees, 240);
  // In the south it goes through the north.
  const SunPosition south = sun_position({-35, 0}, {2023, 4, 15, 12, 0});
  EXPECT_LT(std::min(south.azimuth_degrees, 360 - south.azimuth_degrees), 0.2);
}

TEST(SunPosition, IsOfTheMomentWhateverTheClock) {
  const SunPosition a = sun_position({10, 100}, {2020, 3, 1, 1.5, 7}),
                    b = sun_position({10, 100}, {2020, 2, 29, 18.5, 0});
  EXPECT_NEAR(a.altitude_degrees, b.altitude_degrees, 1e-8);
  EXPECT_NEAR(a.azimuth_degrees, b.azimuth_degrees, 1e-8);
  // 24:00 is 0:00 of the next day, over the ends of months and years.
  for (const ClockTime& time :
       {ClockTime{2019, 12, 31, 24, 0}, ClockTime{1904, 2, 29, 24, 0}, ClockTime{2001, 4, 30, 24, 0}}) {
    ClockTime next{time.year, time.month + 1, 1, 0, 0};
    if (next.month == 13) next = {time.year + 1, 1, 1, 0, 0};
    EXPECT_NEAR(sun_position({10, 20}, time).azimuth_degrees, sun_position({10, 20}, next).azimuth_degrees,
                1e-8);
  }
}

std::string refusal(const ClockTime& time) { return std::string(check_time(time).message()); }

TEST(SunPosition, RefusesDatesAndPlacesThatAreNone) {
  EXPECT_TRUE(check_time({2024, 2, 29, 12, 5.5}).ok());
  EXPECT_THAT(refusal({2023, 2, 29, 12, 0}),
              HasSubstr("there is no day 29 of month 2 in 2023, which has 28"));
  EXPECT_THAT(refusal({2023, 4, 31, 12, 0}), HasSubstr("which has 30"));
  EXPECT_THAT(refusal({2023, 0, 1, 12, 0}), HasSubstr("month 0"));
  EXPECT_THAT(refusal({1850, 1, 1, 12, 0}), HasSubstr("year 1850"));
  EXPECT_THAT(refusal({2023, 1, 1, 25, 0}), HasSubstr("hour 25"));
  EXPECT_THAT(refusal({2023, 1, 1, 12, 15}), HasSubstr("universal time"));
  EXPECT_FALSE(check_place({91, 0}).ok());
  EXPECT_FALSE(check_place({0, -400}).ok());
  EXPECT_TRUE(check_place({-90, 180}).ok());
}

/// [Kasten1989, table]: 1 in the zenith, 1.9939 at 30 degrees, 5.5841 at 10, 10.3164 at 5, 26.3109 at
/// 1, 37.92 at 0; the formula follows them to 0.5 %.
TEST(AirMass, IsThatOfKastenAndYoung) {
  const auto close = [](double altitude, double published) {
    EXPECT_NEAR(relative_air_mass(altitude) / published, 1, 0.005) << altitude;
  };
  close(90, 1), close(30, 1.9939), close(10, 5.5841), close(5, 10.3164), close(1, 26.3109), close(0, 37.92);
  EXPECT_EQ(relative_air_mass(-5), relative_air_mass(0));
}

}  // namespace
}  // namespace tessera::photometry
