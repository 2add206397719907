// A tile whose samples go into all pixels whose filters reach them.
//
// The samples of one number lie at the same place in all pixels. So each pixel's filter has the same weights
// for the samples of the pixels around it, and the tile is a convolution. A leaf of a pixel's sum tree is the
// weighted sum over the samples of one number: an unbiased estimate of the pixel, as a sample that belongs to
// one pixel is. Where the filter's copies, a pixel apart, add up to 1 everywhere, as tents and Mitchell's of
// whole radii do, the weights do so too, and what is even stays even.
//
// Where pixels take different numbers of samples, those of one number make a picture of their own, black
// elsewhere, and a pixel is the sum of the pictures' means [docs/decisions/0060-noise-phase.md].
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
#include "render/film/sample_counts.h"
#include "render/film/tile_accumulator.h"
#include "wire/tile_result.h"

namespace tessera::render {

/// Pixels on each side of a pixel whose samples its filter may reach.
std::uint32_t filter_reach(const FilterAxis& axis);

class ScatterTile final : public SampleSource, public Film {
 public:
  /// `result` has its rectangle, sample range and channels set; counts and values are filled in when all
  /// samples have come. `seed` decides where in pixels samples lie. With `counts`, which outlive the tile,
  /// pixels take the first samples of the range, which begins at 0, as many as these say; else all of them.
  ScatterTile(wire::TileResult& result, const PixelFilterRecord& filter, std::uint64_t seed,
              const SampleCounts* counts = nullptr, PixelGroup group = {}, FilmSize film = {});

  std::size_t next(std::span<SampleName> names) override;
  const CommonPlaces* places() const override { return &common_; }
  PixelGroup group() const override { return group_pixels_; }
  FilmRect rect() const override;
  void add(std::span<const SampleName> names, const float* planes, std::size_t stride) override;
  void splat(std::span<const Splat> splats) override;

 private:
  /// Samples of a pixel that go into one batch, at most: of few pixels, more of them fill it.
  static constexpr std::uint32_t kTogether = 4, kMostTogether = 16;

  /// A rectangle of pixels of the tile and its border that take the same number of samples.
  struct Run {
    std::uint32_t x, y, width, height;
    std::size_t first;  // of its pixels, rows from the top, among those of its group
  };
  /// All that take this number.
  struct Group {
    std::uint32_t samples = 0;
    std::vector<Run> runs;  // rows from the top
    std::size_t size = 0;   // pixels
  };

  void add_run(Group& group, std::uint32_t x, std::uint32_t y, std::uint32_t width, std::uint32_t height);
  void group_blocks(const SampleCounts& counts);
  void begin_group();
  void order_pixels(const std::vector<std::uint32_t>& number_of);
  void end_group();
  /// For batches of that size.
  void begin_samples(std::size_t batch);
  void end_samples();
  /// Pixels of the tile that the run's samples reach, as a rectangle of the tile.
  FilmRect reached_by(const Run& run) const;
  /// Adds the run's samples, filtered, to a plane of the tile.
  void filter_run(const Run& run, const float* from, float* to);
  void copy_own(const Run& run, const float* from, float* to) const;

  wire::TileResult& result_;
  const PixelFilterRecord& filter_;
  const std::uint64_t seed_;
  const SampleCounts* const counts_;
  const PixelGroup group_pixels_;
  const FilmSize film_;
  const std::uint32_t reach_x_, reach_y_;
  const std::uint32_t width_, height_;  // of the tile and its border
  std::vector<std::uint32_t> firsts_;   // planes of which a pixel's own sample counts alone
  const std::size_t channels_;          // that come with samples
  std::vector<Group> groups_;           // by their samples
  // Of the group at hand
  wire::TileResult part_;  // its picture
  TileAccumulator sums_;
  std::size_t group_ = 0;
  std::vector<std::uint32_t> order_;    // its pixels along a Z-order curve, as numbers within the group
  std::vector<SampleName> places_;      // of the film, in that order
  std::vector<std::uint32_t> reached_;  // pixels of the tile
  std::uint32_t next_sample_ = 0, together_ = 0;
  std::size_t next_pixel_ = 0, count_ = 0;      // in order_; of the latest batch
  std::array<float, kMostTogether> x_{}, y_{};  // places of the samples at hand
  CommonPlaces common_{};
  std::vector<float> samples_;  // channel c of sample s of pixel i at (s * channels_ + c) * order_.size() + i
  std::vector<float> filtered_;  // planes of the tile
  std::vector<float> leaf_;      // the same of the pixels that are reached alone
  std::vector<float> padded_, row_;
  std::vector<float> weights_x_, weights_y_;
};

}  // namespace tessera::render
