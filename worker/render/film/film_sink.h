// Where finished samples go.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera::render {

/// Takes the samples of a tile, some pixels at a time.
class FilmSink {
 public:
  virtual ~FilmSink() = default;
  /// Indices into the tile's pixels, rows from the top. add_sample and end_pixels follow.
  virtual void begin_pixels(std::span<const std::uint32_t> pixels) = 0;
  /// The next sample, in order of its index, of every one of those pixels: channel c of pixel i is planes[c * stride + i], the
  /// channels being those of kSum, in their order.
  virtual void add_sample(const float* planes, std::size_t stride) = 0;
  virtual void end_pixels() = 0;
};

}  // namespace tessera::render
