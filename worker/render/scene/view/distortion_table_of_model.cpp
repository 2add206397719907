#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "render/scene/view/distorted_film.h"
#include "render/scene/view/distortion_model.h"

namespace tessera::render {

namespace {

/// A place at which a model was solved, and what it sees.
struct SolvedPlace {
  PlanePoint place;
  PlaceAndSlopes seen;

  /// The place that another one sees, if the model goes straight on from here.
  PlaceAndSlopes straight_on(PlanePoint to) const {
    const double x = to.x - place.x, y = to.y - place.y;
    PlaceAndSlopes moved = seen;
    moved.place.x += seen.xx * x + seen.xy * y, moved.place.y += seen.yx * x + seen.yy * y;
    return moved;
  }
};

/// The places that those of the film see by a model: solved from place to place, so that a solution is that
/// of the part of the film about the middle.
class SeenPlaces {
 public:
  SeenPlaces(const DistortionModel& model, const FilmPlaces& film) : model_(model), film_(film) {}

  /// `known`: a place nearby. Nothing where the model folds.
  std::optional<SolvedPlace> from(PlanePoint place, const SolvedPlace& known) const {
    if (model_.leads_to_film()) {
      const auto origin = find_origin(model_, place, known.straight_on(place).place);
      return origin ? std::optional(SolvedPlace{place, *origin}) : std::nullopt;
    }
    const PlaceAndSlopes moved = model_.move(place);
    return moved.determinant() > 0 ? std::optional(SolvedPlace{place, moved}) : std::nullopt;
  }

  /// Starts where rays go straight on, and walks to the place.
  std::optional<SolvedPlace> walk_to(PlanePoint place) const {
    const PlanePoint start = model_.leads_to_film() ? model_.move({0, 0}).place : PlanePoint{0, 0};
    auto known = from(start, {start, {{0, 0}}});
    constexpr int kSteps = 256;
    for (int i = 1; i <= kSteps && known; ++i) {
      const double part = double{1} / kSteps * i;
      known = from({start.x + part * (place.x - start.x), start.y + part * (place.y - start.y)}, *known);
    }
    return known;
  }

  /// A place that may lie beyond the film.
  struct Node {
    SolvedPlace on_film;  // there, or next to it: what others are solved from, as it is before any fold
    PlaceAndSlopes seen;
    bool is_solved;  // else the model folds beyond the film, and goes straight on from `on_film`
  };
  std::optional<Node> node_at(PlanePoint place, const SolvedPlace& known) const {
    const bool is_on_film = film_.has(place);
    const auto on_film = from(is_on_film ? place : film_.nearest(place), known);
    if (!on_film) return std::nullopt;
    const auto solved = is_on_film ? on_film : from(place, *on_film);
    return Node{*on_film, solved ? solved->seen : on_film->straight_on(place), solved.has_value()};
  }

 private:
  const DistortionModel& model_;
  const FilmPlaces& film_;
};

/// Fills a smooth table of a model, from the node next to the middle outwards.
class SmoothTable {
 public:
  SmoothTable(const DistortionModel& model, const FilmPlaces& film, std::int32_t cells)
      : seen_(model, film), film_(film) {
    const double longer = std::max(film.width, film.height);
    const auto cells_of = [&](double pixels) {
      return std::max<std::int32_t>(2, static_cast<std::int32_t>(std::lround(cells * pixels / longer)));
    };
    table_.grid.columns = cells_of(film.width), table_.grid.rows = cells_of(film.height);
    span(film, {-kPixelsBeyondFilm, -kPixelsBeyondFilm},
         {film.width + kPixelsBeyondFilm, film.height + kPixelsBeyondFilm}, table_.grid);
  }

  absl::Status fill() {
    const PlaceGrid& grid = table_.grid;
    const int stride = grid.columns + 1;
    nodes_.resize(static_cast<std::size_t>(stride) * static_cast<std::size_t>(grid.rows + 1));
    const int column = std::clamp(static_cast<int>(std::lround(-grid.first_x * grid.per_x)), 0, grid.columns),
              row = std::clamp(static_cast<int>(std::lround(-grid.first_y * grid.per_y)), 0, grid.rows);
    const PlanePoint first = film_.nearest(node_place(grid, column, row));
    const auto start = seen_.walk_to(first);
    if (!start) return folds_at(film_, first);
    std::deque<int> open;
    if (auto s = solve(row * stride + column, *start); !s.ok()) return s;
    open.push_back(row * stride + column);
    while (!open.empty()) {
      const int at = open.front();
      open.pop_front();
      const int x = at % stride, y = at / stride;
      const auto visit = [&](int to_x, int to_y) -> absl::Status {
        if (to_x < 0 || to_y < 0 || to_x > grid.columns || to_y > grid.rows) return absl::OkStatus();
        const int to = to_y * stride + to_x;
        if (nodes_[static_cast<std::size_t>(to)]) return absl::OkStatus();
        open.push_back(to);
        return solve(to, nodes_[static_cast<std::size_t>(at)]->on_film);
      };
      for (const auto& [to_x, to_y] : {std::pair{x + 1, y}, {x - 1, y}, {x, y + 1}, {x, y - 1}})
        if (auto s = visit(to_x, to_y); !s.ok()) return s;
    }
    write();
    return absl::OkStatus();
  }

