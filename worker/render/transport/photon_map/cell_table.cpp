#include "render/transport/photon_map/cell_table.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace tessera::render::TESSERA_ISA {

/// Whether the rows that a query meets, two numbers each, are apart in tables of all sizes.
constexpr bool CellTable::rows_are_apart() {
  for (int bits = kLeastBits; bits <= kMostBits; ++bits) {
    const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
    for (const std::uint64_t step : {kAlongY, kAlongZ, kAlongY + kAlongZ, kAlongY - kAlongZ}) {
      if (((step + 1) & mask) <= 2) return false;
    }
  }
  return true;
}

void CellTable::build(std::span<const float> x, std::span<const float> y, std::span<const float> z,
                      float radius, BigArray<std::int32_t>& place) {
  static_assert(rows_are_apart());
  const std::size_t points = x.size();
  place.resize(points);
  if (points == 0) {
    first_.clear();
    return;
  }
  // A 64th more than the radius: distances are rounded by some 2^-22 of it. The least keeps the inverse
  // finite.
  margin_ = std::max(1.015625 * double{radius}, double{std::numeric_limits<float>::min()});
  cells_per_unit_ = 1 / (2.03125 * margin_);
  const int bits = std::clamp(static_cast<int>(std::bit_width(points - 1)), kLeastBits, kMostBits);
  mask_ = (std::uint64_t{1} << bits) - 1;

  // A counting sort: first_[n + 1] counts the points with number n, then first_[n] is where they begin.
  first_.assign(mask_ + 3, 0);
  of_point_.resize(points);
  for (std::size_t i = 0; i < points; ++i) {
    of_point_[i] = static_cast<std::uint32_t>(number(cell(x[i]), cell(y[i]), cell(z[i])) & mask_);
    ++first_[of_point_[i] + 2];
  }
  for (std::size_t n = 2; n < first_.size(); ++n) first_[n] += first_[n - 1];
  // Here first_[n + 1] is where the next point with number n belongs, and at the end where those end.
  for (std::size_t i = 0; i < points; ++i) place[i] = first_[of_point_[i] + 1]++;
}

}  // namespace tessera::render::TESSERA_ISA
