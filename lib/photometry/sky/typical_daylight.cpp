#include "photometry/sky/typical_daylight.h"

#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "photometry/sky/cie_sky.h"
#include "photometry/sun/sun_irradiance.h"

namespace tessera::photometry {
namespace {

/// Sky light over extraterrestrial light, both horizontal, of the types 1 to 6.
constexpr double kDiffuseRatio[6] = {0.10, 0.18, 0.15, 0.22, 0.20, 0.38};

/// Zenith luminance in kcd/m^2 for the sun's altitude g and turbidity T:
/// (A1 T + A2) sin g + 0.7 (T + 1) sin^C g / cos^D g + 0.04 T. The same over the sky's illuminance in klx:
/// (B sin^C g / cos^D g + E sin g) / (133.8 sin g).
struct ZenithRow {
  double turbidity, a1, a2, b, c, d, e;
};
constexpr ZenithRow kZenithRows[9] = {
    {12, 0.957, 1.790, 21.72, 4.52, 0.64, 34.56},   {10, 0.830, 2.030, 29.35, 4.94, 0.70, 30.41},
    {12, 0.600, 1.500, 10.34, 3.45, 0.50, 27.47},   {10, 0.567, 2.610, 18.41, 4.27, 0.63, 24.04},
    {4, 1.440, -0.750, 24.41, 4.60, 0.72, 20.76},   {2.5, 1.036, 0.710, 23.00, 4.43, 0.74, 18.52},
    {4.5, 1.244, -0.840, 27.45, 4.61, 0.76, 16.59}, {5, 0.881, 0.453, 25.54, 4.40, 0.79, 14.56},
    {4, 0.418, 1.950, 28.08, 4.13, 0.79, 13.00},
};

/// Extinction of light by a clean atmosphere, for each relative air mass [Clear1982].
double luminous_extinction(double air_mass) { return 1 / (9.9 + 0.043 * air_mass); }

}  // namespace

absl::StatusOr<Daylight> typical_daylight(int cie_type, double sun_altitude_degrees, double distance_au) {
  if (auto known = cie_pattern(cie_type); !known.ok()) return known.status();
  if (!(sun_altitude_degrees > 0)) {
    return absl::InvalidArgumentError(absl::StrCat("the sun is ", -sun_altitude_degrees,
                                                   " degrees below the horizon, where no sky has a typical "
                                                   "brightness"));
  }
  const double sine = std::sin(sun_altitude_degrees * kRadiansPerDegree),
               cosine = std::cos(sun_altitude_degrees * kRadiansPerDegree);
  if (cie_type == kTraditionalOvercast) return Daylight{.diffuse_horizontal = 300 + 21000 * sine};
  const double outside = kLuminousSolarConstant / (distance_au * distance_au);
  if (cie_type <= 6) return Daylight{.diffuse_horizontal = kDiffuseRatio[cie_type - 1] * outside * sine};

  const ZenithRow& row = kZenithRows[cie_type - 7];
  // Both formulas have a pole where the sun is in the zenith, which their ratio has not.
  const double rise = std::pow(sine, row.c), pole = std::pow(std::max(cosine, 0.0), row.d);
  const double t = row.turbidity;
  const double zenith = ((row.a1 * t + row.a2) * sine + 0.04 * t) * pole + 0.7 * (t + 1) * rise;
  const double ratio = (row.b * rise + row.e * sine * pole) / (133.8 * sine);
  const double air_mass = relative_air_mass(sun_altitude_degrees);
  return Daylight{.diffuse_horizontal = 1000 * zenith / ratio * outside / kLuminousSolarConstant,
                  .sun_normal = outside * std::exp(-luminous_extinction(air_mass) * air_mass * t)};
}

}  // namespace tessera::photometry
