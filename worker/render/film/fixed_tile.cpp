#include "render/film/fixed_tile.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <iterator>

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

FixedTile::FixedTile(wire::TileResult& result, const SampleCounts* counts, PixelGroup group)
    : result_(result),
      group_pixels_(group),
      channels_(static_cast<std::size_t>(
          std::ranges::count_if(result.channels, &wire::is_sampled, &wire::ChannelDesc::kind))),
      sums_(result) {
  // Whole groups. Of a Z-order curve from one of their corners on, each is a part.
  const std::uint32_t width = rect().width(), height = result.y1 - result.y0;
  const std::uint32_t pad_x = result.x0 % group.width, pad_y = result.y0 % group.height;
  const auto whole = [](std::uint32_t pixels, std::uint32_t side) {
    return (pixels + side - 1) / side * side;
  };
  const std::uint32_t stride = whole(pad_x + width, group.width);
  std::vector<std::uint32_t> order = z_order(stride, whole(pad_y + height, group.height));
  const std::uint32_t all = result.sample_end - result.sample_begin;
  const auto place_of = [&](std::uint32_t i) {
    return SampleName{result.x0 - pad_x + i % stride, result.y0 - pad_y + i / stride, 0, 0};
  };
  const auto samples_of = [&](std::uint32_t i) {
    const SampleName place = place_of(i);
    return counts == nullptr ? all : std::min(all, counts->at(place.x, place.y));
  };
  if (counts != nullptr) std::ranges::stable_sort(order, {}, samples_of);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const SampleName place = place_of(order[i]);
    const std::uint32_t samples = samples_of(order[i]);
    const bool own =
        place.x >= result.x0 && place.x < result.x1 && place.y >= result.y0 && place.y < result.y1;
    order_.push_back(own ? (place.y - result.y0) * width + (place.x - result.x0) : kBeyond);
    places_.push_back(place);
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
    const auto whole = static_cast<std::size_t>(group_pixels_.count());
    const std::size_t usual = names.size() / std::min(groups_.back().samples, kTogether);
    count_ = std::min(std::max(usual / whole, std::size_t{1}) * whole, groups_.back().end - first_);
    taken_ = 0;
    own_.clear();
    std::ranges::copy_if(std::span(order_).subspan(first_, count_), std::back_inserter(own_),
                         [](std::uint32_t pixel) { return pixel != kBeyond; });
    sums_.begin_pixels(own_);
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
  for (std::size_t i = 0; i < names.size(); i += count_) {
    if (own_.size() == count_) {
      sums_.add_sample(planes + i, stride);
      continue;
    }
    planes_.clear();
    for (std::size_t c = 0; c < channels_; ++c) {
      for (std::size_t k = 0; k < count_; ++k) {
        if (order_[first_ + k] != kBeyond) planes_.push_back(planes[c * stride + i + k]);
      }
    }
    sums_.add_sample(planes_.data(), own_.size());
  }
}

void FixedTile::splat(std::span<const Splat>) { assert(!"only passes take light that lands anywhere"); }

}  // namespace tessera::render
