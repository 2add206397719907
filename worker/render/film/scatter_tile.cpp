#include "render/film/scatter_tile.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "render/film/common_places.h"
#include "render/film/filter_value.h"

namespace tessera::render {

namespace {

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

ScatterTile::ScatterTile(wire::TileResult& result, const PixelFilterRecord* filter, std::uint64_t seed,
                         const SampleCounts* counts, PixelGroup group, FilmSize film)
    : result_(result),
      filter_(filter),
      seed_(seed),
      counts_(counts),
      group_(group),
      film_(film),
      reach_x_(filter == nullptr ? 0 : filter_reach(filter->x)),
      reach_y_(filter == nullptr ? 0 : filter_reach(filter->y)),
      width_(result.x1 - result.x0 + 2 * reach_x_),
      height_(result.y1 - result.y0 + 2 * reach_y_),
      left_(result.x0 - reach_x_),
      top_(result.y0 - reach_y_),
      sample_channels_(static_cast<std::size_t>(
          std::ranges::count_if(result.channels, &wire::is_sampled, &wire::ChannelDesc::kind))),
      pixel_numbers_(std::size_t{width_} * height_, kNone),
      filtered_(sample_channels_ * result.pixel_count()),
      padded_(width_ + 2 * reach_x_),
      row_(result.x1 - result.x0),
      weights_x_(2 * reach_x_ + 1, 1.0f),
      weights_y_(2 * reach_y_ + 1, 1.0f) {
  std::uint32_t plane = 0;
  for (const wire::ChannelDesc& channel : result.channels) {
    if (channel.kind == wire::ChannelKind::kFirst || channel.kind == wire::ChannelKind::kEntry)
      firsts_.push_back(plane);
    plane += wire::is_sampled(channel.kind) ? 1 : 0;
  }
  if (counts != nullptr) {
    part_blocks(*counts);
  } else {
    unfinished_parts_.emplace_back(result, result.sample_end - result.sample_begin)
        .runs.push_back({0, 0, width_, height_});
  }
  std::size_t number = 0;
  for (Part& part : unfinished_parts_) {
    for (Run& run : part.runs) {
      run.first = number;
      for (std::uint32_t i = 0; i < run.width * run.height; ++i)
        pixel_numbers_[std::size_t{run.y + i / run.width} * width_ + run.x + i % run.width] =
            static_cast<std::uint32_t>(number++);
    }
    begin_part(part);
  }
  result_.counts.assign(result_.pixel_count(), 0);
  result_.values.assign(result_.channels.size() * result_.pixel_count(), 0.0f);
}

// ---------------------------------------------------------------- pixels of one number of samples

ScatterTile::Part::Part(const wire::TileResult& result, std::uint32_t count)
    : samples(count), picture(result), picture_sums(picture) {}

void ScatterTile::part_blocks(const SampleCounts& counts) {
  // Pixels up to the next border of blocks.
  const auto to_border = [](std::uint32_t place) { return wire::kNoiseBlock - place % wire::kNoiseBlock; };
  const auto samples_at = [&](std::uint32_t x, std::uint32_t y) {
    return std::min(counts.at(left_ + x, top_ + y), result_.sample_end - result_.sample_begin);
  };
  std::map<std::uint32_t, std::vector<Run>, std::greater<>> runs;
  for (std::uint32_t y = 0, height; y < height_; y += height) {
    height = std::min(to_border(top_ + y), height_ - y);
    for (std::uint32_t x = 0, end; x < width_; x = end) {
      const std::uint32_t samples = samples_at(x, y);
      for (end = x; end < width_ && samples_at(end, y) == samples;)
        end = std::min(end + to_border(left_ + end), width_);
      runs[samples].push_back({x, y, end - x, height});
    }
  }
  for (auto& [samples, some] : runs) unfinished_parts_.emplace_back(result_, samples).runs = std::move(some);
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

void ScatterTile::begin_part(Part& part) {
  std::vector<bool> is_reached(result_.pixel_count());
  for (const Run& run : part.runs) {
    const FilmRect rect = reached_by(run);
    for (std::uint32_t y = rect.y0; y < rect.y1; ++y) {
      const auto row = is_reached.begin() + std::ptrdiff_t{y} * (result_.x1 - result_.x0);
      if (rect.x0 < rect.x1) std::fill(row + rect.x0, row + rect.x1, true);
    }
  }
  for (std::uint32_t i = 0; i < is_reached.size(); ++i) {
    if (is_reached[i]) part.reached.push_back(i);
  }
  part.picture_sums.begin_pixels(part.reached);
}

/// The part's picture has a mean over its own number of samples; as a part of the pixel's sum it is times
/// those of the pixel, and its variance such that those of all parts add up to the pixel's.
void ScatterTile::end_part(const Part& part) {
  const double part_count = part.samples;
  const std::size_t pixels = result_.pixel_count();
  const std::uint32_t width = result_.x1 - result_.x0;
  for (const std::uint32_t i : part.reached) {
    std::uint32_t own = part.samples;
    if (counts_ != nullptr)
      own = std::min(counts_->at(result_.x0 + i % width, result_.y0 + i / width),
                     result_.sample_end - result_.sample_begin);
    const double ratio = own / part_count;
    const double of_squares =
        own == part_count || part_count == 1 ? ratio : ratio * (own - 1) / (part_count - 1);
    result_.counts[i] = own;
    for (std::size_t c = 0; c < result_.channels.size(); ++c) {
      float& value = result_.values[c * pixels + i];
      const float of_part = part.picture.values[c * pixels + i];
      switch (result_.channels[c].kind) {
        case wire::ChannelKind::kSum:
          value += static_cast<float>(of_part * ratio);
          break;
        case wire::ChannelKind::kSquaredDeviation:
          value += static_cast<float>(of_part * of_squares);
          break;
        case wire::ChannelKind::kFirst:
        case wire::ChannelKind::kEntry:
        case wire::ChannelKind::kFurtherEntry:
          if (own == part.samples) value = of_part;
          break;
      }
    }
  }
}

// ---------------------------------------------------------------- samples

std::uint32_t ScatterTile::number_at(std::uint32_t x, std::uint32_t y) const {
  const std::uint32_t column = x - left_, row = y - top_;
  return column < width_ && row < height_ ? pixel_numbers_[std::size_t{row} * width_ + column] : kNone;
}

/// Returns whole packets that have pixels which take the sample.
std::vector<SampleName> ScatterTile::pixels_of_sample(std::uint32_t sample) const {
  const std::vector<PixelPlace> places =
      groups_in(left_, top_, width_, height_, group_, grid_of(group_, seed_, sample));
  std::vector<SampleName> pixels;
  pixels.reserve(places.size());
  const std::size_t packet = packet_of(group_);
  for (std::size_t first = 0; first < places.size(); first += packet) {
    const std::span<const PixelPlace> some(&places[first], packet);
    if (std::ranges::all_of(some, [&](const PixelPlace& place) {
          return number_at(left_ + place.x, top_ + place.y) == kNone;
        }))
      continue;
    for (const PixelPlace& place : some) {
      const std::uint32_t x = left_ + place.x, y = top_ + place.y;
      pixels.push_back({x, y, sample, film_.reaches(x, y, reach_x_, reach_y_) ? 0 : kUnsampled});
    }
  }
  return pixels;
}

void ScatterTile::begin_samples(std::size_t batch) {
  pixels_[0] = pixels_of_sample(result_.sample_begin + next_sample_);
  const auto fit =
      static_cast<std::uint32_t>(std::min<std::size_t>(batch / pixels_[0].size(), kMostTogether));
  const std::size_t packets = batch / packet_of(group_);
  together_ = std::min({std::max(fit, kTogether), unfinished_parts_.back().samples - next_sample_,
                        static_cast<std::uint32_t>(packets)});
  common_ = {result_.sample_begin + next_sample_, x_.data(), y_.data()};
  for (std::uint32_t s = 0; s < together_; ++s) {
    if (s > 0 && group_.count() > 1) pixels_[s] = pixels_of_sample(common_.first + s);
    if (filter_ == nullptr) continue;
    // Next to pixels that take other numbers of samples, weights add up to 1 only as far as each mean is
    // right by itself.
    const bool even = counts_ == nullptr || counts_->even;
    const Place place =
        even ? shifted_place(seed_, common_.first + s) : scrambled_place(seed_, common_.first + s);
    x_[s] = place.x, y_[s] = place.y;
  }
  samples_.resize(together_ * sample_channels_ * pixel_numbers_.size());
}

std::size_t ScatterTile::next(std::span<SampleName> names) {
  if (together_ > 0) {
    const auto left = [&](const std::vector<SampleName>& pixels) { return pixels.size() > next_pixel_; };
    if (std::none_of(pixels_.begin(), pixels_.begin() + (group_.count() > 1 ? together_ : 1), left))
      end_samples();
  }
  if (unfinished_parts_.empty()) return 0;
  if (next_pixel_ == 0) begin_samples(names.size());
  const std::size_t packet = packet_of(group_), most = names.size() / together_ / packet * packet;
  SampleName* name = names.data();
  for (std::uint32_t s = 0; s < together_; ++s) {
    const std::vector<SampleName>& pixels = pixels_[group_.count() > 1 ? s : 0];
    const std::size_t begin = std::min(next_pixel_, pixels.size()),
                      end = std::min(begin + most, pixels.size());
    for (std::size_t i = begin; i < end; ++i) {
      *name = pixels[i];
      name++->index = common_.first + s;
    }
  }
  next_pixel_ += most;
  return static_cast<std::size_t>(name - names.data());
}

FilmRect ScatterTile::rect() const { return {result_.x0, result_.y0, result_.x1, result_.y1}; }

void ScatterTile::splat(std::span<const Splat>) { assert(!"only passes take light that lands anywhere"); }

void ScatterTile::add(std::span<const SampleName> names, const float* planes, std::size_t stride) {
  batch_.resize(names.size());
  std::ranges::transform(names, batch_.begin(),
                         [&](const SampleName& name) { return number_at(name.x, name.y); });
  for (std::size_t c = 0; c < sample_channels_; ++c) {
    const float* const from = planes + c * stride;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (batch_[i] == kNone) continue;
      const std::size_t s = names[i].index - common_.first;
      samples_[(s * sample_channels_ + c) * pixel_numbers_.size() + batch_[i]] = from[i];
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

void ScatterTile::add_samples(Part& part) {
  const std::size_t width = result_.x1 - result_.x0, pixels = result_.pixel_count();
  const bool all_reached = part.reached.size() == pixels;
  leaf_.resize(sample_channels_ * part.reached.size());
  for (std::uint32_t s = 0; s < together_; ++s) {
    if (filter_ != nullptr) {
      weigh(filter_->kind, filter_->x, x_[s], weights_x_);
      weigh(filter_->kind, filter_->y, y_[s], weights_y_);
    }
    for (std::size_t c = 0; c < sample_channels_; ++c) {
      const float* const from = samples_.data() + (s * sample_channels_ + c) * pixel_numbers_.size();
      float* const to = filtered_.data() + c * pixels;
      for (const Run& run : part.runs) {
        const FilmRect rect = reached_by(run);
        for (std::size_t y = rect.y0; y < rect.y1; ++y) {
          if (rect.x0 < rect.x1) std::fill_n(to + y * width + rect.x0, rect.width(), 0.0f);
        }
      }
      if (std::ranges::find(firsts_, c) != firsts_.end()) {
        for (const Run& run : part.runs) copy_own(run, from + run.first, to);
      } else {
        for (const Run& run : part.runs) filter_run(run, from + run.first, to);
      }
      if (all_reached) continue;
      for (std::size_t i = 0; i < part.reached.size(); ++i)
        leaf_[c * part.reached.size() + i] = to[part.reached[i]];
    }
    part.picture_sums.add_sample(all_reached ? filtered_.data() : leaf_.data(), part.reached.size());
  }
}

void ScatterTile::end_samples() {
  for (Part& part : unfinished_parts_) add_samples(part);
  next_sample_ += together_;
  next_pixel_ = 0;
  for (; !unfinished_parts_.empty() && unfinished_parts_.back().samples == next_sample_;
       unfinished_parts_.pop_back()) {
    Part& part = unfinished_parts_.back();
    part.picture_sums.end_pixels();
    end_part(part);
    for (const Run& run : part.runs) {
      for (std::uint32_t y = run.y; y < run.y + run.height; ++y)
        std::fill_n(pixel_numbers_.begin() + std::ptrdiff_t{y} * width_ + run.x, run.width, kNone);
    }
  }
}

}  // namespace tessera::render
