#include "optics/film_gauge.h"

#include <algorithm>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/nearest_name.h"

namespace tessera::optics {

namespace {

constexpr std::string_view kRollFilm = "ISO 732, frames of cameras for film 120",
                           kSheetFilm = "what usual holders of sheet film leave open, nominal";

// Camera apertures of cine film, frames of still film, light-sensitive areas of sensors.
constexpr FilmGauge kGauges[] = {{"full-frame", {36, 24}, "ISO 1007"},
                                 {"135", {36, 24}, "ISO 1007"},
                                 {"aps-c", {23.6, 15.6}, "sensors of Nikon and Sony, nominal"},
                                 {"aps-c-canon", {22.3, 14.9}, "sensors of Canon, nominal"},
                                 {"micro-four-thirds", {17.3, 13}, "Four Thirds standard"},
                                 {"1-inch", {13.2, 8.8}, "sensors of video tube size 1 inch, nominal"},
                                 {"6x4.5", {56, 41.5}, kRollFilm},
                                 {"6x6", {56, 56}, kRollFilm},
                                 {"6x7", {70, 56}, kRollFilm},
                                 {"6x9", {84, 56}, kRollFilm},
                                 {"6x17", {168, 56}, kRollFilm},
                                 {"4x5", {120, 96}, kSheetFilm},
                                 {"5x7", {170, 120}, kSheetFilm},
                                 {"8x10", {245, 194}, kSheetFilm},
                                 {"super8", {5.79, 4.01}, "ISO 1700"},
                                 {"16mm", {10.26, 7.49}, "SMPTE ST 7"},
                                 {"super16", {12.52, 7.41}, "SMPTE ST 201, type W"},
                                 {"academy", {21.95, 16}, "SMPTE ST 59, with room for sound"},
                                 {"super35", {24.89, 18.66}, "SMPTE ST 59, full aperture, 4 perforations"},
                                 {"super35-3perf", {24.89, 13.87}, "3 perforations"},
                                 {"65mm", {52.48, 23.01}, "SMPTE ST 215, 5 perforations"},
                                 {"imax", {70.41, 52.63}, "15 perforations of film of 65 mm"}};

}  // namespace

std::span<const FilmGauge> film_gauges() { return kGauges; }

const FilmGauge* find_film_gauge(std::string_view name) {
  const std::string small = absl::AsciiStrToLower(std::string(name));
  const auto* const found = std::ranges::find(kGauges, std::string_view(small), &FilmGauge::name);
  return found == std::end(kGauges) ? nullptr : found;
}

std::string unknown_film_gauge(std::string_view name) {
  std::vector<std::string> names;
  for (const FilmGauge& gauge : kGauges) names.emplace_back(gauge.name);
  return absl::StrCat("there is no film gauge '", std::string(name),
                      "'; there is: ", absl::StrJoin(names, ", "), base::did_you_mean(name, names));
}

FilmSize picture_on(const FilmSize& frame, double aspect) {
  double longer = std::max(frame.width, frame.height), shorter = std::min(frame.width, frame.height);
  const double wide = std::max(aspect, 1 / aspect);
  if (longer > shorter * wide) {
    longer = shorter * wide;
  } else {
    shorter = longer / wide;
  }
  return aspect >= 1 ? FilmSize{longer, shorter} : FilmSize{shorter, longer};
}

}  // namespace tessera::optics
