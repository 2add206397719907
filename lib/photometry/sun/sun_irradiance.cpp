#include "photometry/sun/sun_irradiance.h"

#include <algorithm>
#include <cmath>

#include "photometry/horizon.h"

namespace tessera::photometry {

double relative_air_mass(double altitude_degrees) {
  const double altitude = std::max(altitude_degrees, 0.0);
  return 1 / (std::sin(altitude * kRadiansPerDegree) + 0.50572 * std::pow(altitude + 6.07995, -1.6364));
}

}  // namespace tessera::photometry
