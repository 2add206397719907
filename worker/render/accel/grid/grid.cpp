#include "render/accel/grid/grid.h"

#include <future>

#include "absl/strings/str_format.h"
#include "render/accel/structure/clip.h"
#include "render/core/stopped.h"

namespace tessera::render {

namespace {

/// A primitive in a cell.
struct GridItem {
  std::uint32_t cell, primitive;
};

/// Cells of one axis that an interval reaches into. Cells are taken to be wider than they are by more than
/// the walk's roundings, and those of this function.
struct CellRange {
  std::int32_t first, last;
};
CellRange cells_across(const Grid& grid, int axis, float low, float high) {
  constexpr double kRoom = 0x1p-18;
  const double scale = grid.size[axis] / grid.box.extent(axis);
  const double room = kRoom * grid.size[axis];
  const auto cell = [&](double x) {
    return static_cast<std::int32_t>(
        std::clamp(std::floor((x - grid.box.low[axis]) * scale), 0.0, grid.size[axis] - 1.0));
  };
  const double margin = room / scale;
  return {cell(low - margin), cell(high + margin)};
}

/// Whether the plane of a triangle passes a box of half sides `half` about `centre`; always, of others. Most
/// cells within a triangle's box are told by it.
class PlaneTest {
 public:
  explicit PlaneTest(const Primitive& p) {
    if (p.kind != PrimitiveKind::kTriangle) return;
    double e1[3], e2[3];
    for (int k = 0; k < 3; ++k) {
      origin_[k] = p.corners[0][k];
      e1[k] = p.corners[1][k] - origin_[k], e2[k] = p.corners[2][k] - origin_[k];
    }
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      normal_[k] = e1[i] * e2[j] - e1[j] * e2[i];
    }
  }

  bool passes(const double (&centre)[3], const double (&half)[3]) const {
    double height = 0, reach = 0;
    for (int k = 0; k < 3; ++k) {
      height += normal_[k] * (centre[k] - origin_[k]);
      reach += std::abs(normal_[k]) * half[k];
    }
    return std::abs(height) <= reach;
  }

