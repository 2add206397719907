// Sums the samples of a tile along the fixed binary tree of DESIGN "the same image everywhere"
// (docs/architecture.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "wire/tile_result.h"

namespace tessera::render {

class TileAccumulator {
 public:
  /// `result` has its rectangle, sample range and channels set; the accumulator fills in counts and values.
  explicit TileAccumulator(wire::TileResult& result);

  /// Indices into the tile's pixels, rows from the top; they outlive the calls of add_sample() and
  /// end_pixels() that follow.
  void begin_pixels(std::span<const std::uint32_t> pixels);
  /// The next sample, in order of its index, of every one of those pixels: channel c of pixel i is planes[c *
  /// stride + i], the channels being those that samples have, in their order.
  void add_sample(const float* planes, std::size_t stride);
  void end_pixels();

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
