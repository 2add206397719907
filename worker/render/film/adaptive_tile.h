// A tile whose pixels take as many samples as their noise asks for, without bias.
//
// The samples of a pixel are two halves with sequences of their own. What the first samples of one half (its
// pilot) saw, over a whole block of pixels, decides how many samples the OTHER half takes; the pixel is the
// plain mean of both halves' means. Each of those is over a number of samples that is independent of them, so
// nothing is biased, whatever a pilot saw. Deciding on what is summed up itself would be: where a bright path
// is rare, sampling would stop as long as none came.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "render/film/film.h"
#include "render/film/noise_target.h"
#include "wire/tile_result.h"

namespace tessera::render {

class AdaptiveTile final : public SampleSource, public Film {
 public:
  /// `result` has its rectangle, sample range and channels set; counts and values are filled in as blocks are
  /// finished. The film's size cuts the blocks at its border. Blocks that the rectangle cuts are judged as a
  /// whole, so that their pixels are the same in every rectangle.
  AdaptiveTile(wire::TileResult& result, std::uint32_t film_width, std::uint32_t film_height,
               const NoiseTarget& target);
  ~AdaptiveTile() override;

  std::size_t next(std::span<SampleName> names) override;
  FilmRect rect() const override;
  void add(std::span<const SampleName> names, const float* planes, std::size_t stride) override;
  void splat(std::span<const Splat> splats) override;

 private:
  struct Block;
  /// Samples [sample, end) of some pixels of a block, in one half; of the first of these samples, the pixels
  /// from `at` on.
  struct Run {
    Block* block;
    std::uint32_t half, sample, end;
    std::span<const std::uint32_t> pixels;
    std::size_t at = 0;
  };
  struct Given {
    Block* block;
    std::uint32_t half, pixel, sample;
  };

  void open_block();
  void want(Block& block, std::uint32_t half, std::uint32_t begin, std::uint32_t end,
            std::span<const std::uint32_t> pixels);
  void take(const Given& given, const float* sample, std::size_t stride);
  double pilot_error(const Block& block, std::uint32_t half) const;
  void decide(Block& block);
  void finish(Block& block);
  void put_pixel(const Block& block, std::size_t pixel);
  void put_lists(const Block& block, std::size_t pixel, std::size_t to);

  wire::TileResult& result_;
  const std::uint32_t film_width_, film_height_;
  const NoiseTarget target_;
  std::vector<std::size_t> plane_of_;  // of each channel: where its samples, or those it deviates from, are
  std::size_t planes_ = 0;             // channels that come with samples
  std::vector<std::size_t> summed_, firsts_;    // planes: sums; those of which a pixel's first sample counts
  std::vector<std::size_t> lists_;              // planes of identifiers; their weights follow
  std::uint32_t next_x_, next_y_;               // of the next block to open, in blocks
  std::deque<Run> runs_;                        // what is wanted now
  std::vector<Given> given_;                    // by the last call of next()
  std::vector<std::unique_ptr<Block>> blocks_;  // being sampled
};

}  // namespace tessera::render
