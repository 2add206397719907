#include "light_field/aperture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"

namespace tessera::light_field {
namespace {

/// Points each way that stand for an aperture.
constexpr int kPoints = 96;

/// Whether a point of the square around the unit circle lies in the opening.
bool is_open(double x, double y, const Aperture& aperture) {
  if (x * x + y * y > 1) return false;
  if (aperture.blades == 0) return true;
  const double side = 2 * std::numbers::pi / aperture.blades;
  const double from_corner = std::atan2(y, x) - aperture.blade_degrees * std::numbers::pi / 180;
  // The angle from the middle of the nearest side, whose distance from the circle's middle is its cosine.
  const double angle = from_corner - side * (std::floor(from_corner / side) + 0.5);
  return std::hypot(x, y) * std::cos(angle) <= std::cos(side / 2);
}

/// A place among `count` cameras, from 0 to count - 1, between two of them. False beside them.
bool split(double place, std::uint32_t count, std::uint32_t& index, double& rest) {
  const double last = count - 1, slack = count == 1 ? 0.5 : 1e-9;
  if (!(place >= -slack && place <= last + slack)) return false;
  const double inside = std::clamp(place, 0.0, last);
  index = std::min(static_cast<std::uint32_t>(inside), count == 1 ? 0 : count - 2);
  rest = inside - index;
  return true;
}

/// Adds the weight of a point, world units from the grid's middle, to the cameras around it.
bool add_point(const CameraGrid& grid, double x, double y, std::vector<double>& weights) {
  const double across = grid.spacing_x > 0 ? x / grid.spacing_x : 0;
  const double down = grid.spacing_y > 0 ? -y / grid.spacing_y : 0;
  std::uint32_t column = 0, row = 0;
  double u = 0, v = 0;
  if (!split(across + 0.5 * (grid.columns - 1), grid.columns, column, u) ||
      !split(down + 0.5 * (grid.rows - 1), grid.rows, row, v)) {
    return false;
  }
  const std::size_t first = std::size_t{row} * grid.columns + column;
  const std::size_t right = grid.columns > 1 ? 1 : 0, below = grid.rows > 1 ? grid.columns : 0;
  weights[first] += (1 - u) * (1 - v);
  weights[first + right] += u * (1 - v);
  weights[first + below] += (1 - u) * v;
  weights[first + below + right] += u * v;
  return true;
}

}  // namespace

double largest_radius(const CameraGrid& grid) {
  return 0.5 * std::min((grid.columns - 1) * grid.spacing_x, (grid.rows - 1) * grid.spacing_y);
}

absl::StatusOr<std::vector<std::pair<std::uint32_t, float>>> camera_weights(const CameraGrid& grid,
                                                                            const Aperture& aperture) {
  std::vector<double> weights(std::size_t{grid.columns} * grid.rows);
  if (!add_point(grid, aperture.x, aperture.y, weights)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the aperture's middle, ", aperture.x, ",", aperture.y, ", lies beside the cameras, ",
                     (grid.columns - 1) * grid.spacing_x, " x ", (grid.rows - 1) * grid.spacing_y, " wide"));
  }
  if (aperture.radius > 0) {
    std::ranges::fill(weights, 0);
    for (int j = 0; j < kPoints; ++j) {
      for (int i = 0; i < kPoints; ++i) {
        const double x = 2 * (i + 0.5) / kPoints - 1, y = 2 * (j + 0.5) / kPoints - 1;
        if (!is_open(x, y, aperture)) continue;
        static_cast<void>(
            add_point(grid, aperture.x + aperture.radius * x, aperture.y + aperture.radius * y, weights));
      }
    }
  }
  double sum = 0;
  for (const double weight : weights) sum += weight;
  std::vector<std::pair<std::uint32_t, float>> views;
  for (std::uint32_t i = 0; i < weights.size(); ++i) {
    if (weights[i] > 0) views.emplace_back(grid.first_view + i, static_cast<float>(weights[i] / sum));
  }
  return views;
}

}  // namespace tessera::light_field
