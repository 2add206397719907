#include "service/web/picture.h"

#include <Imath/half.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

using LayerKind = PictureLayer::Kind;
using Noise = PictureLayer::Noise;

/// Rec. 709.
constexpr double kLuminance[3] = {0.2126, 0.7152, 0.0722};

/// Beyond its range the largest finite one: a display has no use for infinity.
std::uint16_t half_of(float value) {
  return imath_float_to_half(std::clamp<float>(value, -HALF_MAX, HALF_MAX));
}

template <class T>
void append_bytes(T value, std::string& bytes) {
  const auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  bytes.append(raw.data(), raw.size());
}

/// "albedo" of "albedo.R"; "color" of "R".
std::string group_of(const std::string& channel) {
  const std::size_t dot = channel.rfind('.');
  if (dot != std::string::npos) return channel.substr(0, dot);
  return channel == "A" ? "alpha" : "color";
}

/// Pixels of a level along a side.
std::size_t cells(std::uint32_t pixels, std::uint32_t level) {
  return (std::size_t{pixels} + (std::size_t{1} << level) - 1) >> level;
}

std::size_t bands_of(const PictureLayer& layer) {
  const bool has_channels = layer.kind == LayerKind::kMean || layer.kind == LayerKind::kFirst;
  return has_channels ? std::min<std::size_t>(3, layer.channels.size()) : 1;
}

PictureLayer noise_layer(const std::vector<wire::ChannelDesc>& channels,
                         const std::vector<std::size_t>& color, bool has_pilot) {
  PictureLayer layer{.name = "noise", .kind = LayerKind::kNoise, .channels = color};
  if (!has_pilot) return layer;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const bool of_color = std::ranges::find(color, std::size_t{channels[c].of}) != color.end();
    if (channels[c].kind == wire::ChannelKind::kSquaredDeviation && of_color) layer.channels.push_back(c);
  }
  const bool has_variance = layer.channels.size() == 2 * color.size();
  layer.noise = has_variance ? Noise::kVariance : Noise::kPilot;
  if (!has_variance) layer.channels = color;
  return layer;
}

}  // namespace

PixelArea intersection(const PixelArea& a, const PixelArea& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

std::vector<PictureLayer> layers_of(const std::vector<wire::ChannelDesc>& channels, bool has_pilot) {
  std::vector<PictureLayer> layers;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].kind == wire::ChannelKind::kSquaredDeviation) continue;
    const bool first = channels[c].kind == wire::ChannelKind::kFirst;
    // Numbers that have no mean are looked at one at a time, and so are bands of radiance.
    const bool alone = first || channels[c].name.starts_with("S0.");
    const std::string name = alone ? channels[c].name : group_of(channels[c].name);
    if (layers.empty() || layers.back().name != name || layers.back().channels.size() == 3)
      layers.push_back({.name = name, .kind = first ? LayerKind::kFirst : LayerKind::kMean, .channels = {}});
    layers.back().channels.push_back(c);
  }
  if (!layers.empty() && layers.front().is_color())
    layers.push_back(noise_layer(channels, layers.front().channels, has_pilot));
  layers.push_back({.name = "samples", .kind = LayerKind::kSamples, .channels = {}});
  layers.push_back({.name = "cost", .kind = LayerKind::kCost, .channels = {}});
  return layers;
}

std::uint32_t Picture::level_for(const PixelArea& area) {
  std::uint32_t level = 0;
  while (cells(area.width(), level) * cells(area.height(), level) > kMostPixels) ++level;
  return level;
}

std::size_t Picture::bytes_for(const PixelArea& area, const PictureLayer& layer) {
  const std::uint32_t level = level_for(area);
  const std::size_t planes = 1 + bands_of(layer) + (layer.kind == LayerKind::kNoise ? 2 : 0);
  return cells(area.width(), level) * cells(area.height(), level) * planes * sizeof(float);
}

