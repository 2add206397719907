// Names that people have for the sensor of a picture, its white balance and its bands.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "spectra/curve.h"
#include "spectra/observer/observer.h"

namespace tessera::spectra {

/// Wavelengths that sensors and bands may have, in nanometres.
inline constexpr double kLeastSensorNm = 300, kMostSensorNm = 1000;

enum class SensorKind { kObserver, kCamera, kBand, kFilm };

/// A sensor that was named, before it has a white balance.
struct NamedSensor {
  SensorKind kind = SensorKind::kObserver;
  Observer sensitivities{};       // of observers (x, y and z) and cameras (R, G and B)
  double from_nm = 0, to_nm = 0;  // kBand
};

/// "cie1931", "cie2006", "cie2006-10": observers; a camera's name in any letters, with hyphens for spaces
/// ("nikon-d5100"); "band:550-560", which sees these wavelengths alike and no others; "film": the
/// sensitivities of the scene's own film. InvalidArgument, with the nearest name, for any other.
absl::StatusOr<NamedSensor> parse_sensor(const std::string& text);

/// The words that parse_sensor() takes, but for those of bands.
std::vector<std::string> sensor_names();

/// The light that a sensor takes for white: a CIE illuminant by name, or a colour temperature from 1000 K to
/// 25000 K ("5600K"), daylight from 4000 K on and Planck's law below. Scaled to a luminance of 1 by the CIE
/// 1931 observer. Nothing for "none". InvalidArgument, with the nearest name, for any other.
absl::StatusOr<std::optional<Curve>> parse_white_balance(const std::string& text);

/// The colour temperature that a white balance names; nothing where it names a light, or nothing.
std::optional<double> kelvin_of_white_balance(std::string_view text);

/// Two numbers of nanometres, "550-560": the first below the other, both within what sensors may have.
/// `what` is what they are for, for the message of InvalidArgument.
struct NmRange {
  double from = 0, to = 0;
};
absl::StatusOr<NmRange> parse_nm_range(const std::string& text, const std::string& what);

}  // namespace tessera::spectra
