#include "render/film/pass_film.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "render/film/filter_value.h"
#include "render/film/pixel_order.h"
#include "wire/colour_channels.h"
#include "wire/halves.h"

namespace tessera::render {

namespace {

/// Index of the first channel of light of the first half, among those that samples have; 0: there is none.
std::size_t half_channel(const std::vector<wire::ChannelDesc>& channels) {
  const std::string first = wire::colour_channels_of("half").front();
  std::size_t sampled = 0;
  for (const wire::ChannelDesc& channel : channels) {
    if (channel.name == first) return sampled;
    sampled += wire::is_sampled(channel.kind) ? 1 : 0;
  }
  return 0;
}

}  // namespace

PassFilm::PassFilm(wire::TileResult& result, const PixelFilterRecord& filter, std::size_t layers,
                   std::size_t bands, RasterEdges edges, FilmSize raster)
    : result_(result),
      filter_(filter),
      edges_(edges),
      raster_(raster),
      sums_(result),
      pixel_order_(z_order(result.x1 - result.x0, result.y1 - result.y0)),
      all_(pixel_order_.size()),
      sample_channels_(static_cast<std::size_t>(
          std::ranges::count_if(result.channels, &wire::is_sampled, &wire::ChannelDesc::kind))),
      first_layer_(sample_channels_ - 3 * layers),
      first_band_(first_layer_ - bands),
      layer_channels_(3 * layers),
      half_(half_channel(result.channels)),
      next_pass_(result.sample_begin) {
  std::iota(all_.begin(), all_.end(), 0u);
  sums_.begin_pixels(all_);
}

bool PassFilm::begin_pass() {
  if (next_pass_ == result_.sample_end) return false;
  pass_ = next_pass_++;
  next_pixel_ = 0;
  pass_planes_.assign(sample_channels_ * all_.size(), 0.0f);
  layers_.assign(layer_channels_ * all_.size(), 0.0f);
  return true;
}

void PassFilm::end_pass() {
  for (std::size_t i = 0; i < all_.size(); ++i) {
    for (std::size_t k = 0; k < layer_channels_; ++k)
      pass_planes_[(first_layer_ + k) * all_.size() + i] = layers_[i * layer_channels_ + k];
  }
  sums_.add_sample(pass_planes_.data(), all_.size());
  if (next_pass_ == result_.sample_end) sums_.end_pixels();
}

std::size_t PassFilm::next(std::span<SampleName> names) {
  const std::size_t count = std::min(names.size(), pixel_order_.size() - next_pixel_);
  const std::uint32_t width = rect().width();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t pixel = pixel_order_[next_pixel_++];
    names[i] = {result_.x0 + pixel % width, result_.y0 + pixel / width, pass_, 0};
  }
  return count;
}

FilmRect PassFilm::rect() const { return {result_.x0, result_.y0, result_.x1, result_.y1}; }

std::size_t PassFilm::pixel_at(std::uint32_t x, std::uint32_t y) const {
  return std::size_t{y - result_.y0} * rect().width() + (x - result_.x0);
}

void PassFilm::add(std::span<const SampleName> names, const float* planes, std::size_t stride) {
  for (std::size_t c = 0; c < first_layer_; ++c) {
    float* const plane = pass_planes_.data() + c * all_.size();
    for (std::size_t i = 0; i < names.size(); ++i)
      plane[pixel_at(names[i].x, names[i].y)] += planes[c * stride + i];
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    float* const layers = layers_.data() + pixel_at(names[i].x, names[i].y) * layer_channels_;
    for (std::size_t k = 0; k < layer_channels_; ++k) layers[k] += planes[(first_layer_ + k) * stride + i];
  }
}

void PassFilm::splat(std::span<const Splat> splats) {
  for (const Splat& splat : splats) add_splat(splat);
}

void PassFilm::splat_bands(std::span<const BandSplat> splats) {
  for (const BandSplat& splat : splats) {
    float* const plane =
        pass_planes_.data() + (first_band_ + static_cast<std::size_t>(splat.band)) * all_.size();
    for_each_reached(splat.x, splat.y,
                     [&](std::size_t pixel, float weight) { plane[pixel] += splat.value * weight; });
  }
}

template <class F>
void PassFilm::for_each_reached(float x, float y, F&& f) const {
  for_each_around(x, y, f);
  if (edges_ == RasterEdges::kOpen) return;
  for (const RasterPlace& beyond : places_beyond(edges_, raster_, {x, y}, filter_.x.radius, filter_.y.radius))
    for_each_around(beyond.x, beyond.y, f);
}

template <class F>
void PassFilm::for_each_around(float x, float y, F&& f) const {
  // Centres of pixels are at one half.
  const auto first = [](float place, float radius, std::uint32_t begin) {
    return std::max<std::int64_t>(static_cast<std::int64_t>(std::ceil(place - radius - 0.5f)), begin);
  };
  const auto last = [](float place, float radius, std::uint32_t end) {
    return std::min<std::int64_t>(static_cast<std::int64_t>(std::floor(place + radius - 0.5f)),
                                  std::int64_t{end} - 1);
  };
  const std::int64_t first_x = first(x, filter_.x.radius, result_.x0),
                     last_x = last(x, filter_.x.radius, result_.x1);
  const std::int64_t first_y = first(y, filter_.y.radius, result_.y0),
                     last_y = last(y, filter_.y.radius, result_.y1);
  for (std::int64_t row = first_y; row <= last_y; ++row) {
    const float wy = filter_value(filter_.kind, filter_.y, y - static_cast<float>(row) - 0.5f);
    for (std::int64_t column = first_x; column <= last_x; ++column) {
      const float weight = wy * filter_value(filter_.kind, filter_.x, x - static_cast<float>(column) - 0.5f);
      f(pixel_at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row)), weight);
    }
  }
}

void PassFilm::add_splat(const Splat& splat) {
  for_each_reached(splat.x, splat.y, [&](std::size_t pixel, float weight) {
    const float light[] = {splat.value[0] * weight, splat.value[1] * weight, splat.value[2] * weight};
    if (splat.in_picture) {
      for (std::size_t c = 0; c < 3; ++c) pass_planes_[c * all_.size() + pixel] += light[c];
    }
    if (splat.in_picture && half_ != 0 && wire::in_first_half(pass_)) {
      for (std::size_t c = 0; c < 3; ++c) pass_planes_[(half_ + c) * all_.size() + pixel] += 2 * light[c];
    }
    float* const layers = layers_.data() + pixel * layer_channels_;
    for (std::uint32_t left = splat.layers; left != 0; left &= left - 1) {
      float* const layer = layers + 3 * std::countr_zero(left);
      for (std::size_t c = 0; c < 3; ++c) layer[c] += light[c];
    }
  });
}

}  // namespace tessera::render
