// The image that errors are measured against.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "image/image.h"

namespace tessera::client {

struct BenchVariant;

/// The error of the reference itself, which adds to that of every image measured against it; 0: not known.
struct ReferenceNoise {
  double mse = 0, relmse = 0;
  double relmse_block = 0;  // relMSE of means over blocks of BenchPlan::block
};

struct BenchReference {
  Image image;
  ReferenceNoise noise;
  std::string source;  // a file, or how it was made; for people
};

/// Reads a reference. Its noise is known when it was written by write_reference, that of blocks where it was
/// with the same side. Errors as read_exr.
absl::StatusOr<BenchReference> read_reference(const std::string& path, int block);

/// Renders one of `spp` samples a pixel as the mean of two halves with seeds of their own, which no measured
/// image has; their difference tells the noise. No side of the image is less than `block`.
absl::StatusOr<BenchReference> make_reference(const BenchVariant& variant, std::uint32_t spp, int threads,
                                              int block, std::stop_token stop);

/// An EXR with the noise as attributes "tessera.reference_mse", "tessera.reference_relmse" and, for blocks of
/// 8, "tessera.reference_relmse_8x8".
absl::Status write_reference(const BenchReference& reference, int block, const std::string& path);

}  // namespace tessera::client
