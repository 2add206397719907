// Complex indices of refraction of metals, and of other materials that Mitsuba calls conductors, as colours.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::spectra {

/// Linear Rec.709 of the real index and of the extinction coefficient, without a light to see them in.
struct MetalColor {
  std::array<double, 3> eta, k;
};

/// Finds a metal by Mitsuba's name ("Cr", "W", ...); those of which named_spectra.h has the spectrum are not
/// here.
std::optional<MetalColor> find_metal_color(std::string_view name);

/// All of them, in alphabetical order.
std::vector<std::string> metal_color_names();

}  // namespace tessera::spectra
