#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <utility>
#include <vector>

#include "render/scene/view/distorted_film.h"

namespace tessera::render {

namespace {

constexpr std::int32_t kStartCells = 64;  // each way
constexpr double kBeyondAll = std::numeric_limits<double>::infinity();

/// A node: a place of the film, and the undistorted one that it sees.
struct SeenPlace {
  PlanePoint film, place;
};

/// Nodes of the table: some, so that a large map takes no longer than a small one.
std::vector<SeenPlace> seen_places(const DistortionTable& table) {
  const PlaceGrid& grid = table.grid;
  const std::size_t node_floats =
      table.smooth ? DistortionTable::kSmoothNode : DistortionTable::kBilinearNode;
  const std::size_t second = table.smooth ? 4 : 1;
  const int step_x = std::max(1, grid.columns / (4 * kStartCells)),
            step_y = std::max(1, grid.rows / (4 * kStartCells));
  std::vector<SeenPlace> seen;
  for (int row = 0; row <= grid.rows; row += step_y) {
    for (int column = 0; column <= grid.columns; column += step_x) {
      const std::size_t at =
          node_floats * (static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns + 1) +
                         static_cast<std::size_t>(column));
      const PlanePoint film = node_place(grid, column, row);
      seen.push_back({film, {film.x + double{table.nodes[at]}, film.y + double{table.nodes[at + second]}}});
    }
  }
  return seen;
}

/// Lays the cells over all places. False where they have no extent, or none that is finite.
bool span_places(const std::vector<SeenPlace>& seen, PlaceGrid& grid) {
  PlanePoint low{kBeyondAll, kBeyondAll}, high{-kBeyondAll, -kBeyondAll};
  for (const SeenPlace& one : seen) {
    low = {std::min(low.x, one.place.x), std::min(low.y, one.place.y)};
    high = {std::max(high.x, one.place.x), std::max(high.y, one.place.y)};
  }
  if (!(high.x > low.x && high.y > low.y && std::isfinite(high.x - low.x + high.y - low.y))) return false;
  grid.columns = grid.rows = kStartCells;
  grid.first_x = static_cast<float>(low.x), grid.first_y = static_cast<float>(low.y);
  grid.per_x = static_cast<float>(kStartCells / (high.x - low.x));
  grid.per_y = static_cast<float>(kStartCells / (high.y - low.y));
  return true;
}

/// Fills cells that nothing is seen in with what the next cell has. `open`: those that are filled.
void spread(std::deque<int> open, std::vector<bool>& filled, std::vector<PlanePoint>& starts) {
  while (!open.empty()) {
    const int at = open.front(), x = at % kStartCells, y = at / kStartCells;
    open.pop_front();
    for (const auto& [to_x, to_y] : {std::pair{x + 1, y}, {x - 1, y}, {x, y + 1}, {x, y - 1}}) {
      if (to_x < 0 || to_y < 0 || to_x >= kStartCells || to_y >= kStartCells) continue;
      const auto from = static_cast<std::size_t>(at),
                 to = static_cast<std::size_t>(to_y * kStartCells + to_x);
      if (filled[to]) continue;
      filled[to] = true;
      starts[to] = starts[from];
      open.push_back(to_y * kStartCells + to_x);
    }
  }
}

}  // namespace

absl::Status add_starts(DistortionTable& table) {
  const std::vector<SeenPlace> seen = seen_places(table);
  PlaceGrid& grid = table.start_grid;
  if (!span_places(seen, grid))
    return absl::InvalidArgumentError("camera: its distortion leads to places that are beyond numbers");
  constexpr std::size_t kCells = std::size_t{kStartCells} * kStartCells;
  std::vector<PlanePoint> starts(kCells);
  // A cell has the node next to its middle.
  std::vector<double> distances(kCells, kBeyondAll);
  std::vector<bool> filled(kCells, false);
  std::deque<int> open;
  for (const SeenPlace& one : seen) {
    const double x = (one.place.x - double{grid.first_x}) * double{grid.per_x},
                 y = (one.place.y - double{grid.first_y}) * double{grid.per_y};
    const int column = std::clamp(static_cast<int>(x), 0, kStartCells - 1),
              row = std::clamp(static_cast<int>(y), 0, kStartCells - 1);
    const auto cell = static_cast<std::size_t>(row * kStartCells + column);
    const double distance = std::hypot(x - column - 0.5, y - row - 0.5);
    if (distance >= distances[cell]) continue;
    if (!filled[cell]) open.push_back(row * kStartCells + column);
    filled[cell] = true;
    distances[cell] = distance;
    starts[cell] = one.film;
  }
  spread(std::move(open), filled, starts);
  for (const PlanePoint& start : starts) {
    table.starts.push_back(static_cast<float>(start.x));
    table.starts.push_back(static_cast<float>(start.y));
  }
  add_slopes(table);
  return absl::OkStatus();
}

}  // namespace tessera::render