Picture::Picture(PixelArea area, std::uint32_t level, PictureLayer layer)
    : area_(area),
      level_(level),
      layer_(std::move(layer)),
      bands_(bands_of(layer_)),
      width_(static_cast<std::uint32_t>(cells(area.width(), level))),
      height_(static_cast<std::uint32_t>(cells(area.height(), level))),
      weights_(std::size_t{width_} * height_),
      sums_(weights_.size() * bands_),
      squares_(layer_.kind == LayerKind::kNoise ? weights_.size() : 0),
      parts_(squares_.size()) {}

absl::Status Picture::add(const wire::TileResult& result, double cpu_seconds) {
  for (const std::size_t channel : layer_.channels) {
    if (channel >= result.channels.size())
      return absl::InvalidArgumentError(absl::StrCat("a result has no channel ", channel));
  }
  const PixelArea common = intersection(area_, {result.x0, result.y0, result.x1, result.y1});
  if (common.empty()) return absl::OkStatus();
  const double seconds_a_pixel = cpu_seconds / static_cast<double>(result.pixel_count());
  for (std::uint32_t y = common.y0; y < common.y1; ++y) add_row(result, y, common, seconds_a_pixel);
  ++changes_;
  changed_.push_back(common);
  if (changed_.size() > kMostAreas) changed_.pop_front();
  return absl::OkStatus();
}

void Picture::add_row(const wire::TileResult& result, std::uint32_t y, const PixelArea& common,
                      double seconds_a_pixel) {
  const std::size_t pixels = result.pixel_count(), width = result.x1 - result.x0;
  const std::size_t plane = weights_.size();
  const std::size_t row = std::size_t{(y - area_.y0) >> level_} * width_;
  for (std::uint32_t x = common.x0; x < common.x1; ++x) {
    const std::size_t from = (y - result.y0) * width + (x - result.x0);
    const std::size_t to = row + ((x - area_.x0) >> level_);
    const auto count = static_cast<float>(result.counts[from]);
    const auto value = [&](std::size_t band) { return result.values[layer_.channels[band] * pixels + from]; };
    switch (layer_.kind) {
      case LayerKind::kMean:
        for (std::size_t band = 0; band < bands_; ++band) sums_[band * plane + to] += value(band);
        break;
      case LayerKind::kFirst:
        if (weights_[to] == 0) sums_[to] = value(0);
        break;
      case LayerKind::kNoise:
        add_noise(result, x, y, to);
        continue;
      case LayerKind::kSamples:
        // The mean over the pixels of a cell, like all else.
        sums_[to] += count;
        break;
      case LayerKind::kCost:
        sums_[to] += static_cast<float>(seconds_a_pixel);
        break;
    }
    weights_[to] += count;
  }
}

/// Where one result is all that a pixel has, `squares_` is the variance of its sum, as if its samples were
/// independent, and channels erred together: rather too much than too little.
void Picture::add_noise(const wire::TileResult& result, std::uint32_t x, std::uint32_t y, std::size_t to) {
  const std::size_t pixels = result.pixel_count();
  const std::size_t from = std::size_t{y - result.y0} * (result.x1 - result.x0) + (x - result.x0);
  const double count = result.counts[from];
  if (count == 0) return;
  const auto luminance = [&](std::size_t first, auto&& value) {
    double sum = 0;
    for (std::size_t band = 0; band < 3; ++band)
      sum += kLuminance[band] * value(double{result.values[layer_.channels[first + band] * pixels + from]});
    return sum;
  };
  const double light = luminance(0, [](double sum) { return sum; });
  double squares = light * light / count;
  if (layer_.noise == Noise::kVariance) {
    if (count < 2) return;
    const double error =
        luminance(3, [&](double deviations) { return std::sqrt(deviations * count / (count - 1)); });
    squares = error * error;
  } else if (layer_.noise == Noise::kPilot) {
    const wire::PilotBlock* const block = pilot_ == nullptr ? nullptr : pilot_->at(x, y);
    if (block == nullptr) return;
    const double mean = light / count, error = (double{block->error[0]} + double{block->error[1]}) / 2;
    squares = error * (mean * mean + wire::kPilotDarkness) * count;
  }
  weights_[to] += static_cast<float>(count);
  sums_[to] += static_cast<float>(light);
  squares_[to] += static_cast<float>(squares);
  ++parts_[to];
}

