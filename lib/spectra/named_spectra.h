// Spectra that scene files call by name: metals, glasses, illuminants.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "spectra/curve.h"

namespace tessera::spectra {

/// pbrt-v4's names: "metal-Ag-eta", "metal-Ag-k" (also Al, Au, Cu, CuZn, MgO, TiO2), "glass-BK7" (also BAF10,
/// FK51A, LASF9, F5, F10, F11 and their maker's names SF5, SF10, SF11), "stdillum-A", "stdillum-D50",
/// "stdillum-D65", "stdillum-F1" to "stdillum-F12", "illum-acesD60"; and "stdillum-" with the other names of
/// light/illuminants.h. All are as pbrt-v4 has them, also its D50 (light/daylight.h). Illuminants are scaled
/// to a luminance of 1 (rgb/pbrt_luminance.h).
std::optional<Curve> find_named_spectrum(std::string_view name);

/// The names that find_named_spectrum() knows.
std::vector<std::string> names_of_spectra();

}  // namespace tessera::spectra
