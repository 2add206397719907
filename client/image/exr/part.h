// The contents of a part of a file, decided before anything is written.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "image/exr.h"

namespace tessera::client {

struct PartChannel {
  std::string name;       // name in the file
  std::size_t plane = 0;  // plane of the image
  bool half = false;
  bool averages = true;  // mip levels have means; else they take one of the numbers

  std::size_t bytes() const { return half ? 2 : 4; }
};

struct ExrPart {
  std::string name;                   // empty: the only one
  std::vector<PartChannel> channels;  // sorted by name, as in the file
  ExrCompression compression = ExrCompression::kZip;
  float dwa_level = 45;

  /// The bytes of a pixel.
  std::size_t bytes() const;
};

/// The parts, the picture first. InvalidArgument where names clash, or Cryptomatte would be compressed with
/// loss.
absl::StatusOr<std::vector<ExrPart>> parts_of(const Image& image, const ExrFormat& format);

}  // namespace tessera::client
