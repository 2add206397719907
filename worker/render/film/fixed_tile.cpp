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

FixedTile::FixedTile(wire::TileResult& result)
    : result_(result),
      sums_(result),
      order_(z_order(result.x1 - result.x0, result.y1 - result.y0)),
      next_sample_(result.sample_begin) {
  places_.reserve(order_.size());
  const std::uint32_t width = rect().width();
  for (const std::uint32_t pixel : order_)
    places_.push_back({result.x0 + pixel % width, result.y0 + pixel / width, 0, 0});
}

std::size_t FixedTile::next(std::span<SampleName> names) {
  const std::uint32_t samples = result_.sample_end - result_.sample_begin;
  if (count_ == 0 || next_sample_ == result_.sample_end) {
    if (count_ > 0) sums_.end_pixels();
    first_ += count_;
    count_ = std::min(names.size() / std::min(samples, kTogether), order_.size() - first_);
    if (count_ == 0) return 0;
    next_sample_ = result_.sample_begin;
    sums_.begin_pixels(std::span(order_).subspan(first_, count_));
  }
  const auto fit = static_cast<std::uint32_t>(names.size() / count_);
  const std::uint32_t end = next_sample_ + std::min(fit, result_.sample_end - next_sample_);
  SampleName* name = names.data();
  for (; next_sample_ < end; ++next_sample_) {
    for (const SampleName& place : std::span(places_).subspan(first_, count_)) {
      *name++ = {place.x, place.y, next_sample_, 0};
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
