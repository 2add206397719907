#include "render/transport/guide/guide_field.h"

#include <algorithm>
#include <array>
#include <bit>
#include <unordered_map>

#include "base/split_mix.h"
#include "render/core/constants.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A cell has a density of its own from so many samples on; with fewer, that of a larger cell.
constexpr std::uint64_t kLeastSamples = 4096;
/// The largest cells have one from so many samples on: with fewer, there is none.
constexpr std::uint64_t kLeastOfLargest = kLeastSamples / 4;
/// Following does not pay where its squares are beyond the BSDF's by more than this: as few of them hold most
/// of the sum, they are a rough measure, and what is learned later is better than what they are of.
constexpr double kTolerance = 1.25;

constexpr std::uint64_t kNoCell = ~std::uint64_t{0};

/// Sums of a cell of any size.
struct Node {
  std::uint64_t count = 0;
  double squares[guide_key::kSquareSums] = {};
  std::int32_t density = -1;

  bool pays() const { return squares[1] <= kTolerance * squares[0]; }
};
using Nodes = std::unordered_map<std::uint64_t, Node>;

}  // namespace

/// Cells as they were learned, and those that hold 8, 64, ... of them.
struct GuideField::Sums {
  std::array<Nodes, kGuideMerges + 1> levels;
  struct Cell {
    std::uint64_t key;
    std::size_t level;   // whose density it has
    std::uint64_t node;  // there
  };
  std::vector<Cell> cells;
  std::int32_t densities = 0;

  explicit Sums(const std::vector<GuideSum>& sums) {
    for (std::size_t i = 0; i < sums.size();) {
      const std::uint64_t key = guide_key::cell_of(sums[i].key);
      Node own;
      for (; i < sums.size() && guide_key::cell_of(sums[i].key) == key; ++i) {
        const int bin = guide_key::bin_of(sums[i].key);
        if (bin < kGuideBins) {
          own.count += sums[i].count;
        } else if (bin < kGuideBins + guide_key::kSquareSums) {
          own.squares[bin - kGuideBins] += static_cast<double>(sums[i].value);
        }
      }
      cells.push_back({key, 0, key});
      std::uint64_t holder = key;
      for (Nodes& level : levels) {
        Node& node = level[holder];
        node.count += own.count;
        for (int k = 0; k < guide_key::kSquareSums; ++k) node.squares[k] += own.squares[k];
        holder = guide_key::parent(holder);
      }
    }
    for (Cell& cell : cells) {
      while (cell.level < kGuideMerges && levels[cell.level].at(cell.node).count < kLeastSamples)
        ++cell.level, cell.node = guide_key::parent(cell.node);
      Node& node = levels[cell.level].at(cell.node);
      if (node.density < 0 && node.count >= kLeastOfLargest) node.density = densities++;
    }
  }

  /// Tallies of all densities, kGuideBins each.
  std::vector<GuideTally> tallies(const std::vector<GuideSum>& sums) const {
    std::vector<GuideTally> all(static_cast<std::size_t>(densities) * kGuideBins);
    for (const GuideSum& sum : sums) {
      const int bin = guide_key::bin_of(sum.key);
      if (bin >= kGuideBins) continue;
      std::uint64_t holder = guide_key::cell_of(sum.key);
      for (const Nodes& level : levels) {
        if (const std::int32_t density = level.at(holder).density; density >= 0) {
          GuideTally& tally = all[static_cast<std::size_t>(density * kGuideBins + bin)];
          tally.value += static_cast<double>(sum.value), tally.count += static_cast<double>(sum.count);
        }
        holder = guide_key::parent(holder);
      }
    }
    return all;
  }
};

GuideField::GuideField(const std::vector<GuideSum>& sums) {
  const Sums nodes(sums);
  const std::vector<GuideTally> tallies = nodes.tallies(sums);
  for (std::size_t first = 0; first < tallies.size(); first += kGuideBins)
    add_density(std::span(tallies).subspan(first, kGuideBins));
  enter(nodes);
}

