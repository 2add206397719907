#include "render/film/tile_accumulator.h"

#include <algorithm>
#include <bit>

namespace tessera::render {

TileAccumulator::TileAccumulator(wire::TileResult& result) : result_(result) {
  result_.counts.assign(result_.pixel_count(), 0);
  result_.values.assign(result_.channels.size() * result_.pixel_count(), 0.0f);
}

void TileAccumulator::begin_pixels(std::span<const std::uint32_t> pixels) {
  pixels_ = pixels;
  depth_ = 0;
  samples_ = 0;
}

void TileAccumulator::add_sample(const float* planes, std::size_t stride) {
  // A leaf on top of the stack ...
  if (depth_ == stack_.size()) stack_.emplace_back();
  Node& leaf = stack_[depth_++];
  leaf.counts.assign(pixels_.size(), 1);
  leaf.values.resize(result_.channels.size() * pixels_.size());
  std::size_t plane = 0;
  for (std::size_t c = 0; c < result_.channels.size(); ++c) {
    float* to = leaf.values.data() + c * pixels_.size();
    if (wire::is_sampled(result_.channels[c].kind)) {
      std::copy_n(planes + plane++ * stride, pixels_.size(), to);
    } else {
      std::fill_n(to, pixels_.size(), 0.0f);
    }
  }
  // ... which completes as many nodes as the sample count has trailing zeros.
  ++samples_;
  for (int i = std::countr_zero(samples_); i > 0; --i) merge_top();
}

void TileAccumulator::end_pixels() {
  while (depth_ > 1) merge_top();
  if (depth_ == 0) return;
  const Node& root = stack_[0];
  for (std::size_t i = 0; i < pixels_.size(); ++i) result_.counts[pixels_[i]] = root.counts[i];
  for (std::size_t c = 0; c < result_.channels.size(); ++c) {
    const float* from = root.values.data() + c * pixels_.size();
    float* to = result_.values.data() + c * result_.pixel_count();
    for (std::size_t i = 0; i < pixels_.size(); ++i) to[pixels_[i]] = from[i];
  }
}

void TileAccumulator::merge_top() {
  Node& left = stack_[depth_ - 2];
  const Node& right = stack_[depth_ - 1];
  wire::merge_pixel_nodes(result_.channels, pixels_.size(), left.counts.data(), left.values.data(),
                          pixels_.size(), right.counts.data(), right.values.data(), pixels_.size());
  --depth_;
}

}  // namespace tessera::render
