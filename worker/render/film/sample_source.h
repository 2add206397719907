// Samples that are asked for one by one, instead of the same number for every pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera::render {

/// One sample of the film.
struct SampleName {
  std::uint32_t x, y;    // pixel of the film
  std::uint32_t index;   // in its sequence
  std::uint32_t stream;  // which of the pixel's sequences; they are independent, and 0 is the one of a TileRequest
};

/// Says what is to be sampled next, and takes the samples.
class SampleSource {
 public:
  virtual ~SampleSource() = default;
  /// Fills `names` from the front; returns how many samples are wanted next, 0 when nothing more is.
  virtual std::size_t next(std::span<SampleName> names) = 0;
  /// Those samples, in that order: channel c of sample i is planes[c * stride + i], the channels being those of kSum,
  /// in their order.
  virtual void add(const float* planes, std::size_t stride) = 0;
};

}  // namespace tessera::render
