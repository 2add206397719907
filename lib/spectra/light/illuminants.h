// CIE illuminants by name.
#pragma once

#include <optional>
#include <string_view>

#include "spectra/curve.h"

namespace tessera::spectra {

inline constexpr std::string_view kIlluminantNames[] = {
    "A",      "C",      "D50",    "D55",    "D65",     "D75",      "E",      "F1",     "F2",     "F3",
    "F4",     "F5",     "F6",     "F7",     "F8",      "F9",       "F10",    "F11",    "F12",    "LED-B1",
    "LED-B2", "LED-B3", "LED-B4", "LED-B5", "LED-BH1", "LED-RGB1", "LED-V1", "LED-V2", "acesD60"};

/// Relative power of "A", "C", "D50", "D55", "D65", "D75", "E", "F1" to "F12", "LED-B1" to "LED-B5",
/// "LED-BH1", "LED-RGB1", "LED-V1", "LED-V2" [CIE 15:2004; CIE 15:2018], and of "acesD60" [Academy
/// TB-2018-001].
std::optional<Curve> find_illuminant(std::string_view name);

}  // namespace tessera::spectra
