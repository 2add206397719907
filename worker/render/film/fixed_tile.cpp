#include "render/film/fixed_tile.h"

#include <algorithm>
#include <cassert>

#include "render/film/pixel_order.h"

namespace tessera::render {

namespace {

/// Samples of a pixel that go into one batch, at least, where there are as many.
constexpr std::uint32_t kTogether = 4;

}  // namespace

FixedTile::FixedTile(wire::TileResult& result, const SampleCounts* counts) : result_(result), sums_(result) {
  const std::uint32_t width = rect().width(), all = result.sample_end - result.sample_begin;
  const auto samples_of = [&](std::uint32_t pixel) {
    return counts == nullptr
               ? all
               : std::min(all, counts->at(result.x0 + pixel % width, result.y0 + pixel / width));
  };
  pixel_order_ = z_order(width, result.y1 - result.y0);
  if (counts != nullptr) std::ranges::stable_sort(pixel_order_, {}, samples_of);
  for (std::size_t i = 0; i < pixel_order_.size(); ++i) {
    const std::uint32_t samples = samples_of(pixel_order_[i]);
    if (remaining_groups_.empty() || remaining_groups_.back().samples != samples)
      remaining_groups_.push_back({0, samples});
    remaining_groups_.back().end = i + 1;
  }
  std::ranges::reverse(remaining_groups_);
}

std::size_t FixedTile::next(std::span<SampleName> names) {
  if (count_ == 0 || taken_ == remaining_groups_.back().samples) {
    if (count_ > 0) sums_.end_pixels();
    first_ += count_;
    count_ = 0;
    if (!remaining_groups_.empty() && first_ == remaining_groups_.back().end) remaining_groups_.pop_back();
    if (remaining_groups_.empty()) return 0;
    const std::size_t usual = names.size() / std::min(remaining_groups_.back().samples, kTogether);
    count_ = std::min(std::max(usual, std::size_t{1}), remaining_groups_.back().end - first_);
    taken_ = 0;
    sums_.begin_pixels(std::span(pixel_order_).subspan(first_, count_));
  }
  const auto fit = static_cast<std::uint32_t>(names.size() / count_);
  const std::uint32_t end = taken_ + std::min(fit, remaining_groups_.back().samples - taken_);
  SampleName* name = names.data();
  for (; taken_ < end; ++taken_) {
    for (const std::uint32_t pixel : std::span(pixel_order_).subspan(first_, count_)) {
      *name++ = {result_.x0 + pixel % rect().width(), result_.y0 + pixel / rect().width(),
                 result_.sample_begin + taken_, 0};
    }
  }
  return static_cast<std::size_t>(name - names.data());
}

FilmRect FixedTile::rect() const { return {result_.x0, result_.y0, result_.x1, result_.y1}; }

void FixedTile::add(std::span<const SampleName> names, const float* planes, std::size_t stride) {
  for (std::size_t i = 0; i < names.size(); i += count_) sums_.add_sample(planes + i, stride);
}

void FixedTile::splat(std::span<const Splat>) { assert(!"only passes take light that lands anywhere"); }

}  // namespace tessera::render
