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

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
