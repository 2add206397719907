#include "spectra/sensor/sensor_response.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>

#include "spectra/color/tristimulus.h"
#include "spectra/light/daylight.h"

namespace tessera::spectra {
namespace {

/// Sensitivities before any balance, as functions of the wavelength.
struct Sensitivities {
  double from_nm = 0, to_nm = 0;
  std::function<Triple(double nm)> at;
};

Sensitivities sensitivities_of(const NamedSensor& sensor, std::span<const Curve> film) {
  switch (sensor.kind) {
    case SensorKind::kBand:
      return {sensor.from_nm, sensor.to_nm, [](double) { return Triple{1, 1, 1}; }};
    case SensorKind::kFilm: {
      Sensitivities own{kMostSensorNm, kLeastSensorNm, [film](double nm) {
                          Triple values;
                          for (std::size_t c = 0; c < 3; ++c) {
                            const Curve& curve = film[film.size() == 3 ? c : 0];
                            const bool inside = nm >= curve.nm.front() && nm <= curve.nm.back();
                            values[c] = inside ? curve.at(nm) : 0;
                          }
                          return values;
                        }};
      for (const Curve& curve : film) {
        own.from_nm = std::min(own.from_nm, double{curve.nm.front()});
        own.to_nm = std::max(own.to_nm, double{curve.nm.back()});
      }
      own.from_nm = std::max(own.from_nm, kLeastSensorNm), own.to_nm = std::min(own.to_nm, kMostSensorNm);
      return own;
    }
    default: {
      const Observer& own = sensor.sensitivities;
      return {own.first_nm, own.last_nm(), [own](double nm) { return own.at(nm); }};
    }
  }
}

/// Calls f(nm, weight) for the places and weights by which functions with lines between whole nanometres are
/// integrated: two points of Gauss and Legendre in each nanometre are exact for products of three lines.
template <class F>
void integrate(double from_nm, double to_nm, F&& f) {
  const double offset = 0.5 / std::numbers::sqrt3;
  for (double low = from_nm; low < to_nm;) {
    const double high = std::min(std::floor(low) + 1, to_nm), width = high - low, middle = (low + high) / 2;
    for (const double nm : {middle - offset * width, middle + offset * width}) f(nm, width / 2);
    low = high;
  }
}

Triple divided(const Triple& values, const Triple& by) {
  return {values[0] / by[0], values[1] / by[1], values[2] / by[2]};
}

bool all_positive(const Triple& values) {
  return std::ranges::all_of(values, [](double v) { return v > 0; });
}

absl::Status unseen(const char* what) {
  return absl::InvalidArgumentError(std::string("the sensor sees nothing of ") + what);
}

}  // namespace

double SensorResponse::first_nm() const { return std::floor(from_nm); }

Triple SensorResponse::at(double nm) const {
  if (!(nm >= from_nm && nm <= to_nm)) return {0, 0, 0};
  return Observer{first_nm(), 1, rows}.at(nm);
}

Triple seen(const SensorResponse& response, const Curve& light) {
  Triple sums = {0, 0, 0};
  integrate(response.from_nm, response.to_nm, [&](double nm, double weight) {
    const Triple here = response.at(nm);
    const double power = weight * light.at(nm);
    for (std::size_t c = 0; c < 3; ++c) sums[c] += power * here[c];
  });
  return sums;
}

Triple seen(const SensorResponse& response, double from_nm, double to_nm) {
  Triple sums = {0, 0, 0};
  integrate(std::max(from_nm, response.from_nm), std::min(to_nm, response.to_nm),
            [&](double nm, double weight) {
              const Triple here = response.at(nm);
              for (std::size_t c = 0; c < 3; ++c) sums[c] += weight * here[c];
            });
  return sums;
}

absl::StatusOr<SensorResponse> sensor_response(const NamedSensor& sensor, const std::optional<Curve>& white,
                                               const RgbSpace& space, std::span<const Curve> film) {
  const Sensitivities own = sensitivities_of(sensor, film);
  SensorResponse response{.from_nm = own.from_nm, .to_nm = own.to_nm, .rows = {}, .sensitivity = {}};
  for (double nm = std::floor(own.from_nm); nm <= std::ceil(own.to_nm); ++nm)
    response.rows.push_back(own.at(std::clamp(nm, own.from_nm, own.to_nm)));
  const Triple all = seen(response, own.from_nm, own.to_nm);
  if (!all_positive(all)) return unseen("any light: a sensitivity is zero everywhere");
  for (const Triple& row : response.rows) {
    const Triple part = divided(row, all);
    response.sensitivity.push_back(part[0] + part[1] + part[2]);
  }

  // Colours of an observer are a matrix away, which takes its white to white; the exact balance follows.
  const Triple of_white = seen(response, white ? *white : unit_d65());
  if (!all_positive(of_white)) return unseen("the light of its white balance");
  if (sensor.kind == SensorKind::kObserver) {
    const Matrix3 matrix = white ? rgb_from_xyz(space, chromaticity(of_white)) : rgb_from_xyz(space);
    for (Triple& row : response.rows) row = times(matrix, row);
  }
  Triple scale = of_white;
  if (!white || sensor.kind == SensorKind::kBand) {
    scale = {of_white[1], of_white[1], of_white[1]};
  } else if (sensor.kind == SensorKind::kObserver) {
    scale = seen(response, *white);
  }
  for (Triple& row : response.rows) row = divided(row, scale);
  return response;
}

}  // namespace tessera::spectra
