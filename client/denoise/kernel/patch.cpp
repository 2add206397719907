#include "denoise/kernel/kernel.h"
#include "denoise/kernel/lanes.h"
#include "denoise/kernel/own.h"

namespace tessera::client::denoise::TESSERA_ISA {
namespace {

using lanes::load;

/// Distances of single pixels from x = -radius on.
void pixel_row(const PatchTask& task, int y, int dx, int dy, int count, float* out) {
  constexpr float kLeastVariance = 1e-10f;
  const float share = 1.0f / static_cast<float>(task.channels);
  for (int x = 0; x < count + 2 * task.patch_radius; x += kLanes) {
    Lanes sum = {};
    for (int c = 0; c < task.channels; ++c) {
      const auto at = [&](const PlaneView& plane, int right, int down) {
        return load(plane.pixels + (y + down) * plane.stride + x - task.patch_radius + right);
      };
      const Lanes difference = at(task.value[c], dx, dy) - at(task.value[c], 0, 0);
      const Lanes p = lanes::smaller(at(task.variance[c], 0, 0), kMostVariance * at(task.usual[c], dx, dy));
      const Lanes q = lanes::smaller(at(task.variance[c], dx, dy), kMostVariance * at(task.usual[c], 0, 0));
      sum += (difference * difference - (p + lanes::smaller(p, q))) / (p + q + kLeastVariance);
    }
    // Beyond this, nothing is alike, and sums of it would lose what is small.
    lanes::store(lanes::smaller(sum * share, lanes::all(1e4f)), out + x);
  }
}

}  // namespace

void patch_row(const PatchTask& task, int y, int dx, int dy, int count, int fresh, float* scratch,
               float* out) {
  const int side = 2 * task.patch_radius + 1, row_floats = count + 48;
  for (int row = y + task.patch_radius - fresh + 1; row <= y + task.patch_radius; ++row)
    pixel_row(task, row, dx, dy, count, scratch + (row + kMarginRows) % side * row_floats);
  const float share = 1.0f / static_cast<float>(side * side);
  float columns[kLanes + 2 * kMaxPatchRadius + kLanes];
  for (int x = 0; x < count; x += kLanes) {
    for (int part = 0; part < 2; ++part) {
      Lanes column = {};
      for (int row = 0; row < side; ++row) column += load(scratch + row * row_floats + x + part * kLanes);
      lanes::store(column, columns + part * kLanes);
    }
    Lanes sum = {};
    for (int k = 0; k < side; ++k) sum += load(columns + k);
    lanes::store(lanes::larger(sum * share, Lanes{}), out + x);
  }
}

void blend_row(const PlaneView* planes, int channels, const PlaneView& inside, int y, int dx, int dy,
               int count, const float* distance, float* const* sums, float* weights) {
  for (int x = 0; x < count; x += kLanes) {
    const auto there = [&](const PlaneView& plane) {
      return load(plane.pixels + (y + dy) * plane.stride + x + dx);
    };
    const Lanes weight = lanes::falling(load(distance + x)) * there(inside);
    lanes::store(load(weights + x) + weight, weights + x);
    for (int c = 0; c < channels; ++c)
      lanes::store(load(sums[c] + x) + weight * there(planes[c]), sums[c] + x);
  }
}

}  // namespace tessera::client::denoise::TESSERA_ISA
