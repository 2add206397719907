// Diagrams with two logarithmic axes, as PNG or SVG.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace tessera::client {

struct PlotPoint {
  double x = 0, y = 0;
  double low = 0, high = 0;  // the ends of the error bar; both 0: none
};

struct PlotSeries {
  std::string name;  // name in the legend; empty: not there
  std::vector<PlotPoint> points;
  std::optional<std::size_t> color =
      std::nullopt;  // series of one number look alike; absent: its place in the list
  bool dashed = false;
};

struct LogLogPlot {
  std::string title;
  std::string subtitle;
  std::string x_label, y_label;
  std::vector<PlotSeries> series;
};

/// InvalidArgument when `path` ends in neither .png nor .svg.
absl::Status check_plot_path(const std::string& path);

/// Draws 1200 by 750 points; a PNG has twice as many pixels each way. Points whose coordinates are not
/// positive and finite are left out. InvalidArgument for another kind of file, or when there is no point to
/// draw. The file is replaced as a whole (image/atomic_file.h).
absl::Status write_plot(const LogLogPlot& plot, const std::string& path);

}  // namespace tessera::client
