// How bright a sky of a type is where nobody has measured it.
#pragma once

#include "absl/status/statusor.h"

namespace tessera::photometry {

/// lx
struct Daylight {
  double diffuse_horizontal = 0;  // by the sky alone
  double sun_normal = 0;          // by the sun, of a surface that faces it
};

/// Typical illuminances of a CIE sky for the altitude of the sun, which is above the horizon. Types 1 to 15
/// by [Darula2002] and [Kittler1998]: overcast ones have a typical ratio of sky light to extraterrestrial
/// light (0.10 to 0.38) and no sun, others a typical luminous turbidity (2.5 to 12), from which follow zenith
/// luminance, with its ratio to the sky's illuminance, and the sun. Type 16: 300 lx + 21,000 lx times the
/// sine of the altitude [Krochmann1974]. `distance_au`: to the sun. InvalidArgument for other types, and for
/// a sun at or below the horizon.
absl::StatusOr<Daylight> typical_daylight(int cie_type, double sun_altitude_degrees, double distance_au = 1);

}  // namespace tessera::photometry
