// One ray, prepared for the tests of boxes, planes and triangles that a walk makes.
//
// Primitives are met in double (meet.h), so a hit is where it is said to be within a few roundings of a float
// at most. Cells and boxes are met in float, each taken to be wider by `pad` on all sides: 2^-20 of the
// largest coordinate that takes part. That is more than all those roundings together, so that no walk leaves
// out a cell with a hit in it, and all structures find the same hits to the last bit.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

#include "render/accel/structure/primitive.h"
#include "render/core/wide.h"
#include "render/shape/exact_affine.h"

namespace tessera::render::TESSERA_ISA {

struct Ray {
  double o[3], d[3];          // d: any length; in an object's space these are not floats
  float of[3], df[3];         // rounded: for tests of shapes and filters
  float pad;                  // margin of boxes
  float inverse[3];           // 1 / d, bounded
  float low_o[3], high_o[3];  // taken off lower and upper ends of boxes
  int x, y, z;                // z: where the direction's largest component is [Woop, Benthin & Wald 2013]
  double shear_x, shear_y, inverse_z;
  float time;

  /// `largest`: coordinate of what it is to meet.
  Ray(const double (&origin)[3], const double (&direction)[3], float at_time, float largest) : time(at_time) {
    float reach = largest;
    for (int k = 0; k < 3; ++k) {
      o[k] = origin[k], d[k] = direction[k];
      of[k] = static_cast<float>(o[k]), df[k] = static_cast<float>(d[k]);
      reach = std::max(reach, std::abs(of[k]));
    }
    pad = 0x1p-20f * reach;
    constexpr float kLargest = 1e30f;  // a box's end times this has no bound that a ray's length could reach
    for (int k = 0; k < 3; ++k) {
      const float inv = 1.0f / df[k];
      inverse[k] = std::abs(inv) <= kLargest ? inv : std::copysign(kLargest, df[k]);
      low_o[k] = of[k] + pad, high_o[k] = of[k] - pad;
    }
    z = std::abs(d[0]) > std::abs(d[1]) ? 0 : 1;
    z = std::abs(d[2]) > std::abs(d[z]) ? 2 : z;
    x = z == 2 ? 0 : z + 1, y = x == 2 ? 0 : x + 1;
    inverse_z = 1 / d[z];
    shear_x = d[x] * inverse_z, shear_y = d[y] * inverse_z;
  }

  /// False in the space of an instance without extent.
  bool sound() const {
    for (int k = 0; k < 3; ++k) {
      if (!std::isfinite(of[k]) || !std::isfinite(df[k])) return false;
    }
    return d[z] != 0;
  }

  struct Interval {
    float enter, leave;
    bool empty() const { return !(enter <= leave); }
  };
  /// Where the ray, from its origin on, is within a box.
  Interval within(const float* low, const float* high) const {
    Interval in{0, __builtin_inff()};
    for (int k = 0; k < 3; ++k) {
      float a = (low[k] - low_o[k]) * inverse[k], b = (high[k] - high_o[k]) * inverse[k];
      if (inverse[k] < 0) std::swap(a, b);
      in.enter = a > in.enter ? a : in.enter;
      in.leave = b < in.leave ? b : in.leave;
    }
    return in;
  }
};

/// The ray as an object's own space has it.
inline Ray moved(const Ray& ray, const ExactAffine& object_from_render, float largest) {
  double o[3], d[3];
  for (int i = 0; i < 3; ++i) {
    const double* const row = object_from_render.m + 4 * i;
    o[i] = row[0] * ray.o[0] + row[1] * ray.o[1] + row[2] * ray.o[2] + row[3];
    d[i] = row[0] * ray.d[0] + row[1] * ray.d[1] + row[2] * ray.d[2];
  }
  return {o, d, ray.time, largest};
}

}  // namespace tessera::render::TESSERA_ISA
