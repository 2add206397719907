// How luminance is distributed over a sky.
#pragma once

#include "photometry/horizon.h"

namespace tessera::photometry {

/// Relative luminance as a product of a gradation of the zenith angle Z and an indicatrix of the angle X to
/// the sun: (1 + a exp(b / cos Z)) (1 + c (exp(d X) - k) + e cos^2 X). The CIE's general skies have k = exp(d
/// pi / 2) [ISO 15469:2004], those of the all-weather model k = 0 [Perez1993].
struct SkyPattern {
  double a = 0, b = -1, c = 0, d = -1, e = 0;
  double k = 0;
  /// Instead of all those: (1 + 2 cos Z) / 3, the traditional overcast sky [Moon1942].
  bool traditional_overcast = false;

  /// Whether the luminance depends on where the sun is.
  bool has_indicatrix() const { return !traditional_overcast && (c != 0 || e != 0); }
};

/// Relative luminance in a direction above the horizon, never negative. Gradation stays what it is half a
/// degree above the horizon from there down (cos Z is taken as 0.01 at least), where the formula has a pole.
double relative_luminance(const SkyPattern& pattern, const HorizonDirection& w, const HorizonDirection& sun);

/// Illuminance of a horizontal surface by that sky, where a relative luminance of 1 is 1 cd/m^2: the integral
/// of the luminance times cos Z over the hemisphere, by Gauss quadrature. `points`: in each direction of each
/// of two panels that meet at the sun, where the luminance may have a cusp; 32 are good for a relative error
/// of 1e-6.
double horizontal_integral(const SkyPattern& pattern, const HorizonDirection& sun, int points = 32);

}  // namespace tessera::photometry
