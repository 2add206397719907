// Importance-sampled pixel filters: a sample belongs to one pixel, and the filter decides where about it.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

enum class FilterKind : std::int32_t { kBox, kTriangle, kGaussian, kMitchell, kLanczos };

struct FilterSpec {
  FilterKind kind = FilterKind::kBox;
  float radius_x = 0.5f, radius_y = 0.5f;  // pixels
  float sigma = 0.5f;                      // Gaussian, pixels
  float b = 1.0f / 3, c = 1.0f / 3;        // Mitchell
  float tau = 3;                           // Lanczos
};

/// One axis of a separable filter: the distribution |f| over [-radius, radius] as equal bins.
struct FilterAxis {
  float radius = 0.5f;
  std::vector<float> cdf;  // bins + 1 values from 0 to 1
  std::vector<float>
      weight;  // a bin's sign times (integral of |f|) / (integral of f): the weights average to 1
};

/// Box and triangle are sampled in closed form and have no tables.
struct PixelFilterRecord {
  FilterKind kind = FilterKind::kBox;
  FilterAxis x, y;

  static PixelFilterRecord build(const FilterSpec& spec);
};

/// f at `x` pixels from the centre along one axis; not normalised.
double evaluate_filter(const FilterSpec& spec, double x, double radius);

}  // namespace tessera::render
