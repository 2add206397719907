#include "render/shape/implicit/mark_cells.h"

#include <vector>

#include "render/shape/implicit/interval.h"
#include "render/shape/implicit/run_program.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr std::int32_t kMostCells = 64;  // along an axis
/// Walks are off by roundings: cells are taken to be wider, in parts of their width.
constexpr double kRoom = 0x1p-16;

struct Cell {
  std::int32_t x, y, z;
};

/// Takes those out of `cells`, of which there are `n` along each axis, that the surface does not cross.
void keep_crossed(const ImplicitRecord& surface, std::int32_t n, std::vector<Cell>& cells) {
  const auto place = [&](int axis, const std::int32_t(&at)[kWidth]) {
    alignas(64) double low[kWidth], high[kWidth];
    const double from = surface.low[axis], width = (double{surface.high[axis]} - from) / n;
    for (int i = 0; i < kWidth; ++i) {
      low[i] = from + (at[i] - kRoom) * width;
      high[i] = from + (at[i] + 1 + kRoom) * width;
    }
    return outward(Double::load(low), Double::load(high));
  };
  std::size_t kept = 0;
  for (std::size_t first = 0; first < cells.size(); first += kWidth) {
    std::int32_t at[3][kWidth];
    for (std::size_t i = 0; i < kWidth; ++i) {
      const Cell& cell = cells[std::min(first + i, cells.size() - 1)];
      at[0][i] = cell.x, at[1][i] = cell.y, at[2][i] = cell.z;
    }
    const Interval f = run_program(surface.program, place(0, at[0]), place(1, at[1]), place(2, at[2]));
    // Not: has one. What is no number may be anything.
    const std::uint32_t without = mask_of(f.low > Double(0.0)).bits() | mask_of(f.high < Double(0.0)).bits();
    for (std::size_t i = 0; i < kWidth && first + i < cells.size(); ++i) {
      if ((without >> i & 1) == 0) cells[kept++] = cells[first + i];
    }
  }
  cells.resize(kept);
}

std::vector<Cell> halves_of(const std::vector<Cell>& cells) {
  std::vector<Cell> halves;
  halves.reserve(8 * cells.size());
  for (const Cell& c : cells) {
    for (std::int32_t k = 0; k < 8; ++k)
      halves.push_back({2 * c.x + (k & 1), 2 * c.y + (k >> 1 & 1), 2 * c.z + (k >> 2)});
  }
  return halves;
}

}  // namespace

void mark_cells(ImplicitRecord& surface, std::size_t most_work) {
  if (surface.roots != ImplicitRoots::kInterval || surface.degree > 0) return;
  std::vector<Cell> cells{{0, 0, 0}};
  std::int32_t n = 1;
  std::size_t work = 0;
  while (n < kMostCells && !cells.empty()) {
    work += (8 * cells.size() / kWidth + 1) * surface.program.instructions.size();
    if (work > most_work) break;
    cells = halves_of(cells);
    n *= 2;
    keep_crossed(surface, n, cells);
  }
  if (n == 1) return;
  const auto all = static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  surface.cells = n;
  surface.marked.assign((all + 63) / 64, 0);
  for (const Cell& c : cells) {
    const auto index = static_cast<std::size_t>((c.z * n + c.y) * n + c.x);
    surface.marked[index / 64] |= std::uint64_t{1} << index % 64;
  }
}

}  // namespace tessera::render::TESSERA_ISA
