// The CIE's standard general skies.
#pragma once

#include "absl/status/statusor.h"
#include "photometry/sky/sky_pattern.h"

namespace tessera::photometry {

inline constexpr int kCieSkies = 15;
inline constexpr int kTraditionalOvercast = 16;

/// The pattern of a type: 1 to 15 of the general sky (ISO 15469:2004, CIE S 011/E:2003, table 1), 16 the
/// traditional overcast sky. InvalidArgument for other types.
absl::StatusOr<SkyPattern> cie_pattern(int type);

/// The standard's name of a type: "CIE standard clear sky, low luminance turbidity". Empty for other types.
const char* cie_sky_name(int type);

/// Whether the sky of a type says where the sun is.
inline bool cie_sky_needs_sun(int type) { return type != 1 && type != 3 && type != 5 && type != 16; }

}  // namespace tessera::photometry
