#include <algorithm>

#include "denoise/kernel/kernel.h"
#include "denoise/methods.h"
#include "denoise/mixture.h"
#include "import/input/parallel.h"

namespace tessera::client::denoise {
namespace {

/// Tiles of every second row and column do not reach into each other: those of one of four kinds are done at
/// the same time, kind after kind, so that sums have one order whatever the threads.
constexpr int kTile = 64;
static_assert(kTile > 2 * kWindowRadius && kTile % kCentreStep == 0);
constexpr int kCentresPerRow = kTile / kCentreStep;
constexpr float kBandwidth[kBandwidths] = {0.5f, 1.0f};

/// Sums of the fits of one half of the samples by one bandwidth.
struct Sums {
  Sums(int width, int height)
      : value{Plane(width, height), Plane(width, height), Plane(width, height)}, weight(width, height) {}
  FitSums sums() {
    return {{value[0].at(0, 0), value[1].at(0, 0), value[2].at(0, 0)}, weight.at(0, 0), weight.stride()};
  }
  Picture value;
  Plane weight;
};

/// Fits of a half, in windows whose weights are the other half's.
class HalfFit {
 public:
  HalfFit(const NoisyPicture& picture, const std::array<Plane, 3>& colour, const std::array<Plane, 3>& other)
      : picture_(picture),
        colour_(colour),
        patch_{.channels = 3, .value = {}, .variance = {}, .usual = {}, .patch_radius = kPatchRadius} {
    for (int k = 0; k < kBandwidths; ++k) sums_.emplace_back(picture.width, picture.height);
    set_views(other, patch_.value);
    set_views(picture.variance, patch_.variance);
    set_views(picture.usual, patch_.usual);
  }

  /// The windows whose centres are in the tile at (x, y).
  void add_tile(int x, int y) {
    std::vector<float> distances(static_cast<std::size_t>(kCentresPerRow * kCentresPerRow * kPaddedWindow));
    find_distances(x, y, distances);
    FitTask task{.guides = static_cast<int>(picture_.guides.size()), .inside = view(picture_.inside)};
    set_views(picture_.guides, task.guide);
    set_views(colour_, task.colour);
    for (int i = 0; i < kCentresPerRow * kCentresPerRow; ++i) {
      task.x = x + i % kCentresPerRow * kCentreStep, task.y = y + i / kCentresPerRow * kCentreStep;
      if (task.x >= picture_.width || task.y >= picture_.height) continue;
      task.distance = distances.data() + static_cast<std::size_t>(i) * kPaddedWindow;
      for (int k = 0; k < kBandwidths; ++k) {
        task.bandwidth = kBandwidth[k];
        task.sums = sums_[k].sums();
        kernel().fit_window(task);
      }
    }
  }

  /// Pixels that are like no centre of a window keep what they are.
  Picture fitted(int bandwidth) {
    constexpr float kOwnWeight = 1e-3f;
    Sums& sums = sums_[bandwidth];
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < picture_.height; ++y) {
        for (int x = 0; x < picture_.width; ++x) {
          float& value = *sums.value[c].at(x, y);
          value = (value + kOwnWeight * *colour_[c].at(x, y)) / (*sums.weight.at(x, y) + kOwnWeight);
        }
      }
    }
    return std::move(sums.value);
  }

 private:
  /// Window by window, those of its pixels.
  void find_distances(int x, int y, std::vector<float>& distances) const {
    constexpr int kSide = 2 * kPatchRadius + 1;
    float row[kTile + 16];
    std::vector<float> scratch(kSide * (kTile + 48));
    PatchTask task = patch_;
    for (int c = 0; c < 3; ++c)
      task.value[c].pixels += x, task.variance[c].pixels += x, task.usual[c].pixels += x;
    for (int shift = 0; shift < kWindowPixels; ++shift) {
      const int dx = shift % kWindowSide - kWindowRadius, dy = shift / kWindowSide - kWindowRadius;
      for (int j = 0; j < kCentresPerRow && y + j * kCentreStep < picture_.height; ++j) {
        kernel().patch_row(task, y + j * kCentreStep, dx, dy, kTile, j == 0 ? kSide : kCentreStep,
                           scratch.data(), row);
        for (int i = 0; i < kCentresPerRow; ++i)
          distances[static_cast<std::size_t>((j * kCentresPerRow + i) * kPaddedWindow + shift)] =
              row[i * kCentreStep];
      }
    }
  }

  const NoisyPicture& picture_;
  const std::array<Plane, 3>& colour_;
  PatchTask patch_;
  std::vector<Sums> sums_;
};

void add_all_tiles(const NoisyPicture& picture, HalfFit& first, HalfFit& second, int threads) {
  const int columns = (picture.width + kTile - 1) / kTile, rows = (picture.height + kTile - 1) / kTile;
  for (int kind = 0; kind < 4; ++kind) {
    std::vector<std::pair<int, int>> tiles;
    for (int y = kind / 2; y < rows; y += 2) {
      for (int x = kind % 2; x < columns; x += 2) tiles.emplace_back(x * kTile, y * kTile);
    }
    parallel_for(2 * tiles.size(), threads, [&](std::size_t i) {
      const auto [x, y] = tiles[i / 2];
      (i % 2 == 0 ? first : second).add_tile(x, y);
    });
  }
}

}  // namespace

Colours denoise_by_regression(const NoisyPicture& picture, int threads) {
  HalfFit first(picture, picture.first, picture.second), second(picture, picture.second, picture.first);
  add_all_tiles(picture, first, second, threads);
  std::vector<Picture> fits;
  for (int k = 0; k < kBandwidths; ++k) {
    fits.push_back(first.fitted(k));
    fits.push_back(second.fitted(k));
  }
  return mixed(picture, {{fits[0], fits[1]}, {fits[2], fits[3]}}, threads);
}

}  // namespace tessera::client::denoise
