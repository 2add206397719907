// Spectra that scene files call by name: metals, glasses, illuminants.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace tessera::client {

/// A piecewise-linear spectrum, constant beyond its ends. Wavelengths ascend, in nanometres.
struct SpectrumTable {
  std::vector<float> wavelengths_nm;
  std::vector<float> values;
};

/// pbrt-v4's names: "metal-Ag-eta", "metal-Ag-k" (also Al, Au, Cu, CuZn, MgO, TiO2), "glass-BK7" (also BAF10,
/// FK51A, LASF9, F5, F10, F11 and their maker's names SF5, SF10, SF11), "stdillum-A", "stdillum-D50",
/// "stdillum-D65", "stdillum-F1" to "stdillum-F12", "illum-acesD60". Illuminants are scaled to a luminance of
/// 1 (see photometry.h).
std::optional<SpectrumTable> find_named_spectrum(std::string_view name);

}  // namespace tessera::client