 private:
  double normal_[3] = {0, 0, 0}, origin_[3] = {0, 0, 0};
};

/// Every cell that the primitives from `first` to `last` reach into, in their order.
void list_items(const Grid& grid, const std::vector<Primitive>& primitives, std::size_t first,
                std::size_t last, const std::stop_token& stop, std::vector<GridItem>& items) {
  for (std::size_t i = first; i < last; ++i) {
    throw_if_stopped(stop);
    const Box box = box_of(primitives[i]);
    const PlaneTest plane(primitives[i]);
    CellRange range[3];
    for (int k = 0; k < 3; ++k) range[k] = cells_across(grid, k, box.low[k], box.high[k]);
    const bool one =
        range[0].first == range[0].last && range[1].first == range[1].last && range[2].first == range[2].last;
    for (std::int32_t z = range[2].first; z <= range[2].last; ++z) {
      throw_if_stopped(stop);
      for (std::int32_t y = range[1].first; y <= range[1].last; ++y) {
        for (std::int32_t x = range[0].first; x <= range[0].last; ++x) {
          if (!one) {
            Box cell;
            const std::int32_t at[3] = {x, y, z};
            double centre[3], half[3];
            for (int k = 0; k < 3; ++k) {
              const double room = 0x1p-18 * grid.box.extent(k);
              const double low = grid.plane(k, at[k]) - room, high = grid.plane(k, at[k] + 1) + room;
              centre[k] = 0.5 * (low + high), half[k] = 0.5 * (high - low);
              cell.low[k] = static_cast<float>(low), cell.high[k] = static_cast<float>(high);
            }
            if (!plane.passes(centre, half)) continue;
            if (part_within(primitives[i], cell).empty()) continue;
          }
          items.push_back({static_cast<std::uint32_t>(grid.cell(x, y, z)), static_cast<std::uint32_t>(i)});
        }
      }
    }
  }
}

/// Gives the box of a flat scene, which gets one layer of cells, some height.
void widen(Box& box) {
  const double longest = box.extent(box.longest_axis());
  const double room = std::max(0x1p-10 * longest, 0x1p-20 * box.largest_coordinate());
  for (int k = 0; k < 3; ++k) box.low[k] -= static_cast<float>(room), box.high[k] += static_cast<float>(room);
}

/// How many cells primitives reach into, counted for each: no less than in truth. A triangle is flat: of the
/// a x b x c cells of its box it crosses no more than twice those of the box's three faces.
double count_reached(const Grid& grid, const std::vector<Primitive>& primitives) {
  double all = 0;
  for (const Primitive& primitive : primitives) {
    const Box box = box_of(primitive);
    double cells[3];
    for (int k = 0; k < 3; ++k) {
      const CellRange range = cells_across(grid, k, box.low[k], box.high[k]);
      cells[k] = range.last - range.first + 1;
    }
    const double in_box = cells[0] * cells[1] * cells[2];
    const double of_faces = 2 * (cells[0] * cells[1] + cells[1] * cells[2] + cells[2] * cells[0]);
    all += primitive.kind == PrimitiveKind::kTriangle ? std::min(in_box, of_faces) : in_box;
  }
  return all;
}

absl::Status set_size(const std::vector<Primitive>& primitives, double density, Grid& grid) {
  const auto n = static_cast<double>(primitives.size());
  const double volume = grid.box.extent(0) * grid.box.extent(1) * grid.box.extent(2);
  const double most_items = std::max(kLeastGridItems, kGridItems * n);
  for (double side = std::cbrt(volume / (density * n));; side *= 2) {
    double counts[3], cells = 1;
    for (int k = 0; k < 3; ++k) {
      counts[k] = std::max(1.0, std::round(grid.box.extent(k) / side));
      cells *= counts[k];
    }
    if (!(cells <= kMostGridCells)) {
      return absl::ResourceExhaustedError(absl::StrFormat(
          "accelerator grid: %.3g primitives at %.3g cells each would be %.3g cells; at most %.3g", n,
          density, cells, kMostGridCells));
    }
    for (int k = 0; k < 3; ++k) grid.size[k] = static_cast<std::int32_t>(counts[k]);
    if (cells == 1 || count_reached(grid, primitives) <= most_items) return absl::OkStatus();
  }
}

void measure(std::size_t primitives, Grid& grid) {
  StructureFigures& f = grid.figures;
  f.primitives = primitives;
  for (std::size_t c = 0; c + 1 < grid.firsts.size(); ++c)
    ++(grid.firsts[c] < grid.firsts[c + 1] ? f.leaves : f.empty_leaves);
  f.references = grid.items.size();
  f.bytes = 4 * (grid.firsts.size() + grid.items.size());
  f.depth = 1;
}

}  // namespace

absl::StatusOr<Grid> build_grid(const std::vector<Primitive>& primitives, double density, int threads,
                                std::stop_token stop) {
  Grid grid;
  if (primitives.empty()) return grid;
  for (const Primitive& primitive : primitives) grid.box.add(box_of(primitive));
  widen(grid.box);
  if (auto s = set_size(primitives, density, grid); !s.ok()) return s;

  // Parts of the list, whose cells are then put one after the other: the order is the list's.
  const std::size_t parts = static_cast<std::size_t>(std::max(1, threads));
  std::vector<std::vector<GridItem>> items(parts);
  std::vector<std::future<void>> listed;
  for (std::size_t p = 0; p < parts; ++p) {
    listed.push_back(std::async(p + 1 < parts ? std::launch::async : std::launch::deferred, [&, p] {
      list_items(grid, primitives, p * primitives.size() / parts, (p + 1) * primitives.size() / parts, stop,
                 items[p]);
    }));
  }
  for (std::future<void>& part : listed) part.get();

  throw_if_stopped(stop);

  // Counting sort by cell.
  const std::size_t cells = grid.cell(0, 0, grid.size[2]);
  grid.firsts.assign(cells + 1, 0);
  for (const auto& part : items) {
    for (const GridItem& item : part) ++grid.firsts[item.cell + 1];
  }
  for (std::size_t c = 0; c < cells; ++c) grid.firsts[c + 1] += grid.firsts[c];
  grid.items.resize(grid.firsts.back());
  std::vector<std::uint32_t> next(grid.firsts.begin(), grid.firsts.end() - 1);
  for (const auto& part : items) {
    for (const GridItem& item : part) grid.items[next[item.cell]++] = item.primitive;
  }
  measure(primitives.size(), grid);
  return grid;
}

absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, Grid& tree) {
  absl::StatusOr<Grid> grid = build_grid(primitives, options.grid_density, options.threads, options.stop);
  if (!grid.ok()) return grid.status();
  tree = *std::move(grid);
  return absl::OkStatus();
}

}  // namespace tessera::render