  /// Largest error in the middle of a cell of the film, in pixels; the error where the model folds there.
  absl::StatusOr<double> largest_error() const {
    const PlaceGrid& grid = table_.grid;
    double largest = 0;
    for (int row = 0; row < grid.rows; ++row) {
      for (int column = 0; column < grid.columns; ++column) {
        const PlanePoint place = node_place(grid, column + 0.5, row + 0.5);
        if (!film_.has(place)) continue;
        const std::size_t at = static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns + 1) +
                               static_cast<std::size_t>(column);
        const auto solved = seen_.from(place, nodes_[at]->on_film);
        if (!solved) return folds_at(film_, place);
        const PlaceAndSlopes& exact = solved->seen;
        const double error_x = middle_of_cell(at, 0) + place.x - exact.place.x,
                     error_y = middle_of_cell(at, 4) + place.y - exact.place.y;
        // The seen place moves by the inverse of the slopes on the film.
        const double determinant = exact.determinant();
        largest = std::max(
            {largest, std::abs((exact.yy * error_x - exact.xy * error_y) / (determinant * film_.scale_x)),
             std::abs((exact.xx * error_y - exact.yx * error_x) / (determinant * film_.scale_y))});
      }
    }
    return largest;
  }

  DistortionTable take() { return std::move(table_); }

 private:
  absl::Status solve(int node, const SolvedPlace& known) {
    const int stride = table_.grid.columns + 1;
    const int x = node % stride, y = node / stride;
    const PlanePoint place = node_place(table_.grid, x, y);
    auto found = seen_.node_at(place, known);
    if (!found) return folds_at(film_, film_.nearest(place));
    nodes_[static_cast<std::size_t>(node)] = *found;
    return absl::OkStatus();
  }

  /// The mean of a coordinate's cubics there: values have a weight of 1/2 along each axis, slopes one of 1/8.
  double middle_of_cell(std::size_t first, std::size_t component) const {
    double sum = 0;
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 2; ++i) {
        const std::size_t node = first + static_cast<std::size_t>(j * (table_.grid.columns + 1) + i);
        const float* const v = table_.nodes.data() + node * DistortionTable::kSmoothNode + component;
        const double along = i == 0 ? 0.125 : -0.125, down = j == 0 ? 0.125 : -0.125;
        sum += 0.25 * v[0] + 0.5 * (along * v[1] + down * v[2]) + along * down * v[3];
      }
    }
    return sum;
  }

  /// The nodes as differences, with derivatives for steps of a cell.
  void write() {
    const PlaceGrid& grid = table_.grid;
    const double cell_x = 1 / double{grid.per_x}, cell_y = 1 / double{grid.per_y};
    table_.nodes.reserve(nodes_.size() * DistortionTable::kSmoothNode);
    for (int row = 0; row <= grid.rows; ++row) {
      for (int column = 0; column <= grid.columns; ++column) {
        const PlanePoint place = node_place(grid, column, row);
        const SeenPlaces::Node& node = *nodes_[static_cast<std::size_t>(row * (grid.columns + 1) + column)];
        const PlaceAndSlopes& seen = node.seen;
        // Mixed derivatives by differences of derivatives, which are right to their last digits.
        constexpr double kStep = 1e-3;
        const PlanePoint before{place.x, place.y - kStep * cell_y}, after{place.x, place.y + kStep * cell_y};
        const auto up = seen_.from(before, {place, seen}), down = seen_.from(after, {place, seen});
        double mixed_x = 0, mixed_y = 0;
        if (up && down && node.is_solved) {
          mixed_x = (down->seen.xx - up->seen.xx) / (2 * kStep) * cell_x;
          mixed_y = (down->seen.yx - up->seen.yx) / (2 * kStep) * cell_x;
        }
        for (const double v : {seen.place.x - place.x, (seen.xx - 1) * cell_x, seen.xy * cell_y, mixed_x,
                               seen.place.y - place.y, seen.yx * cell_x, (seen.yy - 1) * cell_y, mixed_y})
          table_.nodes.push_back(static_cast<float>(v));
      }
    }
  }

  const SeenPlaces seen_;
  const FilmPlaces& film_;
  DistortionTable table_;
  std::vector<std::optional<SeenPlaces::Node>> nodes_;
};

}  // namespace

absl::StatusOr<DistortionTable> table_of_model(const DistortionModel& model, const FilmPlaces& film) {
  // Smaller than what 32-bit floats hold of the places of usual films.
  constexpr double kEnoughPixels = 1e-5;
  constexpr std::int32_t kFewest = 64, kMost = 512;
  double error_before = std::numeric_limits<double>::infinity();
  for (std::int32_t cells = kFewest;; cells *= 2) {
    SmoothTable table(model, film, cells);
    if (auto s = table.fill(); !s.ok()) return s;
    const absl::StatusOr<double> error = table.largest_error();
    if (!error.ok()) return error.status();
    // The rest may be rounding, which smaller cells do not mend.
    if (*error <= kEnoughPixels || *error > error_before / 2 || cells >= kMost) return table.take();
    error_before = *error;
  }
}

}  // namespace tessera::render
