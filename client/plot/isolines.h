// Lines of equal value through values on a grid.
#pragma once

#include <cstddef>
#include <vector>

#include "plot/canvas.h"

namespace tessera::client {

/// Values of rectangles, rows from the top. NaN: there is none.
struct ValueGrid {
  std::size_t columns = 0, rows = 0;
  std::vector<double> values;

  double at(std::size_t column, std::size_t row) const { return values[row * columns + column]; }
};

struct Isoline {
  // In units of grid cells: (0.5, 0.5) is the middle of the first one. Larger values lie to the right of the
  // way along the line, seen on a page.
  std::vector<PagePoint> points;
  bool closed = false;
};

/// The lines on which values, taken as linear between middles of neighbouring cells, are `level` (marching
/// squares [Lorensen1987]); where two ways through a square are possible, the mean of its corners decides.
/// Lines end at the grid's outermost middles and around missing values.
std::vector<Isoline> isolines(const ValueGrid& grid, double level);

/// Length in units of grid cells.
double length_of(const Isoline& line);

/// Means over blocks of `factor` cells each way; the last of each row and column may be smaller. Missing
/// values are left out.
ValueGrid reduced(const ValueGrid& grid, std::size_t factor);

}  // namespace tessera::client
