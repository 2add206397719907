// The bytes of a view's file, mapped into memory, and the pixels of its tiles.
#pragma once

#include <OpenEXR/openexr.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "light_field/manifest.h"

namespace tessera::light_field {

/// Where a tile's pixels go: its upper left pixel; rows are `row_pixels` apart.
struct TileTarget {
  float* rgba;
  float* distance;
  std::size_t row_pixels;
};

/// A tiled file of channels A, B, G, R and depth.Z. Thread-safe.
class TileFileReader {
 public:
  /// NotFound where there is no such file; InvalidArgument, with its name, for another kind of file.
  static absl::StatusOr<std::unique_ptr<TileFileReader>> open(const std::string& path);
  ~TileFileReader();
  TileFileReader(const TileFileReader&) = delete;
  TileFileReader& operator=(const TileFileReader&) = delete;

  std::string_view bytes() const { return {bytes_, size_}; }
  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }

  /// Where the packed bytes of all tiles are, with their hashes, row by row. InvalidArgument for a file whose
  /// table of tiles is broken.
  absl::StatusOr<std::vector<Tile>> tiles() const;
  /// Decodes one tile. InvalidArgument for bytes that are none of a tile.
  absl::Status read(std::uint32_t column, std::uint32_t row, const TileTarget& target) const;

 private:
  TileFileReader(std::string path, const char* bytes, std::size_t size);
  absl::Status read_header();
  absl::Status broken(const std::string& what) const;
  bool read_lossy(std::uint32_t column, std::uint32_t row, const TileTarget& target) const;
  static std::int64_t read_bytes(exr_const_context_t, void* self, void* to, std::uint64_t size,
                                 std::uint64_t offset, exr_stream_error_func_ptr_t);
  static std::int64_t size_of(exr_const_context_t, void* self);

  const std::string path_;
  const char* const bytes_;
  const std::size_t size_;
  exr_context_t context_ = nullptr;
  std::uint32_t width_ = 0, height_ = 0, tile_size_ = 0;
  bool lossy_ = false;  // DWA, which OpenEXRCore 3.1 does not unpack soundly
};

}  // namespace tessera::light_field
