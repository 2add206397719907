#include "render/film/pixel_filter.h"

#include <algorithm>
#include <cmath>

namespace tessera::render {

namespace {

constexpr int kBins = 256;

double gaussian(double x, double sigma) { return std::exp(-x * x / (2 * sigma * sigma)); }

// [Mitchell & Netravali 1988], argument in [-2, 2].
double mitchell(double x, double b, double c) {
  x = std::abs(x);
  if (x >= 2) return 0;
  if (x < 1) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
  return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) /
         6;
}

double sinc(double x) {
  x *= 3.14159265358979323846;
  return std::abs(x) < 1e-6 ? 1 : std::sin(x) / x;
}

FilterAxis build_axis(const FilterSpec& spec, double radius) {
  FilterAxis axis;
  axis.radius = static_cast<float>(radius);
  if (spec.kind == FilterKind::kBox || spec.kind == FilterKind::kTriangle) return axis;

  std::vector<double> value(kBins);
  double sum = 0, sum_abs = 0;
  for (int i = 0; i < kBins; ++i) {
    value[i] = evaluate_filter(spec, radius * (2 * (i + 0.5) / kBins - 1), radius);
    sum += value[i];
    sum_abs += std::abs(value[i]);
  }
  if (!(sum_abs > 0)) {
    // Narrower than doubles can tell from its tail: as good as a point, and so as even.
    std::fill(value.begin(), value.end(), 1.0);
    sum = sum_abs = kBins;
  }
  double running = 0;
  axis.cdf.push_back(0);
  for (int i = 0; i < kBins; ++i) {
    running += std::abs(value[i]);
    axis.cdf.push_back(static_cast<float>(running / sum_abs));
    axis.weight.push_back(static_cast<float>(std::copysign(sum_abs / sum, value[i])));
  }
  axis.cdf.back() = 1;
  return axis;
}

}  // namespace

double evaluate_filter(const FilterSpec& spec, double x, double radius) {
  if (std::abs(x) > radius) return 0;
  switch (spec.kind) {
    case FilterKind::kBox:
      return 1;
    case FilterKind::kTriangle:
      return radius - std::abs(x);
    case FilterKind::kGaussian:
      return std::fmax(0, gaussian(x, spec.sigma) - gaussian(radius, spec.sigma));
    case FilterKind::kMitchell:
      return mitchell(2 * x / radius, spec.b, spec.c);
    case FilterKind::kLanczos:
      return sinc(x) * sinc(x / spec.tau);
  }
  return 0;
}

PixelFilterRecord PixelFilterRecord::build(const FilterSpec& spec) {
  return {spec.kind, build_axis(spec, spec.radius_x), build_axis(spec, spec.radius_y)};
}

}  // namespace tessera::render
