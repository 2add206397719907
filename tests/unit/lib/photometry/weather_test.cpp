#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "photometry/weather/epw.h"

namespace tessera::photometry {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr int kHeader = 8, kHoursOfYear = 8760;

/// Lines of a file of one year; every hour of the day has the same values.
std::vector<std::string> lines_of_year() {
  std::vector<std::string> lines = {"LOCATION,Nowhere,-,XXX,made up,000000,48.10,11.60,1.0,520.0",
                                    "DESIGN CONDITIONS,0",
                                    "TYPICAL/EXTREME PERIODS,0",
                                    "GROUND TEMPERATURES,0",
                                    "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0",
                                    "COMMENTS 1,none",
                                    "COMMENTS 2,none",
                                    "DATA PERIODS,1,1,Data,Sunday,1/1,12/31"};
  constexpr int kDays[12] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  for (int month = 1; month <= 12; ++month) {
    for (int day = 1; day <= kDays[month - 1]; ++day) {
      for (int hour = 1; hour <= 24; ++hour)
        lines.push_back(absl::StrCat(month < 7 ? 1999 : 2003, ",", month, ",", day, ",", hour,
                                     ",0,flags,10.0,5.5,70,101300,0,1400,300,", hour, "50,", hour, "00,",
                                     hour, "5,999999,999999,999999,9999,0,0"));
    }
  }
  return lines;
}

struct ReadWeather {
  Weather weather;
  std::vector<WeatherFault> faults;
};
ReadWeather read(const std::vector<std::string>& lines, const char* end_of_line = "\n") {
  ReadWeather result;
  result.weather = read_epw(absl::StrJoin(lines, end_of_line), result.faults);
  return result;
}

std::string told(const ReadWeather& read) {
  return absl::StrJoin(read.faults, "\n", [](std::string* out, const WeatherFault& fault) {
    absl::StrAppend(out, fault.line, ":", fault.column, ": ", fault.message);
  });
}

/// The line of an hour of the year, from 0.
std::size_t line_of(int hour) { return static_cast<std::size_t>(kHeader + hour); }

TEST(Epw, HasThePlaceAndTheHours) {
  for (const char* const end_of_line : {"\n", "\r\n"}) {
    const ReadWeather year = read(lines_of_year(), end_of_line);
    EXPECT_THAT(told(year), IsEmpty());
    EXPECT_EQ(year.weather.city, "Nowhere");
    EXPECT_EQ(year.weather.place.latitude_degrees, 48.1);
    EXPECT_EQ(year.weather.place.longitude_degrees, 11.6);
    EXPECT_EQ(year.weather.utc_offset_hours, 1);
    EXPECT_EQ(year.weather.elevation_metres, 520);
    ASSERT_THAT(year.weather.hours, SizeIs(kHoursOfYear));
    const WeatherHour& hour = year.weather.hours[24 * 31 + 9];
    EXPECT_EQ(hour.month, 2);
    EXPECT_EQ(hour.day, 1);
    EXPECT_EQ(hour.hour, 10);
    EXPECT_EQ(hour.line, kHeader + 24 * 31 + 9 + 1);
    EXPECT_EQ(hour.direct_normal, 1000);
    EXPECT_EQ(hour.diffuse_horizontal, 105);
    EXPECT_EQ(hour.global_horizontal, 1050);
    EXPECT_EQ(hour.dew_point_celsius, 5.5);
    EXPECT_EQ(middle_of(year.weather, hour).hour, 9.5);
    EXPECT_THAT(missing_values(year.weather), IsEmpty());
  }
}

TEST(Epw, NamesHoursThatAreMissing) {
  std::vector<std::string> lines = lines_of_year();
  lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(line_of(24 * 59 + 3)),
              lines.begin() + static_cast<std::ptrdiff_t>(line_of(24 * 59 + 5)));
  EXPECT_EQ(told(read(lines)),
            absl::StrCat(line_of(24 * 59 + 3) + 1,
                         ":1: 2 hours are missing before day 1 of month 3, hour 6: from day 1 of "
                         "month 3, hour 4 on"));
  lines = lines_of_year();
  lines.resize(line_of(kHoursOfYear - 1));
  EXPECT_THAT(told(read(lines)),
              HasSubstr("the file ends after day 31 of month 12, hour 23; 1 hour of the year is missing"));
  lines.resize(kHeader);
  EXPECT_THAT(told(read(lines)),
              HasSubstr("the file ends without an hour; 8760 hours of the year are missing"));
}

TEST(Epw, CountsValuesThatAreMissing) {
  std::vector<std::string> lines = lines_of_year();
  lines[line_of(12)] = "1999,1,1,13,0,flags,10,99.9,70,101300,0,1400,300,400,9999,120";
  lines[line_of(13)] = "1999,1,1,14,0,flags,10,5,70,101300,0,1400,300,,9999,120";
  const ReadWeather year = read(lines);
  EXPECT_THAT(told(year), IsEmpty());
  EXPECT_EQ(missing_values(year.weather),
            "dew point temperature is missing in 1 hour, global horizontal radiation is missing in 1 hour, "
            "direct normal "
            "radiation is missing in 2 hours");
  // A missing value follows from the others, where they are there: (400 - 120) / sin 30.
  const auto found = irradiances_of(year.weather.hours[12], 30);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->direct_normal, 560, 1e-9);
  EXPECT_EQ(found->diffuse_horizontal, 120);
  EXPECT_FALSE(irradiances_of(year.weather.hours[13], 30));
  // Noon: there is light, of which the file tells nothing.
  const WeatherSky sky = sky_of(year.weather, year.weather.hours[13]);
  EXPECT_FALSE(sky.has_data);
  EXPECT_FALSE(sky.sky);
}

