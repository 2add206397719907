#include "render/film/fixed_tile.h"

#include <algorithm>
#include <cassert>
#include <iterator>

#include "render/film/pixel_order.h"

namespace tessera::render {

namespace {

/// Samples of a pixel that go into one batch, at least, where there are as many.
constexpr std::uint32_t kTogether = 4;

}  // namespace

FixedTile::FixedTile(wire::TileResult& result, const SampleCounts* counts, PixelGroup group, FilmSize film)
    : result_(result),
      group_pixels_(group),
      channels_(static_cast<std::size_t>(
          std::ranges::count_if(result.channels, &wire::is_sampled, &wire::ChannelDesc::kind))),
      sums_(result) {
  const std::uint32_t width = rect().width(), height = result.y1 - result.y0;
  const std::uint32_t all = result.sample_end - result.sample_begin;
  const std::vector<PixelPlace> pixels = groups_in(result.x0, result.y0, width, height, group);
  // Pixels of a packet take the same number of samples.
  const auto samples_of = [&](std::size_t first) {
    return counts == nullptr
               ? all
               : std::min(all, counts->at(result.x0 + pixels[first].x, result.y0 + pixels[first].y));
  };
  const std::size_t size = packet_of(group);
  std::vector<std::size_t> firsts;
  for (std::size_t first = 0; first < pixels.size(); first += size) firsts.push_back(first);
  if (counts != nullptr) std::ranges::stable_sort(firsts, {}, samples_of);
  for (const std::size_t first : firsts) {
    for (const auto [x, y] : std::span(pixels).subspan(first, size)) {
      order_.push_back(x < width && y < height ? y * width + x : kBeyond);
      const std::uint32_t film_x = result.x0 + x, film_y = result.y0 + y;
      places_.push_back({film_x, film_y, 0, film.reaches(film_x, film_y, 0, 0) ? 0 : kUnsampled});
    }
    const std::uint32_t samples = samples_of(first);
    if (groups_.empty() || groups_.back().samples != samples) groups_.push_back({0, samples});
    groups_.back().end = order_.size();
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
    const std::size_t whole = packet_of(group_pixels_);
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
      *name++ = {place.x, place.y, result_.sample_begin + taken_, place.stream};
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
