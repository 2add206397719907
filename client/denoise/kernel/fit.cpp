#include <cmath>

#include "denoise/kernel/kernel.h"
#include "denoise/kernel/lanes.h"
#include "denoise/kernel/own.h"

namespace tessera::client::denoise::TESSERA_ISA {
namespace {

using lanes::load;

constexpr int kMaxTerms = kMaxGuides + 3;  // 1, x, y, and the guides
constexpr int kMaxSums = kMaxTerms * (kMaxTerms + 1) / 2;

/// A window's pixels, row after row, each of its terms and colours by itself.
struct Window {
  int terms = 0;
  alignas(64) float term[kMaxTerms][kPaddedWindow];
  alignas(64) float colour[3][kPaddedWindow];
  alignas(64) float weight[kPaddedWindow];
};

void gather(const PlaneView& plane, int x, int y, float* to) {
  for (int row = 0; row < kWindowSide; ++row) {
    const float* const from = plane.pixels + (y - kWindowRadius + row) * plane.stride + x - kWindowRadius;
    for (int column = 0; column < kWindowSide; ++column) to[row * kWindowSide + column] = from[column];
  }
  for (int i = kWindowPixels; i < kPaddedWindow; ++i) to[i] = 0;
}

void fill(const FitTask& task, Window& window) {
  window.terms = 3 + task.guides;
  for (int i = 0; i < kPaddedWindow; ++i) {
    constexpr float kStep = 1.0f / kWindowRadius;
    window.term[0][i] = 1;
    window.term[1][i] = static_cast<float>(i % kWindowSide - kWindowRadius) * kStep;
    window.term[2][i] = static_cast<float>(i / kWindowSide - kWindowRadius) * kStep;
  }
  for (int g = 0; g < task.guides; ++g) {
    const PlaneView& guide = task.guide[g];
    const float centre = guide.pixels[task.y * guide.stride + task.x];
    gather(guide, task.x, task.y, window.term[3 + g]);
    for (float& value : window.term[3 + g]) value -= centre;
  }
  for (int c = 0; c < 3; ++c) gather(task.colour[c], task.x, task.y, window.colour[c]);
  gather(task.inside, task.x, task.y, window.weight);
  const float sharpness = 1.0f / (task.bandwidth * task.bandwidth);
  for (int i = 0; i < kPaddedWindow; i += kLanes) {
    const Lanes weight = load(window.weight + i) * lanes::falling(load(task.distance + i) * sharpness);
    lanes::store(weight, window.weight + i);
  }
}

float weighted_product(const float* weighted, const float* other) {
  Lanes sum = {};
  for (int i = 0; i < kPaddedWindow; i += kLanes) sum += load(weighted + i) * load(other + i);
  return lanes::sum(sum);
}

/// Solves the normal equations by Cholesky's decomposition: `matrix`, its lower half row by row, is replaced.
void solve(int n, double* matrix, double (*right)[kMaxTerms]) {
  const auto at = [matrix](int row, int column) -> double& { return matrix[row * (row + 1) / 2 + column]; };
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < j; ++k) {
      for (int i = j; i < n; ++i) at(i, j) -= at(i, k) * at(j, k);
    }
    const double root = std::sqrt(at(j, j));
    for (int i = j; i < n; ++i) at(i, j) /= root;
  }
  for (int c = 0; c < 3; ++c) {
    double* const x = right[c];
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < i; ++k) x[i] -= at(i, k) * x[k];
      x[i] /= at(i, i);
    }
    for (int i = n - 1; i >= 0; --i) {
      for (int k = i + 1; k < n; ++k) x[i] -= at(k, i) * x[k];
      x[i] /= at(i, i);
    }
  }
}

/// Adds the fitted colours, none below 0, by their weights.
void add_fit(const FitTask& task, const Window& window, const double (*factors)[kMaxTerms]) {
  alignas(64) float fitted[kPaddedWindow];
  const auto add = [&](const float* values, float* plane) {
    for (int row = 0; row < kWindowSide; ++row) {
      float* const to = plane + (task.y - kWindowRadius + row) * task.sums.stride + task.x - kWindowRadius;
      for (int column = 0; column < kWindowSide; ++column) to[column] += values[row * kWindowSide + column];
    }
  };
  add(window.weight, task.sums.weight);
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < kPaddedWindow; i += kLanes) {
      Lanes sum = {};
      for (int t = 0; t < window.terms; ++t)
        sum += load(window.term[t] + i) * static_cast<float>(factors[c][t]);
      lanes::store(lanes::larger(sum, Lanes{}) * load(window.weight + i), fitted + i);
    }
    add(fitted, task.sums.value[c]);
  }
}

}  // namespace

void fit_window(const FitTask& task) {
  // Guides that vary less than this in a window, squared, explain little of it: what they would fit is noise.
  constexpr double kRidge = 1e-3;
  Window window;
  fill(task, window);
  double matrix[kMaxSums], right[3][kMaxTerms];
  alignas(64) float weighted[kPaddedWindow];
  for (int row = 0; row < window.terms; ++row) {
    for (int i = 0; i < kPaddedWindow; i += kLanes)
      lanes::store(load(window.weight + i) * load(window.term[row] + i), weighted + i);
    for (int column = 0; column <= row; ++column)
      matrix[row * (row + 1) / 2 + column] = weighted_product(weighted, window.term[column]);
    for (int c = 0; c < 3; ++c) right[c][row] = weighted_product(weighted, window.colour[c]);
  }
  const double total = matrix[0];
  for (int row = 1; row < window.terms; ++row) matrix[row * (row + 1) / 2 + row] += kRidge * total;
  solve(window.terms, matrix, right);
  add_fit(task, window, right);
}

}  // namespace tessera::client::denoise::TESSERA_ISA
