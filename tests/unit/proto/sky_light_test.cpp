#include "wire/sky_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "google/protobuf/text_format.h"
#include "photometry/sky/typical_daylight.h"

namespace tessera::wire {
namespace {

using photometry::kRadiansPerDegree;
using std::numbers::pi;
using testing::ElementsAre;
using testing::HasSubstr;

v1::SkyLight light(const std::string& text) {
  v1::SkyLight result;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &result)) << text;
  return result;
}

photometry::Sky sky(const std::string& text) {
  const auto found = sky_of(light(text));
  EXPECT_TRUE(found.ok()) << found.status();
  return found.ok() ? *found : photometry::Sky{};
}

std::string refused_sky(const std::string& text) {
  return std::string(sky_of(light(text)).status().message());
}

constexpr const char* kHigh = " toward_sun { y: 3 z: 4 } ";  // 53 degrees up in the north
constexpr const char* kSunAtNoon =
    " when { latitude_degrees: 48 longitude_degrees: 11 utc_offset_hours: 1 year: 2023 month: 6 day: 21 "
    "hour: 12 } ";

TEST(SkyLight, IsAsBrightAsItSays) {
  const photometry::Sky clear =
      sky(absl::StrCat("cie_type: 12 diffuse_horizontal_illuminance: 15000 sun_normal_illuminance: 90000 "
                       "ground_reflectance: 0.3",
                       kHigh));
  EXPECT_NEAR(photometry::diffuse_horizontal_illuminance(clear), 15'000, 1e-6);
  EXPECT_EQ(clear.sun_normal_illuminance, 90'000);
  EXPECT_NEAR(clear.sun.up, 0.8, 1e-12);
  EXPECT_NEAR(clear.ground_luminance, 0.3 * (15'000 + 0.8 * 90'000) / pi, 1e-6);
}

TEST(SkyLight, IsAsBrightAsIsTypicalWhereItDoesNotSay) {
  const double altitude = std::asin(0.8) / kRadiansPerDegree;
  const photometry::Daylight typical = *photometry::typical_daylight(12, altitude);
  const photometry::Sky clear = sky(absl::StrCat("cie_type: 12", kHigh));
  EXPECT_NEAR(photometry::diffuse_horizontal_illuminance(clear), typical.diffuse_horizontal, 1e-6);
  EXPECT_NEAR(clear.sun_normal_illuminance, typical.sun_normal, 1e-6);
  // Its own word replaces one of them.
  const photometry::Sky sunless = sky(absl::StrCat("cie_type: 12 sun_normal_illuminance: 0", kHigh));
  EXPECT_NEAR(photometry::diffuse_horizontal_illuminance(sunless), typical.diffuse_horizontal, 1e-6);
  EXPECT_EQ(sunless.sun_normal_illuminance, 0);
}

TEST(SkyLight, HasTheSunOfItsPlaceAndTime) {
  const photometry::Sky noon = sky(absl::StrCat("cie_type: 12", kSunAtNoon));
  // 21 June at 48 degrees: 90 - 48 + 23.4, a quarter of an hour before true noon.
  EXPECT_NEAR(photometry::altitude_degrees(noon.sun), 65.4, 0.3);
  EXPECT_NEAR(photometry::azimuth_degrees(noon.sun), 180, 12);
  const photometry::Sky perez = sky(
      absl::StrCat("perez { direct_normal_irradiance: 800 diffuse_horizontal_irradiance: 100 }", kSunAtNoon));
  EXPECT_NEAR(perez.sun_normal_illuminance / 800, 100, 10);
}

TEST(SkyLight, KnowsByItsMessageWhetherItHasASun) {
  EXPECT_TRUE(has_sun(light("cie_type: 12")));
  EXPECT_FALSE(has_sun(light("cie_type: 3")));
  EXPECT_FALSE(has_sun(light("cie_type: 16")));
  EXPECT_TRUE(has_sun(light("cie_type: 3 sun_normal_illuminance: 5")));
  EXPECT_FALSE(has_sun(light("cie_type: 12 sun_normal_illuminance: 0")));
  EXPECT_FALSE(has_sun(light("perez { diffuse_horizontal_irradiance: 100 }")));
  EXPECT_TRUE(has_sun(light("perez { direct_normal_irradiance: 1 }")));
  // Where it has none by its message, none shines.
  for (int type = 1; type <= 16; ++type) {
    const std::string text = absl::StrCat("cie_type: ", type, kHigh);
    EXPECT_EQ(has_sun(light(text)), sky(text).sun_normal_illuminance > 0) << type;
  }
}

TEST(SkyLight, HorizonsAreThoseOfTheWorld) {
  const auto axes = [](const std::string& text) {
    const WorldHorizon h = horizon_of(light(text));
    std::vector<int> numbers;
    for (const auto* const axis : {&h.east, &h.north, &h.up})
      for (const double x : *axis) numbers.push_back(static_cast<int>(std::lround(x)));
    return numbers;
  };
  EXPECT_THAT(axes(""), ElementsAre(1, 0, 0, 0, 1, 0, 0, 0, 1));
  EXPECT_THAT(axes("y_up: true"), ElementsAre(1, 0, 0, 0, 0, -1, 0, 1, 0));
  // North is to the right, so east is behind.
  EXPECT_THAT(axes("north_degrees: 90"), ElementsAre(0, -1, 0, 1, 0, 0, 0, 0, 1));
  EXPECT_THAT(axes("north_degrees: 90 y_up: true"), ElementsAre(0, 0, 1, 1, 0, 0, 0, 1, 0));
  const WorldHorizon turned = horizon_of(light("north_degrees: 33 y_up: true"));
  const photometry::HorizonDirection w = photometry::toward(20, 130);
  const photometry::HorizonDirection back = turned.horizon_from_world(turned.world_from_horizon(w));
  EXPECT_NEAR(photometry::angle_between(w, back), 0, 1e-12);
}

TEST(SkyLight, RefusesWhatMakesNoSky) {
  EXPECT_THAT(refused_sky(kHigh), HasSubstr("needs a model"));
  EXPECT_THAT(refused_sky(absl::StrCat("cie_type: 17", kHigh)), HasSubstr("no CIE sky of type 17"));
  EXPECT_THAT(refused_sky(absl::StrCat("cie_type: 4000000000", kHigh)), HasSubstr("no CIE sky of type"));
  EXPECT_THAT(refused_sky("cie_type: 12"),
              HasSubstr("has its pattern about the sun: it needs toward_sun, or a place"));
  EXPECT_THAT(refused_sky("cie_type: 5"),
              HasSubstr("as is typical for the sun's altitude: it needs toward_sun"));
  EXPECT_THAT(refused_sky("cie_type: 5 diffuse_horizontal_illuminance: 9 sun_normal_illuminance: 1"),
              HasSubstr("has a sun"));
  EXPECT_EQ(refused_sky("cie_type: 5 diffuse_horizontal_illuminance: 9"), "");
  EXPECT_THAT(refused_sky("cie_type: 12 toward_sun { z: -1 y: 1 }"),
              HasSubstr("45 degrees below the horizon"));
  EXPECT_THAT(refused_sky("cie_type: 12 toward_sun { }"), HasSubstr("toward_sun has no direction"));
  EXPECT_THAT(refused_sky("cie_type: 12 when { month: 2 day: 30 year: 2023 }"),
              HasSubstr("no day 30 of month 2"));
  EXPECT_THAT(refused_sky("cie_type: 12 when { month: 2 day: 3 year: 2023 latitude_degrees: 91 }"),
              HasSubstr("latitude 91"));
  EXPECT_THAT(refused_sky("cie_type: 12 when { }"), HasSubstr("year 0"));
  EXPECT_THAT(refused_sky(absl::StrCat("cie_type: 1 diffuse_horizontal_illuminance: -1", kHigh)),
              HasSubstr("diffuse_horizontal_illuminance -1"));
  EXPECT_THAT(refused_sky(absl::StrCat("cie_type: 1 sun_normal_illuminance: nan", kHigh)),
              HasSubstr("sun_normal"));
  EXPECT_THAT(refused_sky(absl::StrCat("cie_type: 1 ground_reflectance: 1.1", kHigh)),
              HasSubstr("ground_reflectance 1.1"));
  EXPECT_THAT(refused_sky(absl::StrCat("cie_type: 1 sun_degrees: 0.001", kHigh)),
              HasSubstr("sun_degrees 0.001"));
  EXPECT_THAT(refused_sky(absl::StrCat("cie_type: 1 resolution: 5000", kHigh)), HasSubstr("resolution 5000"));
  EXPECT_THAT(refused_sky(absl::StrCat("cie_type: 1 north_degrees: inf", kHigh)), HasSubstr("north_degrees"));
  EXPECT_THAT(refused_sky("perez { diffuse_horizontal_irradiance: 1 }"),
              HasSubstr("a Perez sky needs toward_sun"));
  EXPECT_THAT(refused_sky(absl::StrCat("perez { diffuse_horizontal_irradiance: -1 }", kHigh)),
              HasSubstr("diffuse_horizontal_irradiance -1"));
  EXPECT_THAT(refused_sky("perez { diffuse_horizontal_irradiance: 1 } toward_sun { z: -1 }"),
              HasSubstr("below the horizon"));
}

TEST(SkyLight, NightsOfPerezAreBlack) {
  const photometry::Sky night = sky("perez { } toward_sun { z: -1 }");
  EXPECT_EQ(photometry::luminance(night, photometry::toward(50, 0)), 0);
  EXPECT_EQ(night.ground_luminance, 0);
}

}  // namespace
}  // namespace tessera::wire