TEST(Epw, LocatesWhatIsWrong) {
  const auto faults_with = [](std::size_t line, const std::string& text) {
    std::vector<std::string> lines = lines_of_year();
    lines[line] = text;
    return told(read(lines));
  };
  EXPECT_THAT(faults_with(0, "LOCATION,a,b,c,d,e,95,11,1,500"),
              HasSubstr("1:20: latitude 95 is not within -90 and 90"));
  EXPECT_THAT(faults_with(0, "LOCATION,a,b"), HasSubstr("1:1: LOCATION has 2 values; nine are expected"));
  EXPECT_THAT(faults_with(0, "city,a,b"), HasSubstr("not a weather file of EnergyPlus"));
  EXPECT_THAT(faults_with(7, "DATA PERIODS,1,4,Data"), HasSubstr("8:16: 4 records an hour"));
  EXPECT_THAT(faults_with(8, "1999,1,1,1,0,f,10,5,70,101300,0,1400,300,0,many,0"),
              HasSubstr("9:44: direct normal radiation: 'many' is no number"));
  EXPECT_THAT(faults_with(8, "1999,1,1,1,0,f,10,5,70,101300,0,1400,300,0,-3,0"),
              HasSubstr("9:44: direct normal radiation -3 is not within 0 and 9999"));
  EXPECT_THAT(faults_with(8, "1999,1,1,1,0,f,10"), HasSubstr("9:1: an hour has 7 values; 16 are expected"));
  EXPECT_THAT(faults_with(9, "1999,1,1.5,1,0,f,10,5,70,101300,0,1400,300,0,0,0"), HasSubstr("10:8: day 1.5"));
  EXPECT_THAT(faults_with(9, "1999,2,30,1,0,f,10,5,70,101300,0,1400,300,0,0,0"),
              HasSubstr("month 2 has no day 30"));
  // The same hour a second time.
  EXPECT_THAT(faults_with(9, "1999,1,1,1,0,f,10,5,70,101300,0,1400,300,0,0,0"),
              HasSubstr("10:1: day 1 of month 1, hour 1 comes after day 1 of month 1, hour 1"));
}

TEST(Epw, TellsAtMostTwentyFaults) {
  std::vector<std::string> lines = lines_of_year();
  for (int i = 0; i < 30; ++i) lines[line_of(i)] = "x";
  const ReadWeather year = read(lines);
  ASSERT_THAT(year.faults, SizeIs(21));
  // 30 lines, and the gap that they leave.
  EXPECT_EQ(year.faults.back().message, "and 11 more faults");
}

TEST(Epw, LeapYearsAreYears) {
  std::vector<std::string> lines = lines_of_year();
  std::vector<std::string> leap_day;
  for (int hour = 1; hour <= 24; ++hour)
    leap_day.push_back(absl::StrCat("1999,2,29,", hour, ",0,f,10,5,70,101300,0,1400,300,0,0,0"));
  lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(line_of(24 * 59)), leap_day.begin(),
               leap_day.end());
  const ReadWeather year = read(lines);
  EXPECT_THAT(told(year), IsEmpty());
  EXPECT_THAT(year.weather.hours, SizeIs(kHoursOfYear + 24));
  // A day of a year that has it.
  EXPECT_TRUE(check_time(middle_of(year.weather, year.weather.hours[24 * 59])).ok());
}

TEST(Epw, WhateverElseIsNoFile) {
  for (const char* const text : {"", "\n", "LOCATION", "\xEF\xBB\xBF", ",,,,", "\0"}) {
    std::vector<WeatherFault> faults;
    read_epw(text, faults);
    EXPECT_FALSE(faults.empty()) << text;
  }
}

TEST(WeatherSkies, AreThoseOfThePerezModel) {
  const Weather weather = read(lines_of_year()).weather;
  // 1 July, the hour before 13:00: a high sun.
  const std::size_t noon = 24 * 181 + 12;
  ASSERT_EQ(weather.hours[noon].month, 7);
  const WeatherSky day = sky_of(weather, weather.hours[noon]);
  ASSERT_TRUE(day.sky);
  EXPECT_NEAR(day.sun.azimuth_degrees, 180, 25);
  EXPECT_GT(day.sky->sun_normal_illuminance, 80 * 1300);
  EXPECT_GT(diffuse_horizontal_illuminance(*day.sky), 90 * 135);
  const WeatherSky night = sky_of(weather, weather.hours[24 * 181]);
  EXPECT_FALSE(night.sky);
  EXPECT_TRUE(night.has_data);
}

}  // namespace
}  // namespace tessera::photometry
