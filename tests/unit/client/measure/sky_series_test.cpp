// Series of skies: which steps they have, that nights are black, and what is refused, with its line.
#include "measure/sky_series.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "google/protobuf/text_format.h"
#include "measure/measured.h"
#include "support/process/temp_dir.h"
#include "wire/sky_light.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A scene under a clear sky of Munich in summer, behind a lamp.
ImportedScene scene_under_a_sky() {
  ImportedScene imported;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(
      "lights { point {} } lights { sky { cie_type: 12 north_degrees: 90 when { latitude_degrees: 48.14 "
      "longitude_degrees: 11.58 utc_offset_hours: 1 year: 2024 month: 6 day: 21 hour: 11 } } }",
      &imported.scene));
  return imported;
}

class SkySeriesTest : public testing::Test {
 protected:
  absl::StatusOr<SkySteps> steps_of(const std::string& series, const ImportedScene& scene,
                                    const std::string& meter = "irradiance {}") const {
    const std::string path = (folder_.path() / "meters.textproto").string();
    std::ofstream(path) << "meters { " << meter << " }\n" << series;
    const auto file = read_meter_file(path);
    return file.ok() ? sky_steps(*file, scene) : file.status();
  }
  absl::StatusOr<SkySteps> steps_of(const std::string& series) const {
    return steps_of(series, scene_under_a_sky());
  }
  static std::vector<double> values_of(const SkySteps& series) {
    std::vector<double> values;
    for (const SkyStep& step : series.steps) values.push_back(step.value);
    return values;
  }

  const support::TempDir folder_;
};

