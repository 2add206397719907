// Indices of refraction of optical glasses, as tables at the wavelengths of pbrt-v4.
#pragma once

#include <optional>
#include <string_view>

#include "spectra/curve.h"

namespace tessera::spectra {

inline constexpr std::string_view kGlassNames[] = {"BK7",  "BAF10", "FK51A", "LASF9", "SF5",
                                                   "SF10", "SF11",  "F5",    "F10",   "F11"};

/// "BK7", "BAF10", "FK51A", "LASF9", "SF5", "SF10", "SF11", and pbrt's names of the last three, "F5", "F10",
/// "F11".
std::optional<Curve> find_glass(std::string_view name);

}  // namespace tessera::spectra
