// All pixels of a unit, pass by pass: every pass is one sample of each of them, camera samples and splats
// together.
#pragma once

#include <cstdint>
#include <vector>

#include "render/film/film.h"
#include "render/film/pixel_filter.h"
#include "render/film/raster_edges.h"
#include "render/film/tile_accumulator.h"
#include "wire/tile_result.h"

namespace tessera::render {

class PassFilm final : public SampleSource, public Film {
 public:
  /// `result` has its rectangle, sample range and channels set, the last of which are those of the bands, one
  /// each, and of the layers, three each; counts and values are filled in by the last end_pass(). `edges` are
  /// those of the whole raster, whose size is `raster`.
  PassFilm(wire::TileResult& result, const PixelFilterRecord& filter, std::size_t layers = 0,
           std::size_t bands = 0, RasterEdges edges = RasterEdges::kOpen, FilmSize raster = {});

  /// Starts the next pass; false when there is none.
  bool begin_pass();
  /// The pass is complete.
  void end_pass();

  /// Every pixel of the rectangle once a pass.
  std::size_t next(std::span<SampleName> names) override;
  std::uint32_t pass() const override { return pass_; }
  FilmRect rect() const override;
  void add(std::span<const SampleName> names, const float* planes, std::size_t stride) override;
  void splat(std::span<const Splat> splats) override;
  void splat_bands(std::span<const BandSplat> splats) override;

 private:
  std::size_t pixel_at(std::uint32_t x, std::uint32_t y) const;
  /// Calls f(pixel, weight) for the pixels of the rectangle whose filters reach the place, or another that
  /// sees the same.
  template <class F>
  void for_each_reached(float x, float y, F&& f) const;
  /// The same of this place alone.
  template <class F>
  void for_each_around(float x, float y, F&& f) const;
  void add_splat(const Splat& splat);

  const wire::TileResult& result_;
  const PixelFilterRecord& filter_;
  const RasterEdges edges_;
  const FilmSize raster_;
  TileAccumulator sums_;
  const std::vector<std::uint32_t> pixel_order_;  // samples are asked for in this order
  std::vector<std::uint32_t> all_;                // pixels, rows from the top
  const std::size_t sample_channels_;
  const std::size_t first_layer_, first_band_;  // channels
  const std::size_t layer_channels_;
  const std::size_t half_;          // channel half.R, of samples in the first half; 0: not asked for
  std::vector<float> pass_planes_;  // channel c of pixel i at c * pixels + i
  // The same of the layers, channel k of pixel i at i * layer_channels_ + k: light lands on one pixel after
  // the other, and is of several of them.
  std::vector<float> layers_;
  std::size_t next_pixel_ = 0;  // index in pixel_order_
  std::uint32_t pass_ = 0, next_pass_;
};

}  // namespace tessera::render
