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

/// Hermite's cubics [value or slope][end].
struct Cubics {
  double value[2], slope[2];
  explicit Cubics(double t)
      : value{(1 + 2 * t) * (1 - t) * (1 - t), t * t * (3 - 2 * t)},
        slope{t * (1 - t) * (1 - t), t * t * (t - 1)} {}
};

}  // namespace

PlanePoint undistorted(const DistortionTable& table, PlanePoint film) {
  const PlaceGrid& grid = table.grid;
  const Along x = along(film.x, grid.first_x, grid.per_x, grid.columns),
              y = along(film.y, grid.first_y, grid.per_y, grid.rows);
  const Cubics across(x.part), down(y.part);
  double sum[2] = {0, 0};
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t i = 0; i < 2; ++i) {
      const std::size_t node = (y.node + j) * static_cast<std::size_t>(grid.columns + 1) + x.node + i;
      for (std::size_t c = 0; c < 2; ++c) {
        if (table.smooth) {
          const float* const v = table.nodes.data() + DistortionTable::kSmoothNode * node + 4 * c;
          sum[c] += (v[0] * across.value[i] + v[1] * across.slope[i]) * down.value[j] +
                    (v[2] * across.value[i] + v[3] * across.slope[i]) * down.slope[j];
        } else {
          sum[c] += table.nodes[DistortionTable::kBilinearNode * node + c] * (i == 0 ? 1 - x.part : x.part) *
                    (j == 0 ? 1 - y.part : y.part);
        }
      }
    }
  }
  return {film.x + sum[0], film.y + sum[1]};
}

}  // namespace tessera::render
