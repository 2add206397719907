// Derivatives of distortions on a grid of undistorted places.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "render/scene/view/distorted_film.h"

namespace tessera::render {

namespace {

/// Derivatives of x by x and y, and of y by x and y.
using Slopes = std::array<double, 4>;

/// The place of the table's film that sees an undistorted one, by Newton's method. Nothing where none does.
std::optional<PlanePoint> film_that_sees(const DistortionTable& table, PlanePoint place, PlanePoint near) {
  const PlaceGrid& grid = table.grid;
  const PlanePoint first = node_place(grid, 0, 0), last = node_place(grid, grid.columns, grid.rows);
  const auto within = [](double x, double a, double b) {
    return std::clamp(x, std::min(a, b), std::max(a, b));
  };
  constexpr int kSteps = 30;
  PlanePoint film = near;
  for (int i = 0; i < kSteps; ++i) {
    const PlaceAndSlopes seen = seen_on_film(table, film);
    const double determinant = seen.determinant();
    // Negated, so that NaN ends it, too.
    if (!(determinant > 0)) return std::nullopt;
    const double rest_x = place.x - seen.place.x, rest_y = place.y - seen.place.y;
    const double step_x = (seen.yy * rest_x - seen.xy * rest_y) / determinant,
                 step_y = (seen.xx * rest_y - seen.yx * rest_x) / determinant;
    if (std::max(std::abs(step_x), std::abs(step_y)) <= double{table.near}) return film;
    film = {within(film.x + step_x, first.x, last.x), within(film.y + step_y, first.y, last.y)};
  }
  return std::nullopt;
}

/// The slopes of a bilinear table, smoothed: at its nodes, differences over the cells next to them, and
/// linear in between.
Slopes smoothed(const DistortionTable& table, PlanePoint film) {
  const PlaceGrid& grid = table.grid;
  const auto cell_of = [](double place, std::int32_t cells) {
    const double at = std::clamp(place, 0.0, static_cast<double>(cells));
    const int cell = std::min(static_cast<int>(at), cells - 1);
    return std::pair{cell, at - cell};
  };
  const auto [column, s] = cell_of((film.x - double{grid.first_x}) * double{grid.per_x}, grid.columns);
  const auto [row, t] = cell_of((film.y - double{grid.first_y}) * double{grid.per_y}, grid.rows);
  const auto difference = [&](int c, int r, std::size_t component) {
    const std::size_t node = static_cast<std::size_t>(r) * static_cast<std::size_t>(grid.columns + 1) +
                             static_cast<std::size_t>(c);
    return double{table.nodes[DistortionTable::kBilinearNode * node + component]};
  };
  Slopes sum{1, 0, 0, 1};
  for (const int j : {0, 1}) {
    for (const int i : {0, 1}) {
      const double weight = (i == 0 ? 1 - s : s) * (j == 0 ? 1 - t : t);
      const int c = column + i, r = row + j;
      const int left = std::max(c - 1, 0), right = std::min(c + 1, grid.columns), above = std::max(r - 1, 0),
                below = std::min(r + 1, grid.rows);
      for (std::size_t k = 0; k < 2; ++k) {
        sum[2 * k] +=
            weight * double{grid.per_x} * (difference(right, r, k) - difference(left, r, k)) / (right - left);
        sum[2 * k + 1] += weight * double{grid.per_y} * (difference(c, below, k) - difference(c, above, k)) /
                          (below - above);
      }
    }
  }
  return sum;
}

/// The nodes of the start grid, of which some are known.
class SlopeGrid {
 public:
  explicit SlopeGrid(const DistortionTable& table)
      : columns_(table.start_grid.columns + 1), rows_(table.start_grid.rows + 1) {
    nodes_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column) at(column, row) = solve(table, column, row);
  }

  /// Gives nodes next to known ones what these lead to, straight on: those of cells that the film sees a part
  /// of.
  void go_straight_on() {
    fill([&](const SlopeGrid& known, int column, int row, int x, int y) -> std::optional<Slopes> {
      const auto next = known.get(column + x, row + y), after = known.get(column + 2 * x, row + 2 * y);
      if (!next || !after) return std::nullopt;
      Slopes there{};
      for (std::size_t i = 0; i < there.size(); ++i) there[i] = 2 * (*next)[i] - (*after)[i];
      return there[0] * there[3] > there[1] * there[2] ? there : *next;
    });
  }

  /// Gives nodes next to known ones the same; false where all are known.
  bool spread() {
    return fill([](const SlopeGrid& known, int column, int row, int x, int y) {
      return known.get(column + x, row + y);
    });
  }

  void write(std::vector<float>& slopes) const {
    for (const std::optional<Slopes>& node : nodes_)
      for (const double slope : node.value_or(Slopes{1, 0, 0, 1}))
        slopes.push_back(static_cast<float>(slope));
  }

 private:
  std::optional<Slopes>& at(int column, int row) {
    return nodes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)];
  }
  std::optional<Slopes> get(int column, int row) const {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return std::nullopt;
    return nodes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)];
  }

  static std::optional<Slopes> solve(const DistortionTable& table, int column, int row) {
    const PlaceGrid& grid = table.start_grid;
    const auto cell = static_cast<std::size_t>(std::min(row, grid.rows - 1) * grid.columns +
                                               std::min(column, grid.columns - 1));
    const auto film = film_that_sees(table, node_place(grid, column, row),
                                     {double{table.starts[2 * cell]}, double{table.starts[2 * cell + 1]}});
    if (!film) return std::nullopt;
    if (!table.smooth) return smoothed(table, *film);
    const PlaceAndSlopes seen = seen_on_film(table, *film);
    return Slopes{seen.xx, seen.xy, seen.yx, seen.yy};
  }

  /// Gives unknown nodes the mean of what the known ones in the eight directions lead to. `guess` takes the
  /// grid as it was, a node and a direction. False where nothing was found.
  template <class Guess>
  bool fill(Guess&& guess) {
    const SlopeGrid known = *this;
    bool found = false;
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        if (known.get(column, row)) continue;
        Slopes sum{};
        int guesses = 0;
        for (int direction = 0; direction < 9; ++direction) {
          const auto there = guess(known, column, row, direction % 3 - 1, direction / 3 - 1);
          if (!there) continue;
          for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += (*there)[i];
          ++guesses;
        }
        if (guesses == 0) continue;
        for (double& slope : sum) slope /= guesses;
        at(column, row) = sum;
        found = true;
      }
    }
    return found;
  }

  int columns_, rows_;
  std::vector<std::optional<Slopes>> nodes_;
};

}  // namespace

void add_slopes(DistortionTable& table) {
  SlopeGrid grid(table);
  grid.go_straight_on();
  grid.go_straight_on();
  while (grid.spread()) {
  }
  grid.write(table.slopes);
}

}  // namespace tessera::render
