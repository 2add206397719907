// The light of a pixel, and of the pixels around it, with its error.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "service/web/picture.h"

namespace tessera::server {

/// Channels of results that a meter reads.
struct MeterChannels {
  std::array<std::size_t, 3> color{};                      // red, green and blue
  std::optional<std::array<std::size_t, 3>> deviations{};  // their squared deviations (--aov variance)
};

/// Nothing where results have no colour.
std::optional<MeterChannels> meter_channels(const std::vector<wire::ChannelDesc>& channels);

struct LightReading {
  std::array<double, 3> color{};  // mean over pixels of the means of their samples
  double luminance = 0;           // of the same, by the weights
  // Standard error of the luminance, as if samples of a pixel were independent and channels erred together:
  // rather too much than too little. Nothing without deviations, or where a pixel has less than two samples.
  std::optional<double> error;
  std::uint64_t samples = 0;
  std::uint32_t pixels = 0;  // that have samples
};

/// Sums of the pixels of a small area, from results in any order.
class LightMeter {
 public:
  LightMeter(const PixelArea& area, const MeterChannels& channels);

  /// Takes what lies within the area; results without the channels are left out.
  void add(const wire::TileResult& result);

  /// The mean over the pixels of `part`, which is within the area. Errors of pixels that share samples may
  /// agree: the mean's is then at most the mean of theirs, which is what is told.
  LightReading read(const PixelArea& part, const std::array<double, 3>& weights, bool pixels_share) const;

 private:
  struct Cell {
    double count = 0;
    std::array<double, 3> mean{}, deviations{};
  };

  const PixelArea area_;
  const MeterChannels channels_;
  std::vector<Cell> cells_;
};

}  // namespace tessera::server
