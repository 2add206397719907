#include "denoise/kernel/kernel.h"
#include "denoise/kernel/lanes.h"
#include "denoise/kernel/own.h"

namespace tessera::client::denoise::TESSERA_ISA {
namespace {

using lanes::load;

struct Sums {
  Lanes first[3] = {}, second[3] = {}, first_weight = {}, second_weight = {};
};

/// Adds the pixels at a distance of (dx, dy) from pixels x ... x + 15 of row y.
[[gnu::always_inline]] inline void add(const StatisticalTask& task, int x, int y, int dx, int dy,
                                       Sums& sums) {
  const auto here = [&](const PlaneView& plane) { return load(plane.pixels + y * plane.stride + x); };
  const auto there = [&](const PlaneView& plane) {
    return load(plane.pixels + (y + dy) * plane.stride + x + dx);
  };
  Lanes distance = {};
  for (int g = 0; g < task.guides; ++g) {
    const Lanes difference = there(task.guide[g]) - here(task.guide[g]);
    distance += difference * difference;
  }
  // Each half decides for itself, so that it says nothing about the other one's noise: the other judges it
  // (mixture.h).
  Places first_equal = Places{} - 1, second_equal = first_equal;
  Lanes first[3], second[3];
  for (int c = 0; c < 3; ++c) {
    first[c] = there(task.first[c]), second[c] = there(task.second[c]);
    const Lanes p = lanes::smaller(here(task.variance[c]), kMostVariance * there(task.usual[c]));
    const Lanes q = lanes::smaller(there(task.variance[c]), kMostVariance * here(task.usual[c]));
    const Lanes bound = (p + q) * task.critical;
    const Lanes a = first[c] - here(task.first[c]), b = second[c] - here(task.second[c]);
    first_equal &= a * a <= bound;
    second_equal &= b * b <= bound;
  }
  const Lanes weight = lanes::falling(distance) * there(task.inside);
  const Lanes of_first = first_equal ? weight : Lanes{}, of_second = second_equal ? weight : Lanes{};
  sums.first_weight += of_first, sums.second_weight += of_second;
  for (int c = 0; c < 3; ++c) {
    sums.first[c] += of_first * first[c];
    sums.second[c] += of_second * second[c];
  }
}

}  // namespace

void statistical_row(const StatisticalTask& task, int y) {
  for (int x = 0; x < task.width; x += kLanes) {
    Sums sums;
    for (int dy = -task.window_radius; dy <= task.window_radius; ++dy) {
      for (int dx = -task.window_radius; dx <= task.window_radius; ++dx) add(task, x, y, dx, dy, sums);
    }
    // A pixel is equal to itself: weights are at least 1.
    for (int c = 0; c < 3; ++c) {
      lanes::store(sums.first[c] / sums.first_weight, task.first_out[c] + y * task.stride + x);
      lanes::store(sums.second[c] / sums.second_weight, task.second_out[c] + y * task.stride + x);
    }
  }
}

}  // namespace tessera::client::denoise::TESSERA_ISA
