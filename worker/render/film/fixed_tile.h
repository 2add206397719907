// A tile whose pixels take samples of their own.
#pragma once

#include <cstdint>
#include <vector>

#include "render/film/film.h"
#include "render/film/sample_counts.h"
#include "render/film/tile_accumulator.h"
#include "wire/tile_result.h"

namespace tessera::render {

/// Asks for several samples of as many pixels as fit into a batch, the pixels along a Z-order curve, so that
/// those of a packet are neighbours. No order of batches changes a pixel: its samples are summed along a
/// fixed tree.
class FixedTile final : public SampleSource, public Film {
 public:
  /// `result` has its rectangle, sample range and channels set; counts and values are filled in as pixels are
  /// finished. With `counts`, which outlive the tile, pixels take the first samples of the range, as many as
  /// these say; else all of them.
  explicit FixedTile(wire::TileResult& result, const SampleCounts* counts = nullptr);

  std::size_t next(std::span<SampleName> names) override;
  FilmRect rect() const override;
  void add(std::span<const SampleName> names, const float* planes, std::size_t stride) override;
  void splat(std::span<const Splat> splats) override;

 private:
  const wire::TileResult& result_;
  TileAccumulator sums_;
  /// Pixels that take the same number of samples.
  struct Group {
    std::size_t end;  // index in pixel_order_ behind its last pixel
    std::uint32_t samples;
  };
  std::vector<std::uint32_t> pixel_order_;  // group by group
  std::vector<Group> remaining_groups_;     // the next one last
  std::size_t first_ = 0, count_ = 0;       // pixels at hand
  std::uint32_t taken_ = 0;                 // samples of each of these
};

}  // namespace tessera::render
