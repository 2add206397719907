// Measured lamps among the CIE illuminants.
#pragma once

#include <optional>
#include <string_view>

#include "spectra/curve.h"

namespace tessera::spectra {

/// "F1" to "F12".
std::optional<Curve> find_fluorescent(std::string_view name);

/// "LED-B1" to "LED-B5", "LED-BH1", "LED-RGB1", "LED-V1", "LED-V2".
std::optional<Curve> find_led(std::string_view name);

}  // namespace tessera::spectra
