// Where the sun is.
#pragma once

#include "absl/status/status.h"
#include "photometry/horizon.h"

namespace tessera::photometry {

struct Place {
  double latitude_degrees = 0;   // north above 0
  double longitude_degrees = 0;  // east above 0
};

/// A moment by a clock that goes `utc_offset_hours` before universal time.
struct ClockTime {
  int year = 2000, month = 1, day = 1;
  double hour = 12;  // 0 to 24
  double utc_offset_hours = 0;
};

/// InvalidArgument says which number is none: dates of the Gregorian calendar from 1901 to 2099 are,
/// latitudes within 90, longitudes within 180 (or 360) degrees, offsets within 14 hours.
absl::Status check_place(const Place& place);
absl::Status check_time(const ClockTime& time);

struct SunPosition {
  HorizonDirection toward = {};  // as it is seen, lifted by refraction
  double altitude_degrees = 0;   // the same
  double azimuth_degrees = 0;    // from north through east
  double distance_au = 1;
};

/// The sun as seen from a place, by the low-precision theory of [Meeus1998, chapters 12, 16, 25], as the
/// calculator of NOAA has it, with parallax and with the refraction of a standard atmosphere (none from 1
/// degree below the horizon down): within 0.02 degrees of precise ephemerides from 1901 to 2099.
SunPosition sun_position(const Place& place, const ClockTime& time);

}  // namespace tessera::photometry
