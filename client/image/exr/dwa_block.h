// Compression of blocks by OpenEXR's DWA, which OpenEXRCore 3.1 reads and does not write.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "image/exr/part.h"

namespace tessera::client {

class DwaBlockPacker {
 public:
  explicit DwaBlockPacker(const ExrPart& part) : part_(part) {}

  /// Bytes, as they stand in the file, of a block of rows from the top, in each all channels in order: those
  /// that OpenEXR's C++ library writes for the only tile of a file. Valid until the next call. Throws
  /// WriteError.
  std::span<const unsigned char> pack(std::span<const unsigned char> block, std::int32_t width,
                                      std::int32_t height);

 private:
  const ExrPart& part_;
  std::vector<unsigned char> packed_;
};

}  // namespace tessera::client
