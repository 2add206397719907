// The colours of a picture of which results come in.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "image/image.h"
#include "wire/tile_result.h"

namespace tessera::client {

/// Means of the samples so far, in `columns` x `rows` cells that the crop is cut into.
class GrowingImage {
 public:
  GrowingImage(const Window& crop, std::int32_t columns, std::int32_t rows);

  /// Returns the cells that changed. InvalidArgument for a result without the channels R, G, B in front, or
  /// beyond the crop.
  absl::StatusOr<Window> add(const wire::TileResult& result);
  void clear();

  std::int32_t columns() const { return columns_; }
  std::int32_t rows() const { return rows_; }
  /// Linear Rec.709; nothing where there are no samples.
  std::optional<std::array<float, 3>> color(std::int32_t column, std::int32_t row) const;

 private:
  std::int32_t column_of(std::int32_t x) const;
  std::int32_t row_of(std::int32_t y) const;

  Window crop_;
  std::int32_t columns_, rows_;
  std::vector<std::array<float, 4>> sums_;  // R, G, B, samples
};

}  // namespace tessera::client
