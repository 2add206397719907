#include "render/film/scatter_tile.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "render/film/common_places.h"
#include "render/film/filter_value.h"
#include "render/film/pixel_order.h"

namespace tessera::render {

namespace {

/// In place of a pixel's number: none of the group's.
constexpr std::uint32_t kNone = ~0u;

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

ScatterTile::ScatterTile(wire::TileResult& result, const PixelFilterRecord& filter, std::uint64_t seed,
                         const SampleCounts* counts, PixelGroup group, FilmSize film)
    : result_(result),
      filter_(filter),
      seed_(seed),
      counts_(counts),
      group_pixels_(group),
      film_(film),
      reach_x_(filter_reach(filter.x)),
      reach_y_(filter_reach(filter.y)),
      width_(result.x1 - result.x0 + 2 * reach_x_),
      height_(result.y1 - result.y0 + 2 * reach_y_),
      channels_(static_cast<std::size_t>(
          std::ranges::count_if(result.channels, &wire::is_sampled, &wire::ChannelDesc::kind))),
      part_(result),
      sums_(part_),
      filtered_(channels_ * result.pixel_count()),
      padded_(width_ + 2 * reach_x_),
      row_(result.x1 - result.x0),
      weights_x_(2 * reach_x_ + 1),
      weights_y_(2 * reach_y_ + 1) {
  result_.counts.assign(result_.pixel_count(), 0);
  result_.values.assign(result_.channels.size() * result_.pixel_count(), 0.0f);
  std::uint32_t plane = 0;
  for (const wire::ChannelDesc& channel : result.channels) {
    if (channel.kind == wire::ChannelKind::kFirst) firsts_.push_back(plane);
    plane += wire::is_sampled(channel.kind) ? 1 : 0;
  }
  if (counts != nullptr) {
    group_blocks(*counts);
  } else {
    groups_.emplace_back().samples = result.sample_end - result.sample_begin;
    add_run(groups_.back(), 0, 0, width_, height_);
  }
  begin_group();
}

// ---------------------------------------------------------------- pixels of one number of samples

void ScatterTile::add_run(Group& group, std::uint32_t x, std::uint32_t y, std::uint32_t width,
                          std::uint32_t height) {
  group.runs.push_back({x, y, width, height, group.size});
  group.size += std::size_t{width} * height;
}

void ScatterTile::group_blocks(const SampleCounts& counts) {
  const std::uint32_t left = result_.x0 - reach_x_, top = result_.y0 - reach_y_;  // modulo 2^32
  // Pixels up to the next border of blocks.
  const auto to_border = [](std::uint32_t place) { return wire::kNoiseBlock - place % wire::kNoiseBlock; };
  const auto samples_at = [&](std::uint32_t x, std::uint32_t y) {
    return std::min(counts.at(left + x, top + y), result_.sample_end - result_.sample_begin);
  };
  std::map<std::uint32_t, Group> groups;
  for (std::uint32_t y = 0, height; y < height_; y += height) {
    height = std::min(to_border(top + y), height_ - y);
    for (std::uint32_t x = 0, end; x < width_; x = end) {
      const std::uint32_t samples = samples_at(x, y);
      for (end = x; end < width_ && samples_at(end, y) == samples;)
        end = std::min(end + to_border(left + end), width_);
      groups[samples].samples = samples;
      add_run(groups[samples], x, y, end - x, height);
    }
  }
  for (auto& [samples, group] : groups) groups_.push_back(std::move(group));
}

FilmRect ScatterTile::reached_by(const Run& run) const {
  // A pixel of the tile is reached by those of the border's rectangle from its own number on, to twice the
  // reach further.
  const auto first = [](std::uint32_t begin, std::uint32_t reach) {
    return begin > 2 * reach ? begin - 2 * reach : 0;
  };
  return {first(run.x, reach_x_), first(run.y, reach_y_),
          std::min(run.x + run.width, result_.x1 - result_.x0),
          std::min(run.y + run.height, result_.y1 - result_.y0)};
}

void ScatterTile::begin_group() {
  const Group& group = groups_[group_];
  std::vector<std::uint32_t> number_of(std::size_t{width_} * height_, kNone);
  std::vector<bool> is_reached(result_.pixel_count());
  for (const Run& run : group.runs) {
    for (std::uint32_t i = 0; i < run.width * run.height; ++i)
      number_of[std::size_t{run.y + i / run.width} * width_ + run.x + i % run.width] =
          static_cast<std::uint32_t>(run.first) + i;
    const FilmRect rect = reached_by(run);
    for (std::uint32_t y = rect.y0; y < rect.y1; ++y) {
      const auto row = is_reached.begin() + std::ptrdiff_t{y} * (result_.x1 - result_.x0);
      if (rect.x0 < rect.x1) std::fill(row + rect.x0, row + rect.x1, true);
    }
  }
  order_pixels(number_of);
  reached_.clear();
  for (std::uint32_t i = 0; i < is_reached.size(); ++i) {
    if (is_reached[i]) reached_.push_back(i);
  }
  leaf_.resize(channels_ * reached_.size());
  next_sample_ = 0;
  sums_.begin_pixels(reached_);
}

/// Whole groups of neighbours that have pixels of the group at hand, whose numbers are given: those that are
/// none of its own have numbers beyond.
void ScatterTile::order_pixels(const std::vector<std::uint32_t>& number_of) {
  const std::uint32_t left = result_.x0 - reach_x_, top = result_.y0 - reach_y_;  // modulo 2^32
  const auto number_at = [&](std::uint32_t x, std::uint32_t y) {
    return x < width_ && y < height_ ? number_of[std::size_t{y} * width_ + x] : kNone;
  };
  order_.clear();
  places_.clear();
  auto beyond = static_cast<std::uint32_t>(groups_[group_].size);
  const std::size_t size = packet_of(group_pixels_);
  const std::vector<PixelPlace> pixels = groups_in(left, top, width_, height_, group_pixels_);
  std::vector<std::uint32_t> numbers(size);
  for (std::size_t first = 0; first < pixels.size(); first += size) {
    const std::span<const PixelPlace> packet(&pixels[first], size);
    std::ranges::transform(packet, numbers.begin(),
                           [&](const PixelPlace& place) { return number_at(place.x, place.y); });
    if (std::ranges::all_of(numbers, [](std::uint32_t number) { return number == kNone; })) continue;
    for (std::size_t i = 0; i < size; ++i) {
      order_.push_back(numbers[i] == kNone ? beyond++ : numbers[i]);
      const std::uint32_t x = left + packet[i].x, y = top + packet[i].y;
      places_.push_back({x, y, 0, film_.reaches(x, y, reach_x_, reach_y_) ? 0 : kUnsampled});
    }
  }
}

/// The group's picture has a mean over its own number of samples; as a part of the pixel's sum it is times
/// those of the pixel, and its variance such that those of all parts add up to the pixel's.
void ScatterTile::end_group() {
  sums_.end_pixels();
  const double part_count = groups_[group_].samples;
  const std::size_t pixels = result_.pixel_count();
  const std::uint32_t width = result_.x1 - result_.x0;
  for (const std::uint32_t i : reached_) {
    std::uint32_t own = groups_[group_].samples;
    if (counts_ != nullptr)
      own = std::min(counts_->at(result_.x0 + i % width, result_.y0 + i / width),
                     result_.sample_end - result_.sample_begin);
    const double ratio = own / part_count;
    const double of_squares =
        own == part_count || part_count == 1 ? ratio : ratio * (own - 1) / (part_count - 1);
    result_.counts[i] = own;
    for (std::size_t c = 0; c < result_.channels.size(); ++c) {
      float& value = result_.values[c * pixels + i];
      const float part = part_.values[c * pixels + i];
      switch (result_.channels[c].kind) {
        case wire::ChannelKind::kSum:
          value += static_cast<float>(part * ratio);
          break;
        case wire::ChannelKind::kSquaredDeviation:
          value += static_cast<float>(part * of_squares);
          break;
        case wire::ChannelKind::kFirst:
          if (own == groups_[group_].samples) value = part;
          break;
      }
    }
  }
}

// ---------------------------------------------------------------- samples

void ScatterTile::begin_samples(std::size_t batch) {
  const Group& group = groups_[group_];
  const auto fit = static_cast<std::uint32_t>(std::min<std::size_t>(batch / order_.size(), kMostTogether));
  const std::size_t groups = batch / packet_of(group_pixels_);
  together_ =
      std::min({std::max(fit, kTogether), group.samples - next_sample_, static_cast<std::uint32_t>(groups)});
  common_ = {result_.sample_begin + next_sample_, x_.data(), y_.data()};
  for (std::uint32_t s = 0; s < together_; ++s) {
    // Next to pixels that take other numbers of samples, weights add up to 1 only as far as each mean is
    // right by itself.
    const bool even = counts_ == nullptr || counts_->even;
    const Place place =
        even ? shifted_place(seed_, common_.first + s) : scrambled_place(seed_, common_.first + s);
    x_[s] = place.x, y_[s] = place.y;
  }
  samples_.resize(together_ * channels_ * order_.size());
}

std::size_t ScatterTile::next(std::span<SampleName> names) {
  if (next_pixel_ == order_.size()) end_samples();
  if (group_ == groups_.size()) return 0;
  if (next_pixel_ == 0) begin_samples(names.size());
  const std::size_t whole = packet_of(group_pixels_);
  count_ = std::min(names.size() / together_ / whole * whole, order_.size() - next_pixel_);
  SampleName* name = names.data();
  for (std::uint32_t s = 0; s < together_; ++s) {
    for (const SampleName& place : std::span(places_).subspan(next_pixel_, count_))
      *name++ = {place.x, place.y, common_.first + s, place.stream};
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

void ScatterTile::filter_run(const Run& run, const float* from, float* to) {
  const std::size_t width = result_.x1 - result_.x0, height = result_.y1 - result_.y0;
  const FilmRect reached = reached_by(run);
  if (reached.x0 >= reached.x1) return;
  const auto add_weighted = [](const float* __restrict row, std::size_t n, float weight,
                               float* __restrict sum) {
    // A compiler makes vectors of a known number.
    constexpr std::size_t kAtOnce = 16;
    std::size_t x = 0;
    for (; x + kAtOnce <= n; x += kAtOnce)
      for (std::size_t i = 0; i < kAtOnce; ++i) sum[x + i] += weight * row[x + i];
    for (; x < n; ++x) sum[x] += weight * row[x];
  };
  // The run's row, with black on both sides: pixel x of the tile meets it from place x on.
  std::ranges::fill(padded_, 0.0f);
  for (std::size_t y = run.y; y < run.y + run.height; ++y, from += run.width) {
    std::copy_n(from, run.width, padded_.data() + run.x);
    std::fill_n(row_.data() + reached.x0, reached.width(), 0.0f);
    for (std::size_t k = 0; k < weights_x_.size(); ++k)
      add_weighted(padded_.data() + reached.x0 + k, reached.width(), weights_x_[k], row_.data() + reached.x0);
    for (std::size_t k = 0; k < weights_y_.size(); ++k) {
      if (y < k || y - k >= height) continue;
      add_weighted(row_.data() + reached.x0, reached.width(), weights_y_[k],
                   to + (y - k) * width + reached.x0);
    }
  }
}

/// A number that has no mean is that of the pixel's own sample.
void ScatterTile::copy_own(const Run& run, const float* from, float* to) const {
  const std::size_t width = result_.x1 - result_.x0, height = result_.y1 - result_.y0;
  for (std::size_t i = 0; i < std::size_t{run.width} * run.height; ++i) {
    const std::size_t x = run.x + i % run.width, y = run.y + i / run.width;
    if (x >= reach_x_ && x - reach_x_ < width && y >= reach_y_ && y - reach_y_ < height)
      to[(y - reach_y_) * width + x - reach_x_] = from[i];
  }
}

void ScatterTile::end_samples() {
  const Group& group = groups_[group_];
  const std::size_t width = result_.x1 - result_.x0, pixels = result_.pixel_count();
  const bool all_reached = reached_.size() == pixels;
  for (std::uint32_t s = 0; s < together_; ++s) {
    weigh(filter_.kind, filter_.x, x_[s], weights_x_);
    weigh(filter_.kind, filter_.y, y_[s], weights_y_);
    for (std::size_t c = 0; c < channels_; ++c) {
      const float* const from = samples_.data() + (s * channels_ + c) * order_.size();
      float* const to = filtered_.data() + c * pixels;
      for (const Run& run : group.runs) {
        const FilmRect rect = reached_by(run);
        for (std::size_t y = rect.y0; y < rect.y1; ++y) {
          if (rect.x0 < rect.x1) std::fill_n(to + y * width + rect.x0, rect.width(), 0.0f);
        }
      }
      if (std::ranges::find(firsts_, c) != firsts_.end()) {
        for (const Run& run : group.runs) copy_own(run, from + run.first, to);
      } else {
        for (const Run& run : group.runs) filter_run(run, from + run.first, to);
      }
      if (all_reached) continue;
      for (std::size_t i = 0; i < reached_.size(); ++i) leaf_[c * reached_.size() + i] = to[reached_[i]];
    }
    sums_.add_sample(all_reached ? filtered_.data() : leaf_.data(), reached_.size());
  }
  next_sample_ += together_;
  next_pixel_ = 0;
  if (next_sample_ < group.samples) return;
  end_group();
  if (++group_ < groups_.size()) begin_group();
}

}  // namespace tessera::render
