// How a sensor makes red, green and blue of light of any wavelength.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "spectra/color/rgb_space.h"
#include "spectra/curve.h"
#include "spectra/observer/observer.h"
#include "spectra/sensor/sensor_name.h"

namespace tessera::spectra {

/// Functions of the wavelength, of which a sensor sees those from from_nm to to_nm and no others. Rows are a
/// nanometre apart, at whole nanometres, with lines between them; the first is at from_nm or less, the last
/// at to_nm or more.
struct SensorResponse {
  double from_nm = 0, to_nm = 0;
  /// Rows of what radiance at a wavelength, per nanometre, adds to red, green and blue.
  std::vector<Triple> rows;
  /// All that the sensor sees there, as the sum of its sensitivities, each relative to its integral: not
  /// negative, also where parts of red, green and blue are.
  std::vector<double> sensitivity;

  double first_nm() const;
  Triple at(double nm) const;
};

/// Integrals over wavelengths of the response times `light`, exact for lines between whole nanometres.
Triple seen(const SensorResponse& response, const Curve& light);
/// The same of light that is 1 from from_nm to to_nm and 0 elsewhere.
Triple seen(const SensorResponse& response, double from_nm, double to_nm);

/// The response of a sensor with a white balance: light of a luminance of 1 that has the spectrum of `white`
/// is (1, 1, 1). An observer's colours are in linear RGB of `space`, white on white [Lam 1985]; a camera's
/// channels are its own, each times a factor; a sensor that has one sensitivity has it three times. Without
/// `white` (no balance) an observer's colours are of light as it is, and all channels of a camera have the
/// factor that its second has in daylight (D65). `film` has the sensitivities, one or three, of a sensor of
/// kFilm. InvalidArgument where the sensor sees nothing of that light.
absl::StatusOr<SensorResponse> sensor_response(const NamedSensor& sensor, const std::optional<Curve>& white,
                                               const RgbSpace& space, std::span<const Curve> film = {});

}  // namespace tessera::spectra
