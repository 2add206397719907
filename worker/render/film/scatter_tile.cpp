#include "render/film/scatter_tile.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "base/split_mix.h"
#include "render/film/filter_value.h"
#include "render/film/fixed_tile.h"

namespace tessera::render {

namespace {

float to_unit(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

/// The first two dimensions of Sobol's sequence, a (0,2)-sequence: each is evenly spread by itself, too,
/// which edges along rows and columns need.
std::uint32_t van_der_corput(std::uint32_t index) {
  std::uint32_t bits = 0;
  for (std::uint32_t digit = 1u << 31; index != 0; index >>= 1, digit >>= 1) bits ^= index & 1 ? digit : 0;
  return bits;
}
std::uint32_t second_sobol(std::uint32_t index) {
  std::uint32_t bits = 0;
  for (std::uint32_t digit = 1u << 31; index != 0; index >>= 1, digit ^= digit >> 1)
    bits ^= index & 1 ? digit : 0;
  return bits;
}

/// The filter's weights of the samples of 2 * reach + 1 pixels in a row, which lie at `place` in theirs.
void weigh(FilterKind kind, const FilterAxis& axis, float place, std::vector<float>& weights) {
  const auto reach = static_cast<float>(weights.size() / 2);
  for (std::size_t k = 0; k < weights.size(); ++k)
    weights[k] = filter_value(kind, axis, static_cast<float>(k) - reach + (place - 0.5f));
}

}  // namespace

std::uint32_t filter_reach(const FilterAxis& axis) {
  return static_cast<std::uint32_t>(std::max(0.0f, std::ceil(axis.radius - 0.5f)));
}

ScatterTile::ScatterTile(wire::TileResult& result, const PixelFilterRecord& filter, std::uint64_t seed)
    : result_(result),
      filter_(filter),
      sums_(result),
      seed_(seed),
      reach_x_(filter_reach(filter.x)),
      reach_y_(filter_reach(filter.y)),
      width_(result.x1 - result.x0 + 2 * reach_x_),
      height_(result.y1 - result.y0 + 2 * reach_y_),
      order_(z_order(width_, height_)),
      tile_(result.pixel_count()),
      channels_(static_cast<std::size_t>(
          std::ranges::count_if(result.channels, &wire::is_sampled, &wire::ChannelDesc::kind))),
      next_sample_(result.sample_begin),
      rows_(std::size_t{result.x1 - result.x0} * height_),
      filtered_(channels_ * tile_.size()),
      weights_x_(2 * reach_x_ + 1),
      weights_y_(2 * reach_y_ + 1) {
  std::iota(tile_.begin(), tile_.end(), 0u);
  std::uint32_t plane = 0;
  for (const wire::ChannelDesc& channel : result.channels) {
    if (channel.kind == wire::ChannelKind::kFirst) firsts_.push_back(plane);
    plane += wire::is_sampled(channel.kind) ? 1 : 0;
  }
  sums_.begin_pixels(tile_);
}

bool ScatterTile::begin_samples() {
  if (next_sample_ == result_.sample_end) return false;
  together_ = std::min(kTogether, result_.sample_end - next_sample_);
  common_ = {next_sample_, x_.data(), y_.data()};
  // Random digits, the same in all points, make each of them evenly distributed [Kollig & Keller 2002].
  const std::uint64_t digits = base::split_mix(seed_);
  for (std::uint32_t s = 0; s < together_; ++s) {
    x_[s] = to_unit(van_der_corput(next_sample_ + s) ^ static_cast<std::uint32_t>(digits));
    y_[s] = to_unit(second_sobol(next_sample_ + s) ^ static_cast<std::uint32_t>(digits >> 32));
  }
  samples_.resize(together_ * channels_ * order_.size());
  return true;
}

std::size_t ScatterTile::next(std::span<SampleName> names) {
  if (next_pixel_ == order_.size()) end_samples();
  if (next_pixel_ == 0 && !begin_samples()) return 0;
  count_ = std::min(names.size() / together_, order_.size() - next_pixel_);
  SampleName* name = names.data();
  for (std::uint32_t s = 0; s < together_; ++s) {
    for (const std::uint32_t pixel : std::span(order_).subspan(next_pixel_, count_))
      *name++ = {result_.x0 - reach_x_ + pixel % width_, result_.y0 - reach_y_ + pixel / width_,
                 next_sample_ + s, 0};
  }
  next_pixel_ += count_;
  return static_cast<std::size_t>(name - names.data());
}

FilmRect ScatterTile::rect() const { return {result_.x0, result_.y0, result_.x1, result_.y1}; }

void ScatterTile::splat(std::span<const Splat>) { assert(!"only passes take light that lands anywhere"); }

void ScatterTile::add(std::span<const SampleName>, const float* planes, std::size_t stride) {
  const std::span<const std::uint32_t> pixels = std::span(order_).subspan(next_pixel_ - count_, count_);
  for (std::uint32_t s = 0; s < together_; ++s) {
    for (std::size_t c = 0; c < channels_; ++c) {
      float* const to = samples_.data() + (s * channels_ + c) * order_.size();
      const float* const from = planes + c * stride + s * count_;
      for (std::size_t i = 0; i < count_; ++i) to[pixels[i]] = from[i];
    }
  }
}

void ScatterTile::filter_plane(const float* from, float* to) {
  const std::size_t width = result_.x1 - result_.x0, height = result_.y1 - result_.y0;
  const auto add_weighted = [width](const float* row, float weight, float* sum) {
    for (std::size_t x = 0; x < width; ++x) sum[x] += weight * row[x];
  };
  std::ranges::fill(rows_, 0.0f);
  for (std::size_t y = 0; y < height_; ++y) {
    for (std::size_t k = 0; k < weights_x_.size(); ++k)
      add_weighted(from + y * width_ + k, weights_x_[k], rows_.data() + y * width);
  }
  std::fill_n(to, width * height, 0.0f);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t k = 0; k < weights_y_.size(); ++k)
      add_weighted(rows_.data() + (y + k) * width, weights_y_[k], to + y * width);
  }
}

void ScatterTile::end_samples() {
  const std::size_t width = result_.x1 - result_.x0;
  for (std::uint32_t s = 0; s < together_; ++s) {
    weigh(filter_.kind, filter_.x, x_[s], weights_x_);
    weigh(filter_.kind, filter_.y, y_[s], weights_y_);
    const float* const planes = samples_.data() + s * channels_ * order_.size();
    for (std::size_t c = 0; c < channels_; ++c)
      filter_plane(planes + c * order_.size(), filtered_.data() + c * tile_.size());
    // A number that has no mean is that of the pixel's own sample.
    for (const std::size_t c : firsts_) {
      for (std::size_t y = 0; y < result_.y1 - result_.y0; ++y)
        std::copy_n(planes + c * order_.size() + (y + reach_y_) * width_ + reach_x_, width,
                    filtered_.data() + c * tile_.size() + y * width);
    }
    sums_.add_sample(filtered_.data(), tile_.size());
  }
  next_sample_ += together_;
  next_pixel_ = 0;
  if (next_sample_ == result_.sample_end) sums_.end_pixels();
}

}  // namespace tessera::render