void GuideField::add_density(std::span<const GuideTally> bins) {
  const std::vector<double> share = guide_density(bins);
  double rows = 0;
  float row_begin = 0;
  for (std::size_t y = 0; y < kGuideRows; ++y) {
    const std::span<const double> own = std::span(share).subspan(y * kGuideRows, kGuideRows);
    double row = 0, columns = 0;
    for (const double part : own) row += part;
    rows += row;
    const bool last_row = y + 1 == kGuideRows;
    rows_.push_back(last_row ? 1.0f : std::min(static_cast<float>(rows), 1.0f));
    // The density is that of what is sampled, roundings of the intervals' ends included.
    const float height = rows_.back() - row_begin;
    float begin = 0;
    for (std::size_t x = 0; x < kGuideRows; ++x) {
      columns += own[x];
      const float end = x + 1 == kGuideRows ? 1.0f : std::min(static_cast<float>(columns / row), 1.0f);
      columns_.push_back(end);
      pdf_.push_back(height * (end - begin) * (kGuideBins * kInvPi / 4));
      begin = end;
    }
    row_begin = rows_.back();
  }
}

void GuideField::enter(const Sums& sums) {
  entries_.assign(std::bit_ceil(sums.cells.size() * 2 + 1), {kNoCell, -1, false});
  const std::size_t mask = entries_.size() - 1;
  for (const Sums::Cell& cell : sums.cells) {
    const Node& node = sums.levels[cell.level].at(cell.node);
    if (node.density < 0) continue;
    std::size_t at = base::split_mix(cell.key) & mask;
    while (entries_[at].cell != kNoCell) at = (at + 1) & mask;
    entries_[at] = {cell.key, node.density, node.pays()};
    any_followed_ = any_followed_ || node.pays();
  }
}

Guided GuideField::at(const GuideCells& cells, Mask lanes) const {
  alignas(64) std::int32_t exponent[kWidth], x[kWidth], y[kWidth], z[kWidth], side[kWidth];
  cells.size_exponent.store(exponent), cells.x.store(x), cells.y.store(y), cells.z.store(z);
  cells.side.store(side);
  alignas(64) std::int32_t density[kWidth] = {};
  std::uint32_t known = 0, followed = 0;
  const std::size_t mask = entries_.size() - 1;
  for (std::uint32_t bits = lanes.bits(); bits != 0; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    const std::uint64_t cell = guide_key::cell(exponent[i], x[i], y[i], z[i], side[i]);
    std::size_t at = base::split_mix(cell) & mask;
    while (entries_[at].cell != cell && entries_[at].cell != kNoCell) at = (at + 1) & mask;
    const Entry& entry = entries_[at];
    if (entry.cell == kNoCell) continue;
    known |= 1u << i;
    followed |= std::uint32_t{entry.followed} << i;
    density[i] = entry.density;
  }
  return {Mask::from_bits(known), Mask::from_bits(followed), Int::load(density)};
}

namespace {

/// One of kGuideRows intervals of the unit interval, and a place in it.
struct Interval {
  Int index;
  Float offset;  // [0, 1)
};
/// The first whose end, from ends[first] on, is beyond u.
TESSERA_INLINE Interval find_interval(const float* ends, Int first, Float u, Mask lanes) {
  Int index(0);
  for (int step = kGuideRows / 2; step > 0; step /= 2) {
    const Mask beyond = gather(ends, first + index + (step - 1), lanes) <= u;
    index = select(beyond, index + step, index);
  }
  const Float end = gather(ends, first + index, lanes);
  const Float begin = gather(ends, first + index - 1, lanes & (index > 0));
  const Float width = end - begin;
  return {index, clamp((u - begin) / select(width > 0.0f, width, 1.0f), 0.0f, kOneMinusEpsilon)};
}

}  // namespace

Vec3 GuideField::sample(const Guided& guided, Vec2 u, Mask lanes) const {
  const Interval row = find_interval(rows_.data(), guided.density * kGuideRows, u.y, lanes);
  const Interval column =
      find_interval(columns_.data(), guided.density * kGuideBins + row.index * kGuideRows, u.x, lanes);
  return direction_from_octahedral({(to_float(column.index) + column.offset) * (1.0f / kGuideRows),
                                    (to_float(row.index) + row.offset) * (1.0f / kGuideRows)});
}

Float GuideField::pdf(const Guided& guided, Vec3 w, Mask lanes) const {
  return gather(pdf_.data(), guided.density * kGuideBins + guide_bin(w), lanes);
}

}  // namespace tessera::render::TESSERA_ISA
