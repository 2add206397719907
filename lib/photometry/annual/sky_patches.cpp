#include "photometry/annual/sky_patches.h"

#include <algorithm>
#include <numeric>

namespace tessera::photometry {
namespace {

constexpr int kTregenzaRows = 7;
constexpr int kPatchesOfRow[kTregenzaRows] = {30, 30, 24, 24, 18, 12, 6};

HorizonDirection toward_radians(double altitude, double azimuth) {
  return toward(altitude / kRadiansPerDegree, azimuth / kRadiansPerDegree);
}

}  // namespace

HorizonDirection SkyPatch::middle() const {
  if (high >= std::numbers::pi / 2) return {};
  return toward_radians((low + high) / 2, azimuth_begin + azimuth_width / 2);
}

HorizonDirection SkyPatch::at(double u, double v) const {
  const double sine = std::sin(low) + v * (std::sin(high) - std::sin(low));
  return toward_radians(std::asin(std::min(sine, 1.0)), azimuth_begin + u * azimuth_width);
}

SkyPatches::SkyPatches(int factor) : row_height_(90 / (kTregenzaRows * factor + 0.5) * kRadiansPerDegree) {
  for (int row = 0; row < kTregenzaRows * factor; ++row) {
    row_begins_.push_back(patches_.size());
    const int count = kPatchesOfRow[row / factor] * factor;
    const double width = 2 * std::numbers::pi / count;
    for (int i = 0; i < count; ++i) {
      patches_.push_back({.low = row * row_height_,
                          .high = (row + 1) * row_height_,
                          .azimuth_begin = (i - 0.5) * width,
                          .azimuth_width = width});
    }
  }
  row_begins_.push_back(patches_.size());
  patches_.push_back({.low = kTregenzaRows * factor * row_height_,
                      .high = std::numbers::pi / 2,
                      .azimuth_begin = 0,
                      .azimuth_width = 2 * std::numbers::pi});
}

std::size_t SkyPatches::number_of(const HorizonDirection& w) const {
  if (!(w.up > 0)) return 0;
  const auto row = static_cast<std::size_t>(altitude_degrees(w) * kRadiansPerDegree / row_height_);
  if (row + 1 >= row_begins_.size()) return patches_.size();
  const std::size_t begin = row_begins_[row], count = row_begins_[row + 1] - begin;
  const double turn = azimuth_degrees(w) / 360 * static_cast<double>(count) + 0.5;
  return begin + static_cast<std::size_t>(turn) % count + 1;
}

std::vector<std::size_t> SkyPatches::nearest(const HorizonDirection& w, std::size_t most) const {
  std::vector<std::size_t> numbers(patches_.size());
  std::iota(numbers.begin(), numbers.end(), std::size_t{1});
  const std::size_t kept = std::min(most, numbers.size());
  const auto closer = [&](std::size_t a, std::size_t b) {
    const double at_a = cosine_between(sky(a).middle(), w), at_b = cosine_between(sky(b).middle(), w);
    return at_a != at_b ? at_a > at_b : a < b;
  };
  std::partial_sort(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(kept), numbers.end(),
                    closer);
  numbers.resize(kept);
  return numbers;
}

}  // namespace tessera::photometry
