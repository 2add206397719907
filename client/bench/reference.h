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
};

struct BenchReference {
  Image image;
  ReferenceNoise noise;
  std::string source;  // for people: a file, or how it was made
};

/// Reads a reference. Its noise is known when it was written by write_reference. Errors as read_exr.
absl::StatusOr<BenchReference> read_reference(const std::string& path);

/// Renders one of `spp` samples a pixel as the mean of two halves with seeds of their own, which no measured
/// image has; their difference tells the noise.
absl::StatusOr<BenchReference> make_reference(const BenchVariant& variant, std::uint32_t spp, int threads,
                                              std::stop_token stop);

/// An EXR with the noise as attributes "tessera.reference_mse" and "tessera.reference_relmse".
absl::Status write_reference(const BenchReference& reference, const std::string& path);

}  // namespace tessera::client
