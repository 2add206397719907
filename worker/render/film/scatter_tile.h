// A tile whose samples go into all pixels whose filters reach them.
//
// The samples of one number lie at the same place in all pixels. So each pixel's filter has the same weights
// for the samples of the pixels around it, and the tile is a convolution. A leaf of a pixel's sum tree is the
// weighted sum over the samples of one number: an unbiased estimate of the pixel, as a sample that belongs to
// one pixel is. Where the filter's copies, a pixel apart, add up to 1 everywhere, as tents and Mitchell's of
// whole radii do, the weights do so too, and what is even stays even.
//
// The tile samples a border of pixels around it as well, whatever is beyond: other tiles, nothing that is
// asked for, or no film at all. Their samples are computed twice, and nothing has to be merged between tiles:
// results are those of any tile, and the bits those of any cut [docs/decisions/0046-pixel-reconstruction.md].
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/film/film.h"
#include "render/film/pixel_filter.h"
#include "render/film/tile_accumulator.h"
#include "wire/tile_result.h"

namespace tessera::render {

/// Pixels on each side of a pixel whose samples its filter may reach.
std::uint32_t filter_reach(const FilterAxis& axis);

class ScatterTile final : public SampleSource, public Film {
 public:
  /// `result` has its rectangle, sample range and channels set; counts and values are filled in when all
  /// samples have come. `seed` decides where in pixels samples lie.
  ScatterTile(wire::TileResult& result, const PixelFilterRecord& filter, std::uint64_t seed);

  std::size_t next(std::span<SampleName> names) override;
  const CommonPlaces* places() const override { return &common_; }
  FilmRect rect() const override;
  void add(std::span<const SampleName> names, const float* planes, std::size_t stride) override;
  void splat(std::span<const Splat> splats) override;

 private:
  /// Samples of a pixel that go into one batch, at most.
  static constexpr std::uint32_t kTogether = 4;

  bool begin_samples();
  void end_samples();
  /// Channel `from` of the border's rectangle, filtered, as that of the tile.
  void filter_plane(const float* from, float* to);

  const wire::TileResult& result_;
  const PixelFilterRecord& filter_;
  TileAccumulator sums_;
  const std::uint64_t seed_;
  const std::uint32_t reach_x_, reach_y_;
  const std::uint32_t width_, height_;      // of the tile and its border
  const std::vector<std::uint32_t> order_;  // of their pixels
  std::vector<std::uint32_t> tile_;         // pixels of the tile, rows from the top
  std::vector<std::uint32_t> firsts_;       // planes of which a pixel's own sample counts alone
  const std::size_t channels_;              // that come with samples
  // Of the samples at hand
  std::uint32_t next_sample_, together_ = 0;
  std::size_t next_pixel_ = 0, count_ = 0;  // in order_; of the latest batch
  std::array<float, kTogether> x_{}, y_{};  // places
  CommonPlaces common_{};
  std::vector<float> samples_;  // channel c of sample s of pixel i at (s * channels_ + c) * pixels + i
  std::vector<float> rows_, filtered_;
  std::vector<float> weights_x_, weights_y_;
};

}  // namespace tessera::render
