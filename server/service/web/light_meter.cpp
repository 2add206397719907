#include "service/web/light_meter.h"

#include <algorithm>
#include <cmath>

namespace tessera::server {

std::optional<MeterChannels> meter_channels(const std::vector<wire::ChannelDesc>& channels) {
  const std::vector<PictureLayer> layers = layers_of(channels, /*has_pilot=*/false);
  if (layers.empty() || !layers.front().is_color()) return std::nullopt;
  MeterChannels found;
  std::ranges::copy(layers.front().channels, found.color.begin());
  std::array<std::size_t, 3> deviations{};
  std::size_t count = 0;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].kind != wire::ChannelKind::kSquaredDeviation) continue;
    for (std::size_t band = 0; band < 3; ++band) {
      if (found.color[band] == channels[c].of) deviations[band] = c, ++count;
    }
  }
  if (count == 3) found.deviations = deviations;
  return found;
}

LightMeter::LightMeter(const PixelArea& area, const MeterChannels& channels)
    : area_(area), channels_(channels), cells_(std::size_t{area.width()} * area.height()) {}

void LightMeter::add(const wire::TileResult& result) {
  const std::size_t pixels = result.pixel_count(), width = result.x1 - result.x0;
  const auto has = [&](const std::array<std::size_t, 3>& bands) {
    return *std::ranges::max_element(bands) < result.channels.size();
  };
  if (!has(channels_.color) || (channels_.deviations && !has(*channels_.deviations))) return;
  const PixelArea common = intersection(area_, {result.x0, result.y0, result.x1, result.y1});
  for (std::uint32_t y = common.y0; y < common.y1; ++y) {
    for (std::uint32_t x = common.x0; x < common.x1; ++x) {
      const std::size_t from = std::size_t{y - result.y0} * width + (x - result.x0);
      const double count = result.counts[from];
      if (count == 0) continue;
      Cell& cell = cells_[std::size_t{y - area_.y0} * area_.width() + (x - area_.x0)];
      const double all = cell.count + count;
      for (std::size_t band = 0; band < 3; ++band) {
        // Means and deviations of two sets of samples make those of both [Chan et al. 1979].
        const double mean = result.values[channels_.color[band] * pixels + from] / count;
        const double apart = mean - cell.mean[band];
        cell.mean[band] += apart * count / all;
        if (!channels_.deviations) continue;
        cell.deviations[band] += result.values[(*channels_.deviations)[band] * pixels + from] +
                                 apart * apart * cell.count * count / all;
      }
      cell.count = all;
    }
  }
}

LightReading LightMeter::read(const PixelArea& part, const std::array<double, 3>& weights,
                              bool pixels_share) const {
  LightReading reading;
  bool has_error = channels_.deviations.has_value();
  double errors = 0, squares = 0;
  const PixelArea common = intersection(area_, part);
  for (std::uint32_t y = common.y0; y < common.y1; ++y) {
    for (std::uint32_t x = common.x0; x < common.x1; ++x) {
      const Cell& cell = cells_[std::size_t{y - area_.y0} * area_.width() + (x - area_.x0)];
      if (cell.count == 0) continue;
      ++reading.pixels;
      reading.samples += static_cast<std::uint64_t>(cell.count);
      has_error = has_error && cell.count >= 2;
      double error = 0;
      for (std::size_t band = 0; band < 3; ++band) {
        reading.color[band] += cell.mean[band];
        if (has_error)
          error += std::abs(weights[band]) * std::sqrt(cell.deviations[band] / (cell.count - 1) / cell.count);
      }
      errors += error, squares += error * error;
    }
  }
  if (reading.pixels == 0) return reading;
  for (std::size_t band = 0; band < 3; ++band) {
    reading.color[band] /= reading.pixels;
    reading.luminance += weights[band] * reading.color[band];
  }
  if (has_error) reading.error = (pixels_share ? errors : std::sqrt(squares)) / reading.pixels;
  return reading;
}

}  // namespace tessera::server
