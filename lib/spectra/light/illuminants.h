// CIE illuminants by name.
#pragma once

#include <optional>
#include <string_view>

#include "spectra/curve.h"

namespace tessera::spectra {

/// Relative power of "A", "C", "D50", "D55", "D65", "D75", "E", "F1" to "F12", "LED-B1" to "LED-B5",
/// "LED-BH1", "LED-RGB1", "LED-V1", "LED-V2" [CIE 15:2004; CIE 15:2018], and of "acesD60" [Academy
/// TB-2018-001].
std::optional<Curve> find_illuminant(std::string_view name);

}  // namespace tessera::spectra
