// Weather files of EnergyPlus (.epw).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "photometry/weather/weather.h"

namespace tessera::photometry {

struct WeatherFault {
  int line = 1, column = 1;
  std::string message;
};

/// Reads a file of hours of a year: eight lines of header, the first of which is LOCATION, and a line for
/// each hour of 365 days (or 366), from 1 January, 1:00, on. Values from a code on ("9999" of a radiation)
/// are missing, and counted. Appends what is wrong to `faults`: lines that do not have the fields, words that
/// are no number, values out of bounds, hours that are not there, several records an hour; after twenty it
/// says how many more there are. Years of the lines may differ, as those of typical years do.
Weather read_epw(std::string_view text, std::vector<WeatherFault>& faults);

}  // namespace tessera::photometry
