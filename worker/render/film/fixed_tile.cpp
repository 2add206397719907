#include "render/film/fixed_tile.h"

#include <algorithm>
#include <bit>
#include <cassert>

namespace tessera::render {

namespace {

/// Samples of a pixel that go into one batch, at least, where there are as many.
constexpr std::uint32_t kTogether = 4;

}  // namespace

std::vector<std::uint32_t> z_order(std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint32_t> order;
  order.reserve(std::size_t{width} * height);
  const std::uint32_t side = std::bit_ceil(std::max({width, height, 1u}));
  const auto every_second_bit = [](std::uint64_t code) {
    code &= 0x5555555555555555;
    code = (code | code >> 1) & 0x3333333333333333;
    code = (code | code >> 2) & 0x0f0f0f0f0f0f0f0f;
    code = (code | code >> 4) & 0x00ff00ff00ff00ff;
    code = (code | code >> 8) & 0x0000ffff0000ffff;
    return static_cast<std::uint32_t>(code | code >> 16);
  };
  for (std::uint64_t code = 0; code < std::uint64_t{side} * side; ++code) {
    const std::uint32_t x = every_second_bit(code), y = every_second_bit(code >> 1);
    if (x < width && y < height) order.push_back(y * width + x);
  }
  return order;
}

FixedTile::FixedTile(wire::TileResult& result, const SampleCounts* counts)
    : result_(result), sums_(result), order_(z_order(result.x1 - result.x0, result.y1 - result.y0)) {
  const std::uint32_t width = rect().width(), all = result.sample_end - result.sample_begin;
  const auto samples_of = [&](std::uint32_t pixel) {
    return counts == nullptr
               ? all
               : std::min(all, counts->at(result.x0 + pixel % width, result.y0 + pixel / width));
  };
  if (counts != nullptr) std::ranges::stable_sort(order_, {}, samples_of);
  places_.reserve(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const std::uint32_t pixel = order_[i], samples = samples_of(pixel);
    places_.push_back({result.x0 + pixel % width, result.y0 + pixel / width, 0, 0});
    if (groups_.empty() || groups_.back().samples != samples) groups_.push_back({i, samples});
    groups_.back().end = i + 1;
  }
  std::ranges::reverse(groups_);
}

std::size_t FixedTile::next(std::span<SampleName> names) {
  if (count_ == 0 || taken_ == groups_.back().samples) {
    if (count_ > 0) sums_.end_pixels();
    first_ += count_;
    count_ = 0;
    if (!groups_.empty() && first_ == groups_.back().end) groups_.pop_back();
    if (groups_.empty()) return 0;
    count_ =
        std::min(names.size() / std::min(groups_.back().samples, kTogether), groups_.back().end - first_);
    taken_ = 0;
    sums_.begin_pixels(std::span(order_).subspan(first_, count_));
  }
  const auto fit = static_cast<std::uint32_t>(names.size() / count_);
  const std::uint32_t end = taken_ + std::min(fit, groups_.back().samples - taken_);
  SampleName* name = names.data();
  for (; taken_ < end; ++taken_) {
    for (const SampleName& place : std::span(places_).subspan(first_, count_)) {
      *name++ = {place.x, place.y, result_.sample_begin + taken_, 0};
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
