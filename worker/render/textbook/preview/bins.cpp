#include "render/textbook/preview/bins.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace tessera::render::TESSERA_ISA {

namespace {

TESSERA_INLINE Float apply(const float (&row)[4], Vec3 p) {
  return fma(p.x, Float(row[0]), fma(p.y, Float(row[1]), fma(p.z, Float(row[2]), Float(row[3]))));
}

/// Near ones first; ties in the order of the scene, so that equal depths give equal pictures.
bool is_before(const BinEntry& a, const BinEntry& b) {
  return std::tuple(-a.nearness, a.draw, a.cluster) < std::tuple(-b.nearness, b.draw, b.cluster);
}

/// Pixels up to which `place` on the film reaches, as an integer within [0, most].
TESSERA_INLINE Int pixel_within(Float place, int most) {
  return to_int(clamp(floor(place), 0.0f, static_cast<float>(most)));
}

}  // namespace

BoxesOnFilm boxes_on_film(const WideBox& boxes, const Rows& rows, const Projection& projection, int width,
                          int height, Mask active) {
  // Besides a pixel for all roundings.
  const float margin = static_cast<float>(projection.reach + 1);
  const float left = -margin, top = -margin, right = static_cast<float>(width) + margin,
              bottom = static_cast<float>(height) + margin;
  Mask behind = active, beyond_left = active, beyond_right = active, above = active, below = active;
  Mask crosses = Mask::none();
  constexpr float kMost = std::numeric_limits<float>::max();
  Float x0(kMost), y0(kMost), x1(-kMost), y1(-kMost), least_depth(kMost);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p{corner & 1 ? boxes.high.x : boxes.low.x, corner & 2 ? boxes.high.y : boxes.low.y,
                 corner & 4 ? boxes.high.z : boxes.low.z};
    const Float x = apply(rows.x, p), y = apply(rows.y, p), depth = apply(rows.depth, p);
    const Float w = projection.perspective ? depth : Float(1.0f);
    // A half-space that holds all corners holds the box, on either side of the eye.
    behind &= depth < projection.nearest;
    beyond_left &= x < w * left;
    beyond_right &= x > w * right;
    above &= y < w * top;
    below &= y > w * bottom;
    crosses |= active & (depth < projection.nearest);
    const Float inverse = 1.0f / w;
    x0 = min(x0, x * inverse), x1 = max(x1, x * inverse);
    y0 = min(y0, y * inverse), y1 = max(y1, y * inverse);
    least_depth = min(least_depth, depth);
  }
  BoxesOnFilm result;
  result.x0 = select(crosses, Int(0), pixel_within(x0 - margin, width));
  result.y0 = select(crosses, Int(0), pixel_within(y0 - margin, height));
  result.x1 = select(crosses, Int(width), pixel_within(x1 + (margin + 1.0f), width));
  result.y1 = select(crosses, Int(height), pixel_within(y1 + (margin + 1.0f), height));
  // Roundings of the corners' depths, of some 2^-22 of their terms, are far below a part in a thousand of the
  // depth unless the box nearly reaches the eye.
  const Float largest = abs(boxes.low.x * rows.depth[0]) + abs(boxes.low.y * rows.depth[1]) +
                        abs(boxes.low.z * rows.depth[2]) + abs(boxes.high.x * rows.depth[0]) +
                        abs(boxes.high.y * rows.depth[1]) + abs(boxes.high.z * rows.depth[2]) +
                        std::abs(rows.depth[3]);
  const Float depth = least_depth - largest * 0x1p-20f;
  const Mask in_front = projection.perspective ? depth > 0.0f : Mask::all();
  result.nearness =
      select(and_not(in_front, crosses), nearness_of(projection.perspective, select(in_front, depth, 1.0f)),
             std::numeric_limits<float>::infinity());
  const Mask outside = behind | beyond_left | beyond_right | above | below;
  // Empty boxes are not finite.
  const Mask sound = is_finite(least_depth) & (crosses | is_finite(x0 + x1 + y0 + y1));
  result.seen = and_not(active, outside) & sound & (result.x0 < result.x1) & (result.y0 < result.y1);
  return result;
}

Bins::Bins(const Clusters& clusters, const ShapeTable& shapes, const Projection& projection)
    : clusters_(clusters),
      shapes_(shapes),
      projection_(projection),
      columns_((projection.width + kBinSide - 1) / kBinSide),
      rows_((projection.height + kBinSide - 1) / kBinSide),
      found_by_piece_(static_cast<std::size_t>((clusters.drawn() + kPieceSize - 1) / kPieceSize)) {
  for (int columns = columns_, rows = rows_;; columns = (columns + 1) / 2, rows = (rows + 1) / 2) {
    levels_.push_back({columns, cells_});
    cells_ += static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    if (columns <= 2 && rows <= 2) break;
  }
}

