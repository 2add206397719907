#include "spectra/sensor/sensor_name.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/nearest_name.h"
#include "spectra/camera/cameras.h"
#include "spectra/color/tristimulus.h"
#include "spectra/light/daylight.h"
#include "spectra/light/illuminants.h"
#include "spectra/light/planck.h"

namespace tessera::spectra {
namespace {

constexpr std::string_view kBand = "band:";
constexpr double kLeastKelvin = 1000, kLeastDaylightKelvin = 4000, kMostKelvin = 25000;

/// "nikon-d5100" of "Nikon D5100".
std::string word_of(std::string name) {
  std::ranges::replace(name, ' ', '-');
  absl::AsciiStrToLower(&name);
  return name;
}

/// The finite number that the text is; NaN: it is none.
double number_in(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = error == std::errc{} && end == text.data() + text.size() && std::isfinite(number);
  return is_number ? number : std::numeric_limits<double>::quiet_NaN();
}

/// Light of a colour temperature, sampled where observers see.
Curve light_of(double kelvin) {
  if (kelvin >= kLeastDaylightKelvin) return *daylight(kelvin);
  constexpr double kStepNm = 5;
  Curve curve;
  for (double nm = kLeastSensorNm; nm <= kMostSensorNm; nm += kStepNm) {
    curve.nm.push_back(static_cast<float>(nm));
    curve.values.push_back(static_cast<float>(relative_planck(nm, kelvin)));
  }
  return curve;
}

}  // namespace

absl::StatusOr<NmRange> parse_nm_range(const std::string& text, const std::string& what) {
  const std::size_t hyphen = std::min(text.find('-'), text.size());
  const std::string_view numbers = text;
  const double from = number_in(numbers.substr(0, hyphen)),
               to = hyphen == text.size() ? number_in("") : number_in(numbers.substr(hyphen + 1));
  if (std::isnan(from) || std::isnan(to)) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected FROM-TO in nanometres for ", what, ", as in 550-560, not '", text, "'"));
  }
  if (from >= to)
    return absl::InvalidArgumentError(absl::StrCat(what, " begins at ", from, " nm and ends at ", to, " nm"));
  if (from < kLeastSensorNm || to > kMostSensorNm) {
    return absl::InvalidArgumentError(absl::StrCat(what, " is from ", from, " to ", to,
                                                   " nm; wavelengths are ", kLeastSensorNm, " to ",
                                                   kMostSensorNm, " nm"));
  }
  return NmRange{from, to};
}

std::vector<std::string> sensor_names() {
  std::vector<std::string> names = {"cie1931", "cie2006", "cie2006-10"};
  for (const std::string& camera : camera_names()) names.push_back(word_of(camera));
  names.emplace_back("film");
  return names;
}

absl::StatusOr<NamedSensor> parse_sensor(const std::string& text) {
  const std::string word = word_of(text);
  if (word == "cie1931") return NamedSensor{SensorKind::kObserver, cie1931()};
  if (word == "cie2006") return NamedSensor{SensorKind::kObserver, cie2006()};
  if (word == "cie2006-10") return NamedSensor{SensorKind::kObserver, cie2006_10()};
  if (word == "film") return NamedSensor{SensorKind::kFilm};
  for (const std::string& camera : camera_names()) {
    if (word == word_of(camera)) return NamedSensor{SensorKind::kCamera, *find_camera(camera)};
  }
  if (word.starts_with(kBand)) {
    const absl::StatusOr<NmRange> range = parse_nm_range(word.substr(kBand.size()), "the sensor's band");
    if (!range.ok()) return range.status();
    return NamedSensor{SensorKind::kBand, {}, range->from, range->to};
  }
  const std::vector<std::string> names = sensor_names();
  return absl::InvalidArgumentError(absl::StrCat("there is no sensor '", text,
                                                 "'; there is: ", absl::StrJoin(names, ", "),
                                                 ", band:FROM-TO", base::did_you_mean(text, names)));
}

std::optional<double> kelvin_of_white_balance(std::string_view text) {
  if (text.ends_with('K') || text.ends_with('k')) text.remove_suffix(1);
  const double kelvin = number_in(text);
  return std::isnan(kelvin) ? std::nullopt : std::optional(kelvin);
}

absl::StatusOr<std::optional<Curve>> parse_white_balance(const std::string& text) {
  if (text == "none") return std::nullopt;
  std::optional<Curve> light;
  if (const std::optional<double> kelvin = kelvin_of_white_balance(text)) {
    if (*kelvin < kLeastKelvin || *kelvin > kMostKelvin) {
      return absl::InvalidArgumentError(absl::StrCat("white balance is ", *kelvin, " K; ", kLeastKelvin,
                                                     " to ", kMostKelvin, " K was expected"));
    }
    light = light_of(*kelvin);
  }
  std::vector<std::string> names(std::begin(kIlluminantNames), std::end(kIlluminantNames));
  for (const std::string& name : names) {
    if (!light && absl::EqualsIgnoreCase(name, text)) light = find_illuminant(name);
  }
  if (!light) {
    names.emplace_back("none");
    return absl::InvalidArgumentError(
        absl::StrCat("there is no illuminant '", text, "'; there is: ", absl::StrJoin(names, ", "),
                     ", or kelvin, as in 5600K", base::did_you_mean(text, names)));
  }
  const double luminance = tristimulus(*light, cie1931())[1];
  for (float& value : light->values) value = static_cast<float>(value / luminance);
  return light;
}

}  // namespace tessera::spectra
