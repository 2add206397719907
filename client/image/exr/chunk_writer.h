// Packs and writes the chunks of one part: blocks of scanlines, or tiles.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "image/exr/dwa_block.h"
#include "image/exr/exr_file.h"
#include "image/exr/part.h"
#include "image/exr/zip_block.h"

namespace tessera::client {

/// Scanlines that are compressed as one chunk.
std::int32_t lines_of_chunk(ExrCompression compression);
exr_compression_t compression_of(ExrCompression compression);

class ChunkWriter {
 public:
  ChunkWriter(const ExrFile& file, int index, const ExrPart& part);
  ~ChunkWriter();
  ChunkWriter(const ChunkWriter&) = delete;
  ChunkWriter& operator=(const ChunkWriter&) = delete;

  /// Appends the row of the part's next channel to the chunk: rows from the top, in each all channels in
  /// order.
  void append(std::span<const float> row, bool half);
  /// Writes the chunk that begins at line `y` of the film. Throws WriteError, here and below.
  void write_lines(std::int32_t y);
  struct Tile {
    std::int32_t x, y, level;  // x and y count tiles
  };
  void write_tile(const Tile& tile);

 private:
  /// The block as it stands in the file; nothing where OpenEXRCore packs it.
  std::optional<std::span<const unsigned char>> packed(const exr_chunk_info_t& chunk);
  /// Has the library pack the chunk, and write it.
  void encode(const exr_chunk_info_t& chunk);

  const ExrFile& file_;
  const int index_;
  const ExrPart& part_;
  std::vector<unsigned char> block_;
  ZipBlockPacker zip_;
  DwaBlockPacker dwa_;
  std::optional<exr_encode_pipeline_t> pipeline_;
};

}  // namespace tessera::client
