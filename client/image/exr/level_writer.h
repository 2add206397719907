// Tiles of a part, and of its mip levels, from rows that come from the top.
#pragma once

#include <cstdint>
#include <vector>

#include "image/exr/chunk_writer.h"

namespace tessera::client {

/// Keeps one row of tiles of each level, however tall the picture is. A level is half as large as the one
/// before it, rounded down; its pixels are means of four, or of what there is of them.
class LevelWriter {
 public:
  LevelWriter(ChunkWriter& chunks, const ExrPart& part, std::int32_t width, std::int32_t height,
              std::int32_t tile_size, bool mipmaps);

  /// The next row: of each channel of the part `width` values. Throws WriteError.
  void add(const std::vector<std::vector<float>>& row) { add(0, row); }

 private:
  using Row = std::vector<std::vector<float>>;  // values of the row, for each channel
  struct Level {
    std::int32_t width, height;
    std::int32_t rows_added = 0;
    std::vector<Row> band{};  // rows not written yet
    Row above{};              // the first of a pair of rows
  };

  void add(std::size_t level, const Row& row);
  void write_band(std::size_t level);
  /// Half as wide, from one row or two.
  Row halved(const Level& from, const Row& above, const Row& below) const;

  ChunkWriter& chunks_;
  const ExrPart& part_;
  const std::int32_t tile_size_;
  std::vector<Level> levels_;
};

}  // namespace tessera::client
