// Sums the samples of a tile along the fixed binary tree of DESIGN "the same image everywhere" (docs/architecture.md).
#pragma once

#include <vector>

#include "render/film/film_sink.h"
#include "wire/tile_result.h"

namespace tessera::render {

class TileAccumulator final : public FilmSink {
 public:
  /// `result` has its rectangle, sample range and channels set; the accumulator fills in counts and values.
  explicit TileAccumulator(wire::TileResult& result);

  void begin_pixels(std::span<const std::uint32_t> pixels) override;
  void add_sample(const float* planes, std::size_t stride) override;
  void end_pixels() override;

 private:
  /// Sums over 2^level samples (fewer at the end of the range) of the pixels at hand.
  struct Node {
    std::vector<std::uint32_t> counts;
    std::vector<float> values;  // channel-major
  };
  void merge_top();

  wire::TileResult& result_;
  std::span<const std::uint32_t> pixels_;
  std::vector<Node> stack_;  // the right-hand path of the tree, largest node first
  std::size_t depth_ = 0;    // nodes in use
  std::uint32_t samples_ = 0;
};

}  // namespace tessera::render
