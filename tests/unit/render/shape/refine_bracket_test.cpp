// Newton's method within a bracket notices that it has arrived.
#include "render/shape/implicit/refine_bracket.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/core/wide.h"
#include "render/shape/implicit/double_functions.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// sin(rate s) - height in each lane; counts its evaluations.
struct CountedSine {
  Double rate, height;
  mutable int slopes = 0;

  Double operator()(Double s) const { return sine(rate * s) - height; }
  Dual<Double, 1> with_slope(Double s) const {
    ++slopes;
    return {sine(rate * s) - height, {rate * cosine(rate * s)}};
  }
};

/// |f''| is at most 0.64 and f' at least 0.55 over [0, 1], so an error e becomes 0.6 e^2 at most: from 1/2,
/// below 2^-48 after five steps, which the sixth slope notices. A search that then halves takes dozens more.
TEST(RefineBracket, StopsOnceItIsAtTheRoot) {
  for (int k = 0; k < 32; ++k) {
    alignas(64) double heights[kWidth], roots[kWidth];
    for (int i = 0; i < kWidth; ++i)
      heights[i] = std::sin(0.9 * (0.05 + 0.9 * (k * kWidth + i) / (32.0 * kWidth)));
    const CountedSine f{Double(0.9), Double::load(heights)};
    refine_bracket(f, Double(0.0), Double(1.0), Mask::all()).store(roots);
    EXPECT_LE(f.slopes, 6);
    // Sines are right to 2^-52, and rise by at least 0.55 a unit.
    for (int i = 0; i < kWidth; ++i) EXPECT_NEAR(roots[i], std::asin(heights[i]) / 0.9, 0x1p-48);
  }
}

/// t + 0.3 t^2 - height in each lane, in floats; counts its evaluations.
struct CountedSquare {
  Float height;
  mutable int slopes = 0;

  Float operator()(Float t) const { return fma(fma(Float(0.3f), t, 1.0f), t, -height); }
  Dual<Float, 1> with_slope(Float t) const {
    ++slopes;
    return {(*this)(t), {fma(Float(0.6f), t, 1.0f)}};
  }
};

/// f'' is 0.6 and f' at least 1 over [0, 1], so an error e becomes 0.3 e^2 at most. The line through the ends
/// is off by 0.6 / 8 = 0.075 at most: three steps lead to 2e-3, 9e-7 and the last bits. The product with t
/// rounds f by 2^-24, so the step that notices is below 2^-22, with the error before it. A search that halves
/// a bracket of which one end is the root goes on with 20 steps.
TEST(RefineBracket, StopsOnceItIsAtTheRootInFloats) {
  for (int k = 0; k < 32; ++k) {
    alignas(64) float heights[kWidth], roots[kWidth];
    for (int i = 0; i < kWidth; ++i)
      heights[i] = static_cast<float>(1.3 * (0.02 + 0.96 * (k * kWidth + i) / (32.0 * kWidth)));
    const CountedSquare f{Float::load(heights)};
    const Float start = f.height / 1.3f;
    refine_bracket(f, Float(0.0f), Float(1.0f), start, Mask::all(), Float(0x1p-22f)).store(roots);
    EXPECT_LE(f.slopes, 4);
    for (int i = 0; i < kWidth; ++i)
      EXPECT_NEAR(roots[i], (std::sqrt(1 + 1.2 * heights[i]) - 1) / 0.6, 0x1p-22);
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
