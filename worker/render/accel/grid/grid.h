// A grid of equal cells [Fujimoto, Tanaka & Iwata 1986; Amanatides & Woo 1987].
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/accel/structure/figures.h"
#include "render/accel/structure/primitive.h"
#include "render/accel/structure/structure_options.h"

namespace tessera::render {

struct Grid {
  Box box;
  std::int32_t size[3] = {0, 0, 0};   // cells along each axis; 0: the grid is empty
  std::vector<std::uint32_t> firsts;  // index of each cell's first item, x fastest; one more at the end
  std::vector<std::uint32_t> items;   // indices of primitives
  StructureFigures figures;

  std::size_t cell(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(x);
  }
  /// Where the plane between cells i - 1 and i stands.
  double plane(int axis, std::int32_t i) const {
    return box.low[axis] + box.extent(axis) * (static_cast<double>(i) / size[axis]);
  }
};

/// Bound of a grid's memory, at 4 bytes a cell.
inline constexpr double kMostGridCells = 0x1p28;
/// How often a primitive may lie in a cell, in the mean; few primitives may do so more often. Where they
/// would, as large ones do among many, sides of cells are doubled.
inline constexpr double kGridItems = 64, kLeastGridItems = 0x1p20;

/// ResourceExhausted, with both numbers, for more cells than that. The same grid for any number of threads.
absl::StatusOr<Grid> build_grid(const std::vector<Primitive>& primitives, double density, int threads,
                                std::stop_token stop = {});
absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, Grid& tree);

}  // namespace tessera::render