void Bins::add(const BinEntry& entry, std::vector<Found>& found) const {
  int level = 0;
  while ((entry.last_column >> level) - (entry.column0 >> level) > 1 ||
         (entry.last_row >> level) - (entry.row0 >> level) > 1)
    ++level;
  const Level& at = levels_[static_cast<std::size_t>(level)];
  for (int row = entry.row0 >> level; row <= entry.last_row >> level; ++row) {
    for (int column = entry.column0 >> level; column <= entry.last_column >> level; ++column) {
      const std::size_t cell = at.first_cell +
                               static_cast<std::size_t>(row) * static_cast<std::size_t>(at.columns) +
                               static_cast<std::size_t>(column);
      found.push_back({static_cast<std::uint32_t>(cell), entry});
    }
  }
}

void Bins::find(std::size_t piece, const std::vector<std::uint8_t>& seen) {
  std::vector<Found>& found = found_by_piece_[piece];
  found.clear();
  const std::uint64_t begin = piece * kPieceSize, end = std::min(begin + kPieceSize, clusters_.drawn());
  for (std::size_t d = clusters_.draw_at(begin); d < clusters_.draws().size(); ++d) {
    const Draw& draw = clusters_.draws()[d];
    if (draw.first_cluster >= end) break;
    if (!seen[static_cast<std::size_t>(draw.shape)]) continue;
    const Affine* const placed =
        draw.instance < 0 ? nullptr
                          : &shapes_.instances[static_cast<std::size_t>(draw.instance)].render_from_instance;
    const Rows rows = rows_of(projection_, placed, 0, 0, 1);
    const std::size_t first = clusters_.first_of(draw.shape);
    const std::uint64_t last =
        std::min(draw.first_cluster + clusters_.count_of(draw.shape), end) - draw.first_cluster;
    for (std::uint64_t c = std::max(begin, draw.first_cluster) - draw.first_cluster; c < last; c += kWidth) {
      const Mask active = Mask::first(static_cast<int>(std::min<std::uint64_t>(kWidth, last - c)));
      const BoxesOnFilm on_film = boxes_on_film(clusters_.boxes(first + c), rows, projection_,
                                                projection_.width, projection_.height, active);
      alignas(64) std::int32_t x0[kWidth], y0[kWidth], x1[kWidth], y1[kWidth];
      alignas(64) float nearness[kWidth];
      on_film.x0.store(x0), on_film.y0.store(y0), on_film.x1.store(x1), on_film.y1.store(y1);
      on_film.nearness.store(nearness);
      for (std::uint32_t bits = on_film.seen.bits(); bits != 0; bits &= bits - 1) {
        const int i = __builtin_ctz(bits);
        const auto bin_of = [](std::int32_t pixel) { return static_cast<std::uint16_t>(pixel / kBinSide); };
        add({.nearness = nearness[i],
             .draw = static_cast<std::uint32_t>(d),
             .cluster = static_cast<std::uint32_t>(c) + static_cast<std::uint32_t>(i),
             .column0 = bin_of(x0[i]),
             .row0 = bin_of(y0[i]),
             .last_column = bin_of(x1[i] - 1),
             .last_row = bin_of(y1[i] - 1)},
            found);
      }
    }
  }
}

void Bins::sort() {
  std::vector<std::size_t> count(cells_ + 1);
  for (const std::vector<Found>& piece : found_by_piece_) {
    for (const Found& found : piece) ++count[found.cell + 1];
  }
  for (std::size_t i = 1; i < count.size(); ++i) count[i] += count[i - 1];
  cell_begin_ = count;
  entries_.resize(count.back());
  for (const std::vector<Found>& piece : found_by_piece_) {
    for (const Found& found : piece) entries_[count[found.cell]++] = found.entry;
  }
  std::vector<std::vector<Found>>().swap(found_by_piece_);
  for (std::size_t i = 0; i + 1 < cell_begin_.size(); ++i) {
    std::sort(entries_.begin() + static_cast<std::ptrdiff_t>(cell_begin_[i]),
              entries_.begin() + static_cast<std::ptrdiff_t>(cell_begin_[i + 1]), is_before);
  }
}

Bins::Walk::Walk(const Bins& bins, int column, int row) : column_(column), row_(row) {
  for (std::size_t k = 0; k < bins.levels_.size(); ++k) {
    const Level& level = bins.levels_[k];
    const std::size_t cell = level.first_cell +
                             static_cast<std::size_t>(row >> k) * static_cast<std::size_t>(level.columns) +
                             static_cast<std::size_t>(column >> k);
    const std::size_t begin = bins.cell_begin_[cell], end = bins.cell_begin_[cell + 1];
    if (begin < end) remaining_entries_.push_back(std::span(bins.entries_).subspan(begin, end - begin));
  }
}

const BinEntry* Bins::Walk::next() {
  std::span<const BinEntry>* nearest = nullptr;
  for (std::span<const BinEntry>& rest : remaining_entries_) {
    while (!rest.empty() && !rest.front().covers(column_, row_)) rest = rest.subspan(1);
    if (rest.empty() || (nearest != nullptr && !is_before(rest.front(), nearest->front()))) continue;
    nearest = &rest;
  }
  if (nearest == nullptr) return nullptr;
  const BinEntry* const found = &nearest->front();
  *nearest = nearest->subspan(1);
  return found;
}

}  // namespace tessera::render::TESSERA_ISA
