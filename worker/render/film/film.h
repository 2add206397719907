// Where light goes that an integrator found.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "render/film/sample_source.h"

namespace tessera::render {

/// Pixels [x0, x1) x [y0, y1) of the film.
struct FilmRect {
  std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  std::uint32_t width() const { return x1 - x0; }
  std::size_t pixel_count() const { return std::size_t{width()} * (y1 - y0); }
};

/// Light that lands at a place of the film, in pixels from its upper left corner.
struct Splat {
  float x, y;
  float value[3];
  std::uint32_t layers = 0;  // bits of those that it belongs to
  bool in_picture = true;    // false: in its layers alone
};

/// Radiance of one band of the film's that lands there.
struct BandSplat {
  float x, y;
  float value;
  std::int32_t band;
};

class Film {
 public:
  virtual ~Film() = default;

  /// The pixels that light is gathered for.
  virtual FilmRect rect() const = 0;

  /// The samples of the latest SampleSource::next(), in its order: channel c of sample i is planes[c * stride
  /// + i], the channels being those that samples have (wire::is_sampled), in their order.
  virtual void add(std::span<const SampleName> names, const float* planes, std::size_t stride) = 0;

  /// Adds light to all pixels whose filters reach it. Only for algorithms that work in passes: each pass is
  /// one sample of every pixel.
  virtual void splat(std::span<const Splat> splats) = 0;
  /// The same for films with bands.
  virtual void splat_bands(std::span<const BandSplat>) {}
};

}  // namespace tessera::render