TEST_F(SkySeriesTest, HoursAreThoseOfTheClockAndNightsAreBlack) {
  const auto series = steps_of("series { hours { first: 2 last: 14 step: 4 } }");
  ASSERT_TRUE(series.ok()) << series.status();
  EXPECT_EQ(series->name, "hour");
  EXPECT_EQ(series->light, 1);
  EXPECT_THAT(values_of(*series), ElementsAre(2, 6, 10, 14));
  const SkyStep &night = series->steps[0], &noon = series->steps[2];
  EXPECT_EQ(night.word, kNightWord);
  EXPECT_LT(night.sun_altitude_degrees, 0);
  const auto black = wire::sky_of(night.sky), bright = wire::sky_of(noon.sky);
  ASSERT_TRUE(black.ok()) << black.status();
  ASSERT_TRUE(bright.ok()) << bright.status();
  EXPECT_EQ(photometry::horizontal_illuminance(*black), 0);
  EXPECT_GT(photometry::horizontal_illuminance(*bright), 50'000);
  EXPECT_EQ(noon.word, "day");
  EXPECT_EQ(noon.sky.cie_type(), 12u);
  EXPECT_EQ(noon.sky.north_degrees(), 90);
  EXPECT_EQ(noon.sky.when().hour(), 10);
}

TEST_F(SkySeriesTest, NightsAreBlackWhateverTheLightSays) {
  ImportedScene scene = scene_under_a_sky();
  v1::SkyLight& sky = *scene.scene.mutable_lights(1)->mutable_sky();
  sky.set_cie_type(5), sky.set_diffuse_horizontal_illuminance(8000), sky.set_sun_normal_illuminance(9000);
  const auto series = steps_of("series { hours { first: 0 last: 0 } }", scene);
  ASSERT_TRUE(series.ok()) << series.status();
  const auto black = wire::sky_of(series->steps[0].sky);
  ASSERT_TRUE(black.ok()) << black.status();
  EXPECT_EQ(photometry::horizontal_illuminance(*black), 0);
}

TEST_F(SkySeriesTest, ADayHas24HoursAndPartsOfThem) {
  const auto day = steps_of("series { hours {} }"),
             tenths = steps_of("series { hours { last: 0.3 step: 0.1 } }");
  ASSERT_TRUE(day.ok() && tenths.ok());
  EXPECT_EQ(day->steps.size(), 24u);
  // Sums of tenths are no tenths: the last hour counts all the same.
  ASSERT_EQ(tenths->steps.size(), 4u);
  EXPECT_DOUBLE_EQ(tenths->steps.back().value, 0.3);
}

TEST_F(SkySeriesTest, TypesAreAllOfTheCIEOrThoseThatAreSaid) {
  const auto all = steps_of("series { cie_types {} }"),
             two = steps_of("series { cie_types { types: [16, 3] } }");
  ASSERT_TRUE(all.ok() && two.ok());
  EXPECT_EQ(all->name, "cie_type");
  EXPECT_EQ(all->steps.size(), 15u);
  EXPECT_THAT(values_of(*two), ElementsAre(16, 3));
  EXPECT_THAT(all->steps[11].word, HasSubstr("clear"));
}

TEST_F(SkySeriesTest, TypesNeedNoSunWhereTheSkyDoesNot) {
  ImportedScene scene = scene_under_a_sky();
  v1::SkyLight& sky = *scene.scene.mutable_lights(1)->mutable_sky();
  sky.clear_when(), sky.set_diffuse_horizontal_illuminance(8000);
  const auto series = steps_of("series { cie_types { types: [1, 5] } }", scene);
  ASSERT_TRUE(series.ok()) << series.status();
  EXPECT_TRUE(std::isnan(series->steps[0].sun_altitude_degrees));
}

TEST_F(SkySeriesTest, HoursOfAWeatherFileAreAtItsPlace) {
  // A year of hours, each with as many W/m^2 of sky light as its number times ten; the sixth is missing.
  constexpr int kDays[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  std::ofstream file(folder_.path() / "year.epw");
  file << "LOCATION,Quito,-,XXX,made,000000,0,-78,-5,2800\n";
  for (int i = 0; i < 6; ++i) file << "COMMENTS 1,\n";
  file << "DATA PERIODS,1,1,Data,Sunday,1/1,12/31\n";
  for (int month = 1; month <= 12; ++month) {
    for (int day = 1; day <= kDays[month - 1]; ++day) {
      for (int hour = 1; hour <= 24; ++hour)
        file << "2023," << month << ',' << day << ',' << hour
             << ",0,_,15.0,9.0,70,95000,9999,9999,9999,9999,100,"
             << (month == 2 && hour == 12 ? 9999 : 10 * hour)
             << ",999999,999999,999999,9999,999,999,99,99,9999,99999,9,999999999,999,0.999,999,99,999,99\n";
    }
  }
  file.close();
  const auto series = steps_of(
      "series { weather { weather_file: \"year.epw\" month: 3 day: 21 first_hour: 5 last_hour: 9 } }");
  ASSERT_TRUE(series.ok()) << series.status();
  EXPECT_THAT(values_of(*series), ElementsAre(5, 6, 7, 8, 9));
  EXPECT_EQ(series->steps[0].word, kNightWord);
  const SkyStep& nine = series->steps[4];
  EXPECT_EQ(nine.word, "all-weather");
  EXPECT_EQ(nine.sky.perez().diffuse_horizontal_irradiance(), 90);
  EXPECT_EQ(nine.sky.perez().direct_normal_irradiance(), 100);
  EXPECT_EQ(nine.sky.when().hour(), 8.5);
  EXPECT_EQ(nine.sky.when().latitude_degrees(), 0);
  const auto day = steps_of("series { weather { weather_file: \"year.epw\" } }");
  ASSERT_TRUE(day.ok()) << day.status();
  EXPECT_EQ(day->steps[11].sky.when().month(), 6u);
  EXPECT_THAT(steps_of("series { weather { weather_file: \"year.epw\" month: 2 } }").status().message(),
              HasSubstr("hour 12: the weather file has no radiation of it"));
  EXPECT_THAT(
      steps_of("series { weather { weather_file: \"year.epw\" month: 2 day: 30 } }").status().message(),
      HasSubstr("no such day"));
}

TEST_F(SkySeriesTest, FaultsHaveTheLineOfTheSeries) {
  const auto refused = [&](const std::string& series, const ImportedScene& scene,
                           const std::string& message) {
    const auto steps = steps_of(series, scene);
    ASSERT_FALSE(steps.ok());
    EXPECT_THAT(steps.status().message(), HasSubstr("meters.textproto:2: series: "));
    EXPECT_THAT(steps.status().message(), HasSubstr(message));
  };
  ImportedScene scene = scene_under_a_sky(), none, two = scene, no_place = scene;
  *two.scene.add_lights() = scene.scene.lights(1);
  no_place.scene.mutable_lights(1)->mutable_sky()->clear_when();
  refused("series { hours {} }", none, "has no `sky` light");
  refused("series { hours {} }", two, "has 2 `sky` lights");
  refused("series { hours {} }", no_place, "does not say `when`");
  refused("series {}", scene, "says nothing of its steps");
  refused("series { hours { first: 9 last: 8 } }", scene, "not from 9 to 8");
  refused("series { hours { last: 25 } }", scene, "within 0 and 24");
  refused("series { hours { first: nan } }", scene, "within 0 and 24");
  refused("series { hours { step: 0 } }", scene, "not above 0");
  refused("series { hours { step: 1e-300 } }", scene, "more than 1000 steps");
  refused("series { cie_types { types: 17 } }", scene, "1 to 16, not 17");
  refused("series { cie_types { types: 12 } }", no_place, "cie_type 12: ");
  EXPECT_THAT(steps_of("series { hours {} }", scene, "annual_daylight {}").status().message(),
              HasSubstr("meters.textproto:1: meter 1: a year has skies of its own"));
  EXPECT_FALSE(steps_of("series { weather { weather_file: \"none.epw\" } }").ok());
}

}  // namespace
}  // namespace tessera::client
