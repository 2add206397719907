// Films and sensors by the names that photographers have for them.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace tessera::optics {

/// Millimetres.
struct FilmSize {
  double width = 36, height = 24;
};

struct FilmGauge {
  std::string_view name;
  FilmSize frame;  // what is exposed; width is not below height
  std::string_view source;
};

std::span<const FilmGauge> film_gauges();

/// Null where there is none of that name. Capitals do not matter.
const FilmGauge* find_film_gauge(std::string_view name);

/// The error for a name that is none: lists all names, and the nearest one.
std::string unknown_film_gauge(std::string_view name);

/// The largest picture whose width is `aspect` times its height, on a frame that may be turned by 90 degrees.
FilmSize picture_on(const FilmSize& frame, double aspect);

}  // namespace tessera::optics
