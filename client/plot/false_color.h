// Numbers over a plane or a picture as colours, with a legend, isolines and distances.
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "plot/canvas.h"
#include "plot/color_map.h"
#include "plot/isolines.h"
#include "plot/value_scale.h"

namespace tessera::client {

struct FalseColorOptions {
  std::string title, subtitle;
  std::string unit;  // of the values
  ColorMap map = ColorMap::kCividis;
  ScaleKind scale = ScaleKind::kLinear;
  std::optional<ValueRange> range{};  // absent: that of the values (scale_over)
  double cut = 0;                     // share of the values, the largest, that the scale may leave out
  bool isolines = false;
  double shortest_isoline = 0;  // cells; shorter lines are left out, as noise
  // Colour of NaN where that is beside what is drawn; absent: values are missing, which the legend tells.
  std::optional<PageColor> ground{};
  bool smooth = false;  // values between the middles of cells are linear; else cells have one colour
  // Sizes of the whole in the unit of length, which axes then tell; 0: no axes.
  double width = 0, height = 0;
  std::string length_unit;
};

/// Where the parts of a map are on its page.
struct FalseColorLayout {
  PageBox map;
  double page_width = 0, page_height = 0;
  double pixel = 1;  // points that a pixel of the map takes
};

/// The page of a map: cells of pictures keep whole pixels of a PNG, small grids are enlarged.
FalseColorLayout false_color_layout(const ValueGrid& grid, const FalseColorOptions& options);

/// Colours of values; NaN has that of missing ones, or another one.
Pixels false_color_pixels(const ValueGrid& grid, const ValueScale& scale, ColorMap map,
                          const PageColor& missing = kMissingColor);

/// The values of `grid` with so many a cell along each side: equal, or linear between the middles of cells.
ValueGrid enlarged(const ValueGrid& grid, std::size_t across, std::size_t down, bool smooth);

void draw_false_color(Canvas& canvas, const ValueGrid& grid, const FalseColorOptions& options);

/// Writes a .png or .svg. InvalidArgument for another kind of file, or where there are no values.
absl::Status write_false_color(const ValueGrid& grid, const FalseColorOptions& options,
                               const std::string& path);

}  // namespace tessera::client
