// A frame that is too large for memory: its tiles as they are done, in a temporary file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "image/exr/rows.h"
#include "image/image.h"

namespace tessera::client {

/// Squares on a grid from (0, 0) of the film, cut by `crop`. Memory: a row of tiles, of the planes that are
/// read, and a bit a tile.
class TileFile final : public Rows {
 public:
  /// `planes` values a pixel; `marked` are those in which pixels that no tile has are marked
  /// (hole_marker.h). Internal when there can be no temporary file.
  static absl::StatusOr<std::unique_ptr<TileFile>> create(const Window& crop, std::int32_t tile_size,
                                                          std::size_t planes,
                                                          std::vector<std::size_t> marked = {});
  ~TileFile() override;
  TileFile(const TileFile&) = delete;
  TileFile& operator=(const TileFile&) = delete;

  /// Whether the window is one of the tiles.
  bool is_tile(const Window& pixels) const;
  /// A tile's planes, one behind the other. Internal, here and below, when the disk does not take it.
  absl::Status put(const Window& pixels, std::span<const float> values);
  /// Pixels that no tile has are 0, or marked.
  absl::Status read(std::size_t plane, std::int32_t y, std::span<float> row) override;

  std::size_t tiles() const { return there_.size(); }
  /// The place of a pixel's tile: row by row, from 0.
  std::size_t index_of(std::int32_t x, std::int32_t y) const;
  Window tile(std::size_t index) const {
    const auto column = static_cast<std::int32_t>(index % static_cast<std::size_t>(columns_));
    return window_of(column, static_cast<std::int32_t>(index / static_cast<std::size_t>(columns_)));
  }

 private:
  TileFile(int file, const Window& crop, std::int32_t tile_size, std::size_t planes,
           std::vector<std::size_t> marked);
  Window window_of(std::int32_t column, std::int32_t row) const;
  absl::Status load_band(std::size_t plane, std::int32_t row);
  void mark(const Window& pixels, std::vector<float>& band) const;

  const int file_;
  const Window crop_;
  const std::int32_t tile_size_;
  const std::size_t planes_;
  const std::int32_t first_column_, first_row_, columns_, rows_;  // place and size in the grid
  const std::vector<std::size_t> marked_;
  std::vector<bool> there_;
  /// The part of a plane that is in memory: rows of the crop's width.
  struct Band {
    std::int32_t tile_row = -1;
    std::vector<float> values;
  };
  std::vector<Band> bands_;
};

}  // namespace tessera::client
