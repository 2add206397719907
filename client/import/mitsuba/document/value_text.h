// The text of XML attributes -> values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "import/mitsuba/document/values.h"

namespace tessera::client::mitsuba {

/// Words between commas, blanks and line ends.
std::vector<std::string_view> split(std::string_view text);

/// The whole text must be one number, blanks around it allowed. Finite.
std::optional<double> parse_float(std::string_view text);
std::optional<std::int64_t> parse_integer(std::string_view text);
/// "true" or "false" in any case.
std::optional<bool> parse_boolean(std::string_view text);
/// All numbers of a list; nothing when a word is none.
std::optional<std::vector<double>> parse_floats(std::string_view text);

/// "0.5", or "400:0.1, 500:0.2, ..."; the message of what is wrong, or nothing.
std::string parse_spectrum(std::string_view text, SpectrumData& spectrum);
/// Lines of wavelength and value, with comments behind '#'; the message of what is wrong, or nothing.
std::string parse_spectrum_file(std::string_view bytes, SpectrumData& spectrum);

}  // namespace tessera::client::mitsuba
