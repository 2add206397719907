// What a single place of a distorted film sees, in doubles.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "render/scene/view/distorted_film.h"

namespace tessera::render {

namespace {

/// One of two coordinates between two nodes.
struct Along {
  std::size_t node;  // the first of the two
  double part;
};

Along along(double place, float first, float per, std::int32_t cells) {
  const double at = std::clamp((place - double{first}) * double{per}, 0.0, static_cast<double>(cells));
  const double node = std::min(std::floor(at), cells - 1.0);
  return {static_cast<std::size_t>(node), at - node};
}

/// Hermite's cubics [value or slope][end], and their derivatives.
struct Cubics {
  double value[2], slope[2], value_slope[2], slope_slope[2];
  explicit Cubics(double t)
      : value{(1 + 2 * t) * (1 - t) * (1 - t), t * t * (3 - 2 * t)},
        slope{t * (1 - t) * (1 - t), t * t * (t - 1)},
        value_slope{6 * t * (t - 1), 6 * t * (1 - t)},
        slope_slope{(1 - t) * (1 - 3 * t), t * (3 * t - 2)} {}
};

/// A coordinate, and its derivatives for steps of a cell.
struct Coordinate {
  double value = 0, by_column = 0, by_row = 0;
};

}  // namespace

PlaceAndSlopes seen_on_film(const DistortionTable& table, PlanePoint film) {
  const PlaceGrid& grid = table.grid;
  const Along x = along(film.x, grid.first_x, grid.per_x, grid.columns),
              y = along(film.y, grid.first_y, grid.per_y, grid.rows);
  const Cubics across(x.part), down(y.part);
  Coordinate sum[2];
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t i = 0; i < 2; ++i) {
      const std::size_t node = (y.node + j) * static_cast<std::size_t>(grid.columns + 1) + x.node + i;
      for (std::size_t c = 0; c < 2; ++c) {
        Coordinate& to = sum[c];
        if (table.smooth) {
          const float* const v = table.nodes.data() + DistortionTable::kSmoothNode * node + 4 * c;
          const double along_row = v[0] * across.value[i] + v[1] * across.slope[i],
                       cross_row = v[2] * across.value[i] + v[3] * across.slope[i];
          to.value += along_row * down.value[j] + cross_row * down.slope[j];
          to.by_column += (v[0] * across.value_slope[i] + v[1] * across.slope_slope[i]) * down.value[j] +
                          (v[2] * across.value_slope[i] + v[3] * across.slope_slope[i]) * down.slope[j];
          to.by_row += along_row * down.value_slope[j] + cross_row * down.slope_slope[j];
        } else {
          const double v = table.nodes[DistortionTable::kBilinearNode * node + c];
          const double in_column = i == 0 ? 1 - x.part : x.part, in_row = j == 0 ? 1 - y.part : y.part;
          to.value += v * in_column * in_row;
          to.by_column += (i == 0 ? -v : v) * in_row;
          to.by_row += (j == 0 ? -v : v) * in_column;
        }
      }
    }
  }
  PlaceAndSlopes seen;
  seen.place = {film.x + sum[0].value, film.y + sum[1].value};
  seen.xx = 1 + sum[0].by_column * grid.per_x, seen.xy = sum[0].by_row * grid.per_y;
  seen.yx = sum[1].by_column * grid.per_x, seen.yy = 1 + sum[1].by_row * grid.per_y;
  return seen;
}

}  // namespace tessera::render