/// Standard error of the mean of a cell that has at least one result; NaN where that cannot be told.
double Picture::noise_of(const Cell& cell) const {
  if (layer_.noise != Noise::kSpread) return std::sqrt(cell.squares) / cell.weight;
  if (cell.parts < 2) return std::numeric_limits<double>::quiet_NaN();
  // Each result's mean is an estimate by itself: the weighted variance between them, of their mean.
  const double mean = cell.sum[0] / cell.weight;
  const double spread = std::max(0.0, cell.squares - cell.weight * mean * mean);
  return std::sqrt(spread / ((cell.parts - 1) * cell.weight));
}

void Picture::merge(Cell& into, const Cell& cell) const {
  if (cell.weight == 0) return;
  if (layer_.kind == LayerKind::kFirst) {
    if (into.weight == 0) into = cell;
    return;
  }
  into.weight += cell.weight;
  for (int band = 0; band < 3; ++band) into.sum[band] += cell.sum[band];
  into.squares += cell.squares;
  into.parts += cell.parts;
}

Picture::Cell Picture::cell_at(std::uint32_t level, std::uint32_t x, std::uint32_t y) const {
  const std::uint32_t step = 1u << (level - level_);
  const std::uint32_t end_x = std::min((x + 1) * step, width_), end_y = std::min((y + 1) * step, height_);
  Cell all;
  double noise = 0, cells = 0;
  for (std::uint32_t v = y * step; v < end_y; ++v) {
    for (std::uint32_t u = x * step; u < end_x; ++u) {
      const std::size_t at = std::size_t{v} * width_ + u;
      Cell cell{.weight = weights_[at]};
      for (std::size_t band = 0; band < bands_; ++band) cell.sum[band] = sums_[band * weights_.size() + at];
      if (layer_.kind == LayerKind::kNoise && parts_[at] > 0) {
        cell.squares = squares_[at];
        cell.parts = parts_[at];
        if (const double error = noise_of(cell); !std::isnan(error)) {
          noise += error;
          cells += 1;
        }
      }
      merge(all, cell);
    }
  }
  if (layer_.kind == LayerKind::kNoise) {
    all.sum[0] = noise;
    all.weight = cells;
  } else if (layer_.kind == LayerKind::kSamples || layer_.kind == LayerKind::kCost) {
    // Sums over the film's pixels that there are: the mean is over those.
    const PixelArea film = intersection({(x << level) + area_.x0, (y << level) + area_.y0,
                                         ((x + 1) << level) + area_.x0, ((y + 1) << level) + area_.y0},
                                        area_);
    if (all.weight > 0) all.weight = double(film.width()) * film.height();
    if (layer_.kind == LayerKind::kCost) all.sum[0] *= 1024;
  } else if (layer_.kind == LayerKind::kFirst && all.weight > 0) {
    all.weight = 1;
  }
  return all;
}

void Picture::write(const Cell& cell, std::string& bytes) const {
  if (layer_.is_color()) {
    for (const double sum : cell.sum)
      append_bytes(half_of(cell.weight > 0 ? static_cast<float>(sum / cell.weight) : 0.f), bytes);
    append_bytes(half_of(cell.weight > 0 ? 1.f : 0.f), bytes);
    return;
  }
  const double value = cell.weight > 0 ? cell.sum[0] / cell.weight : std::numeric_limits<double>::quiet_NaN();
  append_bytes(static_cast<float>(value), bytes);
}

std::string Picture::pixels(std::uint32_t level, const PixelArea& part) const {
  std::string bytes;
  bytes.reserve(std::size_t{part.width()} * part.height() * (layer_.is_color() ? 8 : 4));
  for (std::uint32_t y = part.y0; y < part.y1; ++y) {
    for (std::uint32_t x = part.x0; x < part.x1; ++x) write(cell_at(level, x, y), bytes);
  }
  return bytes;
}

std::optional<std::vector<PixelArea>> Picture::changed_since(std::uint64_t since) const {
  if (since > changes_ || changes_ - since > changed_.size()) return std::nullopt;
  return std::vector<PixelArea>(changed_.end() - static_cast<std::ptrdiff_t>(changes_ - since),
                                changed_.end());
}

}  // namespace tessera::server
