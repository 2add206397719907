#include "import/mitsuba/sensitivities.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "import/input/concat.h"
#include "import/mitsuba/matter/colors.h"
#include "spectra/light/daylight.h"
#include "spectra/sensor/sensor_name.h"
#include "spectra/sensor/sensor_response.h"

namespace tessera::client::mitsuba {
namespace {

/// Whether Mitsuba takes it for a response function.
bool is_response(const Property& property) {
  if (std::holds_alternative<SpectrumData>(property.value) || std::holds_alternative<Rgb>(property.value))
    return true;
  Object* const* const object = std::get_if<Object*>(&property.value);
  return object != nullptr && (*object)->tag == "texture";
}

/// The light of daylight that the sensor sees by one sensitivity.
double seen_of_daylight(const spectra::Curve& curve) {
  spectra::SensorResponse response;
  response.from_nm = std::max(double{curve.nm.front()}, spectra::kLeastSensorNm);
  response.to_nm = std::min(double{curve.nm.back()}, spectra::kMostSensorNm);
  for (double nm = response.first_nm(); nm <= std::ceil(response.to_nm); ++nm) {
    const double value = curve.at(std::clamp(nm, response.from_nm, response.to_nm));
    response.rows.push_back({value, value, value});
  }
  return spectra::seen(response, spectra::unit_d65())[1];
}

/// The mean wavelength that it sees of light that is the same at all.
double centre_of(const spectra::Curve& curve) {
  double sum = 0, moment = 0;
  for (std::size_t i = 0; i + 1 < curve.nm.size(); ++i) {
    const double width = double{curve.nm[i + 1]} - curve.nm[i];
    sum += width * (double{curve.values[i]} + curve.values[i + 1]) / 2;
    // The integral of a straight line times the wavelength.
    moment += width / 6 *
              (curve.values[i] * (2.0 * curve.nm[i] + curve.nm[i + 1]) +
               curve.values[i + 1] * (double{curve.nm[i]} + 2.0 * curve.nm[i + 1]));
  }
  return sum > 0 ? moment / sum : 0;
}

/// Nothing, with an error, where it is no spectrum or sees no light.
std::optional<spectra::Curve> read_sensitivity(PropertyReader& reader, Property& property) {
  property.used = true;
  const std::size_t errors_before = reader.diagnostics().errors().size();
  const std::optional<ConstantColor> color = read_constant_color(reader, property, ColorUse::kSensitivity);
  if (!color) {
    if (reader.diagnostics().errors().size() == errors_before) reader.error(property, "expected a spectrum");
    return std::nullopt;
  }
  spectra::Curve curve = color->curve;
  if (curve.nm.empty()) {
    const auto [least, most] = std::ranges::minmax(color->rgb);
    if (least != most) {
      reader.error(property, "expected a spectrum, not a colour");
      return std::nullopt;
    }
    curve = {{kFirstNm, kLastNm}, {static_cast<float>(most), static_cast<float>(most)}};
  }
  if (curve.nm.back() > spectra::kLeastSensorNm && curve.nm.front() < spectra::kMostSensorNm &&
      seen_of_daylight(curve) > 0)
    return curve;
  reader.error(property, concat("it sees nothing of daylight from ", spectra::kLeastSensorNm, " to ",
                                spectra::kMostSensorNm, " nm"));
  return std::nullopt;
}

void write(Context& context, std::vector<spectra::Curve> curves) {
  std::ranges::sort(curves, std::ranges::greater{}, centre_of);
  v1::Film& film = *context.scene.mutable_film();
  for (const spectra::Curve& curve : curves) {
    v1::SampledSpectrum& own = *film.add_sensitivities();
    own.mutable_wavelengths_nm()->Add(curve.nm.begin(), curve.nm.end());
    own.mutable_values()->Add(curve.values.begin(), curve.values.end());
  }
  // Without a balance, channels are relative to what the second one sees of daylight.
  film.set_exposure(static_cast<float>(seen_of_daylight(curves[curves.size() / 2])));
  v1::RenderSettings& settings = *context.scene.mutable_settings();
  settings.set_sensor("film");
  settings.set_white_balance("none");
}

}  // namespace

void write_film_sensitivities(PropertyReader& film) {
  film.context().scene.mutable_settings()->set_color(v1::COLOR_SPECTRAL);
  std::vector<spectra::Curve> curves;
  std::size_t found = 0;
  for (Property& property : film.properties()) {
    if (!is_response(property)) continue;
    ++found;
    if (auto curve = read_sensitivity(film, property)) curves.push_back(*std::move(curve));
  }
  if (found == 0) {
    film.error(concat(film.object().title(), ": expected a spectrum, or three"));
  } else if (found != 1 && found != 3) {
    film.warn(concat(film.object().title(), " has ", found,
                     " spectra, and a sensor one or three: what the CIE 1931 observer sees is rendered; "
                     "--film spectral:N writes bands"));
  } else if (curves.size() == found) {
    write(film.context(), std::move(curves));
  }
}

void write_sensor_response(PropertyReader& sensor, bool film_has_own) {
  Property* const property = sensor.find("srf");
  if (property == nullptr) return;
  if (film_has_own) {
    sensor.error(*property, "its film has response functions already");
    return;
  }
  sensor.context().scene.mutable_settings()->set_color(v1::COLOR_SPECTRAL);
  std::optional<spectra::Curve> curve = read_sensitivity(sensor, *property);
  if (!curve) return;
  sensor.diagnostics().warning(
      property->where, concat("parameter \"srf\" of ", sensor.object().title(),
                              ": all channels are what it sees, where Mitsuba shows the colours of the "
                              "light that it lets through"));
  write(sensor.context(), {*std::move(curve)});
}

}  // namespace tessera::client::mitsuba
