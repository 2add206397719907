// Diagrams with linear axes: bars, and points with error bars.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "plot/canvas.h"
#include "plot/color_map.h"
#include "plot/log_log_plot.h"
#include "plot/value_scale.h"

namespace tessera::client {

struct AxesPlot {
  struct Bar {
    double from = 0, to = 0, height = 0;
    std::optional<PageColor> color{};  // absent: that of points
  };

  std::string title;
  std::string x_label, y_label;
  std::vector<Bar> bars;
  std::vector<PlotPoint> points;  // joined by lines in their order; NaN parts them
  ScaleKind x_scale = ScaleKind::kLinear;
  std::optional<ValueRange> x_range{};  // absent: that of bars and points
};

inline constexpr double kAxesPlotWidth = 560, kAxesPlotHeight = 320;

void draw_axes_plot(Canvas& canvas, const AxesPlot& plot);

/// Writes a .png or .svg. InvalidArgument for another kind of file, or where there is nothing to draw.
absl::Status write_axes_plot(const AxesPlot& plot, const std::string& path);

/// A histogram of the finite values with bars of equal width on the scale, in the colours of the map: about
/// as many as the square root of their number, from 8 to 40. Values beyond the scale are in the outermost
/// bars.
AxesPlot histogram_of(std::span<const double> values, const ValueScale& scale, ColorMap map);

}  // namespace tessera::client
