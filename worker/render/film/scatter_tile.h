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
//
// Where neighbours share light, groups are others for each sample number, and are asked for whole. Samples of
// pixels that share may also stay in their pixels: the tile has no filter then, and no border.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "render/film/film.h"
#include "render/film/pixel_filter.h"
#include "render/film/pixel_order.h"
#include "render/film/sample_counts.h"
#include "render/film/tile_accumulator.h"
#include "wire/tile_result.h"

namespace tessera::render {

/// Pixels on each side of a pixel whose samples its filter may reach.
std::uint32_t filter_reach(const FilterAxis& axis);

class ScatterTile final : public SampleSource, public Film {
 public:
  /// `result` has its rectangle, sample range and channels set; counts and values are filled in when all
  /// samples have come. `filter` outlives the tile; null: samples stay in their pixels, and lie there as the
  /// integrator has it. `seed` decides where in pixels samples lie, and which pixels are one group. With
  /// `counts`, which outlive the tile, pixels take the first samples of the range, which begins at 0, as many
  /// as these say; else all of them.
  ScatterTile(wire::TileResult& result, const PixelFilterRecord* filter, std::uint64_t seed,
              const SampleCounts* counts = nullptr, PixelGroup group = {}, FilmSize film = {});

  std::size_t next(std::span<SampleName> names) override;
  const CommonPlaces* places() const override { return filter_ == nullptr ? nullptr : &common_; }
  PixelGroup group() const override { return group_; }
  FilmRect rect() const override;
  void add(std::span<const SampleName> names, const float* planes, std::size_t stride) override;
  void splat(std::span<const Splat> splats) override;

 private:
  /// Samples of a pixel that go into one batch, at most: of few pixels, more of them fill it.
  static constexpr std::uint32_t kTogether = 4, kMostTogether = 16;
  /// In place of a pixel's number: it takes no more samples, or is beyond the tile and its border.
  static constexpr std::uint32_t kNone = ~0u;

  /// A rectangle of pixels of the tile and its border that take the same number of samples. Pixels have
  /// numbers: rows from the top, one run after the other.
  struct Run {
    std::uint32_t x, y, width, height;
    std::size_t first = 0;  // number
  };
  /// All pixels that take this number of samples, and their picture.
  struct Part {
    Part(const wire::TileResult& result, std::uint32_t count);

    std::uint32_t samples;
    std::vector<Run> runs;               // rows from the top
    std::vector<std::uint32_t> reached;  // pixels of the tile
    wire::TileResult picture;
    TileAccumulator picture_sums;
  };

  void part_blocks(const SampleCounts& counts);
  void begin_part(Part& part);
  void end_part(const Part& part);
  /// For batches of that size.
  void begin_samples(std::size_t batch);
  std::vector<SampleName> pixels_of_sample(std::uint32_t sample) const;
  void end_samples();
  void add_samples(Part& part);
  std::uint32_t number_at(std::uint32_t x, std::uint32_t y) const;
  /// Pixels of the tile that the run's samples reach, as a rectangle of the tile.
  FilmRect reached_by(const Run& run) const;
  /// Adds the run's samples, filtered, to a plane of the tile.
  void filter_run(const Run& run, const float* from, float* to);
  void copy_own(const Run& run, const float* from, float* to) const;

  wire::TileResult& result_;
  const PixelFilterRecord* const filter_;
  const std::uint64_t seed_;
  const SampleCounts* const counts_;
  const PixelGroup group_;
  const FilmSize film_;
  const std::uint32_t reach_x_, reach_y_;
  const std::uint32_t width_, height_;  // size of the tile with its border
  const std::uint32_t left_, top_;      // first pixel of the tile, modulo 2^32
  std::vector<std::uint32_t> firsts_;   // planes of which a pixel's own sample counts alone
  const std::size_t sample_channels_;
  std::deque<Part> unfinished_parts_;         // the one with the fewest samples last
  std::vector<std::uint32_t> pixel_numbers_;  // rows of the tile with its border; or kNone
  std::uint32_t next_sample_ = 0, together_ = 0;
  // Pixels of the film for each of the samples at hand; where groups have one pixel, all have those of [0]
  std::array<std::vector<SampleName>, kMostTogether> pixels_;
  std::size_t next_pixel_ = 0;                  // index in each of pixels_
  std::array<float, kMostTogether> x_{}, y_{};  // places of the samples at hand
  CommonPlaces common_{};
  // Channel c of sample s of pixel i at (s * sample_channels_ + c) * pixel_numbers_.size() + i
  std::vector<float> samples_;
  std::vector<float> filtered_;  // planes of the tile
  std::vector<float> leaf_;      // the same sums of the pixels that a part reaches alone
  std::vector<float> padded_, row_;
  std::vector<float> weights_x_, weights_y_;
  std::vector<std::uint32_t> batch_;  // numbers of its pixels
};

}  // namespace tessera::render
