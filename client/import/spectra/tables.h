// The measured data behind named_spectra.h.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "import/spectra/named_spectra.h"

namespace tessera::client {

/// "Ag", "Au", ...; the real index of refraction, or the extinction coefficient `k`.
std::optional<SpectrumTable> find_metal(std::string_view metal, bool k);
/// "BK7", ...; index of refraction.
std::optional<SpectrumTable> find_glass(std::string_view glass);
/// "A", "D50", "D65", "F1", ..., "acesD60"; relative power.
std::optional<SpectrumTable> find_illuminant(std::string_view illuminant);

/// `values` at first, first + step, ... nanometres.
SpectrumTable uniform_table(float first_nm, float step_nm, std::span<const float> values);

}  // namespace tessera::client
