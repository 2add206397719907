#include "plot/isolines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>

namespace tessera::client {
namespace {

/// Finds the parts of the lines within each square of four middles, and joins them.
class Marching {
 public:
  Marching(const ValueGrid& grid, double level) : grid_(grid), level_(level) {
    for (std::size_t row = 0; row + 1 < grid.rows; ++row) {
      for (std::size_t column = 0; column + 1 < grid.columns; ++column) add_square(column, row);
    }
  }

  std::vector<Isoline> lines() {
    std::vector<Isoline> found;
    // Lines with ends first: what is left then has none.
    for (const std::size_t start : starts_) {
      if (next_.contains(start) && !has_previous_.contains(start)) found.push_back(follow(start));
    }
    for (const std::size_t start : starts_) {
      if (next_.contains(start)) found.push_back(follow(start));
    }
    return found;
  }

 private:
  /// Sides of squares by number: from the middle (column, row) to the right, and downwards.
  std::size_t right_of(std::size_t column, std::size_t row) const {
    return 2 * (row * grid_.columns + column);
  }
  std::size_t below(std::size_t column, std::size_t row) const { return right_of(column, row) + 1; }

  void add_square(std::size_t column, std::size_t row) {
    const std::array<double, 4> corners = {grid_.at(column, row), grid_.at(column + 1, row),
                                           grid_.at(column + 1, row + 1), grid_.at(column, row + 1)};
    unsigned high = 0;  // a bit for each corner, clockwise from the upper left
    double sum = 0;
    for (unsigned i = 0; i < 4; ++i) {
      if (!std::isfinite(corners[i])) return;
      if (corners[i] >= level_) high |= 1u << i;
      sum += corners[i] / 4;
    }
    // Side i follows corner i, clockwise. A part enters where the side goes from high to low, and leaves
    // where it goes from low to high: the high corners are then on its right.
    const std::array<std::size_t, 4> sides = {right_of(column, row), below(column + 1, row),
                                              right_of(column, row + 1), below(column, row)};
    const auto is_high = [&](unsigned corner) { return (high >> (corner % 4) & 1u) != 0; };
    const bool joins_high = sum >= level_;
    for (unsigned enter = 0; enter < 4; ++enter) {
      if (!is_high(enter) || is_high(enter + 1)) continue;
      // One of two ways: around the low corner where the high ones are joined in the middle.
      const bool two_ways = is_high(enter + 2) && !is_high(enter + 3);
      unsigned leave = enter + 1;
      if (two_ways && !joins_high) leave = enter + 3;
      while (!two_ways && (is_high(leave) || !is_high(leave + 1))) ++leave;
      connect(sides[enter], sides[leave % 4]);
    }
  }

  void connect(std::size_t from, std::size_t to) {
    next_[from] = to;
    has_previous_.insert(to);
    starts_.push_back(from);
  }

  Isoline follow(std::size_t start) {
    Isoline line;
    std::size_t at = start;
    line.points.push_back(point_on(at));
    for (auto step = next_.find(at); step != next_.end(); step = next_.find(at)) {
      at = step->second;
      next_.erase(step);
      if (at == start) {
        line.closed = true;
        return line;
      }
      line.points.push_back(point_on(at));
    }
    return line;
  }

  PagePoint point_on(std::size_t side) const {
    const std::size_t first = side / 2, column = first % grid_.columns, row = first / grid_.columns;
    const bool down = side % 2 == 1;
    const double from = grid_.at(column, row),
                 to = down ? grid_.at(column, row + 1) : grid_.at(column + 1, row);
    const double share = std::clamp((level_ - from) / (to - from), 0.0, 1.0);
    const double x = static_cast<double>(column) + 0.5, y = static_cast<double>(row) + 0.5;
    return down ? PagePoint{x, y + share} : PagePoint{x + share, y};
  }

  const ValueGrid& grid_;
  const double level_;
  std::vector<std::size_t> starts_;  // in the order of the squares
  std::unordered_map<std::size_t, std::size_t> next_;
  std::unordered_set<std::size_t> has_previous_;
};

}  // namespace

std::vector<Isoline> isolines(const ValueGrid& grid, double level) { return Marching(grid, level).lines(); }

double length_of(const Isoline& line) {
  double length = 0;
  const auto add = [&](const PagePoint& a, const PagePoint& b) {
    length += std::hypot(b.x - a.x, b.y - a.y);
  };
  for (std::size_t i = 1; i < line.points.size(); ++i) add(line.points[i - 1], line.points[i]);
  if (line.closed) add(line.points.back(), line.points.front());
  return length;
}

ValueGrid reduced(const ValueGrid& grid, std::size_t factor) {
  ValueGrid small{(grid.columns + factor - 1) / factor, (grid.rows + factor - 1) / factor, {}};
  for (std::size_t row = 0; row < small.rows; ++row) {
    for (std::size_t column = 0; column < small.columns; ++column) {
      double sum = 0, count = 0;
      for (std::size_t y = row * factor; y < std::min(grid.rows, (row + 1) * factor); ++y) {
        for (std::size_t x = column * factor; x < std::min(grid.columns, (column + 1) * factor); ++x) {
          if (!std::isfinite(grid.at(x, y))) continue;
          sum += grid.at(x, y), ++count;
        }
      }
      small.values.push_back(count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN());
    }
  }
  return small;
}

}  // namespace tessera::client
