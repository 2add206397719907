// The RGB colour spaces that a pbrt file can name.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace tessera::client::pbrt {

enum class ColorSpace : unsigned char { kSrgb, kDciP3, kRec2020, kAces2065 };

/// "srgb", "dci-p3" (with the white D65, as pbrt-v4 has it), "rec2020", "aces2065-1".
std::optional<ColorSpace> color_space_of(std::string_view name);

/// Linear RGB of `from` in linear Rec.709, white on white (Bradford-adapted where the whites differ). Colours
/// outside the gamut of Rec.709 come out with negative components.
std::array<double, 3> rec709_from(ColorSpace from, const std::array<double, 3>& rgb);

}  // namespace tessera::client::pbrt
