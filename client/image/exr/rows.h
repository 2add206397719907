// Where a writer takes pixels from: an image in memory, or one that is kept elsewhere.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "image/exr.h"

namespace tessera::client {

class Rows {
 public:
  virtual ~Rows() = default;
  /// Row `y` of the data window, from its top, of plane `plane`: as many values as it is wide. Rows are asked
  /// for from the top, and again for each part.
  virtual absl::Status read(std::size_t plane, std::int32_t y, std::span<float> row) = 0;
};

/// write_exr() of an image whose planes have names, but no values: those are `rows`.
absl::Status write_exr(const Image& image, Rows& rows, const std::string& path, const ExrFormat& format);

}  // namespace tessera::client
