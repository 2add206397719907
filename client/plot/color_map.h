// Colours for numbers: maps on which more is brighter, also for eyes that tell fewer colours apart.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "plot/canvas.h"

namespace tessera::client {

/// The maps: kCividis [Nunez2018], dark blue to yellow, looks alike with and without colour-vision
/// deficiency; kViridis [Smith2015] goes by green; kGrey is even in lightness.
enum class ColorMap { kCividis, kViridis, kGrey };

/// The colour of a place from 0 to 1; places beyond have those of the ends. NaN has that of missing values.
PageColor map_color(ColorMap map, double place);

/// The colour of values that are not there, which no map has.
inline constexpr PageColor kMissingColor{186, 120, 176};

/// "cividis", "viridis", "grey".
const std::vector<std::string>& color_map_names();
/// InvalidArgument, with the nearest name, for another one.
absl::StatusOr<ColorMap> color_map_of(const std::string& name);

/// Relative luminance (Y of IEC 61966-2-1) of a colour, from 0 to 1.
double luminance_of(const PageColor& color);

/// Black or white: what is read best on this colour.
PageColor contrast_to(const PageColor& color);

}  // namespace tessera::client
