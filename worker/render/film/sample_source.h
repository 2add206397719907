// Which samples are to be taken: the only way in which work comes to an integrator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera::render {

/// Stream of pixels that nobody samples: they fill up groups at the edge of what counts.
inline constexpr std::uint32_t kUnsampled = ~0u;

/// One sample of the film.
struct SampleName {
  std::uint32_t x, y;    // pixel of the film; modulo 2^32, of a border around it
  std::uint32_t index;   // place in its sequence
  std::uint32_t stream;  // one of the pixel's sequences, which are independent; 0 is the one of a
                         // TileRequest. kUnsampled: none
};

/// Pixels of the whole film, whatever is rendered of it.
struct FilmSize {
  std::uint32_t width = 1u << 31, height = 1u << 31;

  /// Whether a pixel is of the film, or of the border around it with as many pixels on each side.
  bool reaches(std::uint32_t x, std::uint32_t y, std::uint32_t border_x, std::uint32_t border_y) const {
    return x + border_x < width + 2 * border_x && y + border_y < height + 2 * border_y;
  }
};

/// Places of samples within their pixels, in pixels from the upper left corner: those of sample `first + i`
/// at [i], the same in all pixels.
struct CommonPlaces {
  std::uint32_t first;
  const float *x, *y;
};

/// A group of pixels: one of each place in blocks of `width` x `height` pixels, from any of the step x step
/// blocks of a cell, which as many groups fill (pixel_order.h). Sizes of cells divide wire::kNoiseBlock.
/// Members whose pixel is beyond the film, and beyond the border that filters reach, are not sampled.
struct PixelGroup {
  std::uint32_t width = 1, height = 1, step = 1;

  int count() const { return static_cast<int>(width * height); }
};

/// Says what is to be sampled next.
class SampleSource {
 public:
  virtual ~SampleSource() = default;
  /// Fills `names` from the front; returns how many samples are wanted next, 0 when nothing more is. All
  /// samples of the call before have been given to the film.
  virtual std::size_t next(std::span<SampleName> names) = 0;
  /// Where samples of the latest next() lie; null: about their pixels as the filter is distributed.
  virtual const CommonPlaces* places() const { return nullptr; }
  /// All samples come in such groups of neighbours, one after the other.
  virtual PixelGroup group() const { return {}; }
  /// The pass that all these samples belong to, where work is done in passes (wire::WorkKind).
  virtual std::uint32_t pass() const { return 0; }
};

}  // namespace tessera::render
