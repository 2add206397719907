#include "photometry/sun/sun_position.h"

#include "absl/strings/str_cat.h"

namespace tessera::photometry {
namespace {

constexpr int kFirstYear = 1901, kLastYear = 2099;

bool is_leap_year(int year) { return year % 4 == 0; }  // of those years

int days_of(int year, int month) {
  constexpr int kDays[12] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  return kDays[month - 1] + (month == 2 && is_leap_year(year) ? 1 : 0);
}

/// Days since noon of 1 January 2000, universal time.
double days_since_2000(const ClockTime& time) {
  int days =
      365 * (time.year - 2000) + (time.year - 1901) / 4 - 24;  // leap days before the year; 1904 to 1996: 24
  for (int month = 1; month < time.month; ++month) days += days_of(time.year, month);
  return days + time.day - 1 + (time.hour - time.utc_offset_hours) / 24 - 0.5;
}

double sin_degrees(double x) { return std::sin(x * kRadiansPerDegree); }
double cos_degrees(double x) { return std::cos(x * kRadiansPerDegree); }

struct Equatorial {
  double right_ascension = 0, declination = 0;  // radians
  double distance_au = 1;
};

/// [Meeus1998, chapter 25], `t` in centuries since 2000.
Equatorial apparent_sun(double t) {
  const double mean_longitude = 280.46646 + t * (36000.76983 + t * 0.0003032);
  const double anomaly = 357.52911 + t * (35999.05029 - t * 0.0001537);
  const double eccentricity = 0.016708634 - t * (0.000042037 + t * 0.0000001267);
  const double centre = (1.914602 - t * (0.004817 + t * 0.000014)) * sin_degrees(anomaly) +
                        (0.019993 - t * 0.000101) * sin_degrees(2 * anomaly) +
                        0.000289 * sin_degrees(3 * anomaly);
  const double node = 125.04 - 1934.136 * t;  // of the moon, for nutation
  const double longitude = mean_longitude + centre - 0.00569 - 0.00478 * sin_degrees(node);
  const double obliquity =
      23.43929111 - t * (0.0130042 + t * (0.00000016 - t * 0.000000504)) + 0.00256 * cos_degrees(node);
  return {
      .right_ascension = std::atan2(cos_degrees(obliquity) * sin_degrees(longitude), cos_degrees(longitude)),
      .declination = std::asin(sin_degrees(obliquity) * sin_degrees(longitude)),
      .distance_au = 1.000001018 * (1 - eccentricity * eccentricity) /
                     (1 + eccentricity * cos_degrees(anomaly + centre))};
}

/// Degrees by which air lifts what is at an altitude [Saemundsson1986].
double refraction_degrees(double altitude) {
  if (altitude < -1 || altitude > 89.9) return 0;
  return 1.02 / 60 / std::tan((altitude + 10.3 / (altitude + 5.11)) * kRadiansPerDegree);
}

absl::Status refuse(const char* what, double value, const char* allowed) {
  return absl::InvalidArgumentError(absl::StrCat(what, " ", value, " is not ", allowed));
}

}  // namespace

absl::Status check_place(const Place& place) {
  if (!(std::abs(place.latitude_degrees) <= 90))
    return refuse("latitude", place.latitude_degrees, "within -90 and 90 degrees");
  if (!(std::abs(place.longitude_degrees) <= 360))
    return refuse("longitude", place.longitude_degrees, "within -360 and 360 degrees");
  return absl::OkStatus();
}

absl::Status check_time(const ClockTime& time) {
  if (time.year < kFirstYear || time.year > kLastYear)
    return refuse("year", time.year, "within 1901 and 2099");
  if (time.month < 1 || time.month > 12) return refuse("month", time.month, "within 1 and 12");
  if (time.day < 1 || time.day > days_of(time.year, time.month)) {
    return absl::InvalidArgumentError(absl::StrCat("there is no day ", time.day, " of month ", time.month,
                                                   " in ", time.year, ", which has ",
                                                   days_of(time.year, time.month)));
  }
  if (!(time.hour >= 0 && time.hour <= 24)) return refuse("hour", time.hour, "within 0 and 24");
  if (!(std::abs(time.utc_offset_hours) <= 14))
    return refuse("offset from universal time of", time.utc_offset_hours, "within -14 and 14 hours");
  return absl::OkStatus();
}

SunPosition sun_position(const Place& place, const ClockTime& time) {
  const double days = days_since_2000(time);
  const Equatorial sun = apparent_sun(days / 36525);
  const double sidereal = std::fmod(280.46061837 + 360.98564736629 * days, 360.0);
  const double hour_angle = (sidereal + place.longitude_degrees) * kRadiansPerDegree - sun.right_ascension;
  const double sin_latitude = sin_degrees(place.latitude_degrees);
  const double cos_latitude = cos_degrees(place.latitude_degrees);
  const double sin_declination = std::sin(sun.declination), cos_declination = std::cos(sun.declination);

  const double up = sin_latitude * sin_declination + cos_latitude * cos_declination * std::cos(hour_angle);
  const double east = -cos_declination * std::sin(hour_angle);
  const double north = cos_latitude * sin_declination - sin_latitude * cos_declination * std::cos(hour_angle);
  const HorizonDirection geometric{east, north, up};

  SunPosition position{.distance_au = sun.distance_au};
  constexpr double kParallaxDegrees = 8.794 / 3600;
  double altitude = altitude_degrees(geometric);
  altitude -= kParallaxDegrees / sun.distance_au * cos_degrees(altitude);
  position.altitude_degrees = altitude + refraction_degrees(altitude);
  position.azimuth_degrees = azimuth_degrees(geometric);
  position.toward = toward(position.altitude_degrees, position.azimuth_degrees);
  return position;
}

}  // namespace tessera::photometry
