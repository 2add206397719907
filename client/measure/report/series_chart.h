// Diagrams of figures over the steps of a series.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "measure/measured.h"
#include "plot/axes_plot.h"

namespace tessera::client {

struct SeriesChart {
  std::string label;  // "floor: mean of 14 x 8 cells"
  AxesPlot plot;
};

/// A diagram of each plane's and surface's mean and of each other reading of a meter, by its number, over the
/// steps, with 95 % intervals; `most` of them at most. Steps without a value part the line. All steps have
/// the same meters (MeasuredSeries).
std::vector<SeriesChart> charts_of(const MeasuredSeries& series, std::size_t meter, std::size_t most);

}  // namespace tessera::client
