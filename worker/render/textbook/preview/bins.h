// Which clusters may cover which square of a film: triangles are looked at only where they may be seen.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/sensor/projection.h"
#include "render/textbook/preview/clusters.h"

namespace tessera::render::TESSERA_ISA {

inline constexpr int kBinSide = 32;  // pixels; bins lie on a grid from the film's upper left corner

/// Where boxes lie on a film, with room for roundings and for the reach of samples.
struct BoxesOnFilm {
  Int x0, y0, x1, y1;  // pixels, up to x1 and y1 exclusive, within [0, width) x [0, height) given
  Float nearness;  // none of it is nearer; see nearness_of(); infinite where the box reaches behind the eye
  Mask seen;       // some pixel may show some of it
};

/// `rows` map the boxes' space to a film of `width` x `height` pixels; `projection` is the one they are of.
BoxesOnFilm boxes_on_film(const WideBox& boxes, const Rows& rows, const Projection& projection, int width,
                          int height, Mask active);

/// The measure of depth that is compared: it grows towards the eye, and is linear over the film for points of
/// a plane [Blinn 1992]: 1 / depth, or -depth where lines of sight are parallel.
TESSERA_INLINE Float nearness_of(bool perspective, Float depth) {
  return perspective ? 1.0f / depth : -depth;
}

/// A cluster, and the bins that it may cover.
struct BinEntry {
  float nearness;  // none of it is nearer
  std::uint32_t draw;
  std::uint32_t cluster;                               // number within its shape
  std::uint16_t column0, row0, last_column, last_row;  // the last are among them

  bool covers(int column, int row) const {
    return column0 <= column && column <= last_column && row0 <= row && row <= last_row;
  }
};

/// Clusters of a view by the bins that they may cover. So that those of many bins take no more memory than
/// others, they are kept by cells of a pyramid, whose cells of level k are squares of 2^k bins: a cluster is
/// in the four cells at most that it lies in at the first level where there are no more.
class Bins {
 public:
  /// Clusters that a piece of the work looks at.
  static constexpr std::uint64_t kPieceSize = 4096;

  Bins(const Clusters& clusters, const ShapeTable& shapes, const Projection& projection);

  std::size_t pieces() const { return found_by_piece_.size(); }
  /// Looks at one piece of all drawn clusters; `seen` says whether a shape is seen in this view. Threads may
  /// do so for different pieces, and again for one that memory ran out for.
  void find(std::size_t piece, const std::vector<std::uint8_t>& seen);
  /// Orders what was found, once all pieces are done.
  void sort();

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  const Projection& projection() const { return projection_; }

  /// Clusters that may cover a bin, near ones first; ties in the order of the scene.
  class Walk {
   public:
    Walk(const Bins& bins, int column, int row);
    /// The next of them; null after the last.
    const BinEntry* next();

   private:
    int column_, row_;
    std::vector<std::span<const BinEntry>> remaining_entries_;  // one span for each cell above the bin
  };
  Walk walk(int column, int row) const { return {*this, column, row}; }
  /// Clusters in all cells together, once sorted.
  std::size_t entries() const { return entries_.size(); }

 private:
  struct Level {
    int columns = 0;
    std::size_t first_cell = 0;  // the level's cells follow, row by row
  };
  struct Found {
    std::uint32_t cell;
    BinEntry entry;
  };
  void add(const BinEntry& entry, std::vector<Found>& found) const;

  const Clusters& clusters_;
  const ShapeTable& shapes_;
  const Projection projection_;
  const int columns_, rows_;
  std::vector<Level> levels_;
  std::size_t cells_ = 0;
  std::vector<std::vector<Found>> found_by_piece_;
  std::vector<std::size_t> cell_begin_;  // index in entries_; one more, the end of the last cell
  std::vector<BinEntry> entries_;
};

}  // namespace tessera::render::TESSERA_ISA
