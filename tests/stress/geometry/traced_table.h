// A table of shapes in Embree's hands, and rays through it by the renderer's own code: its packets, its hit
// points, its offset rays.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "render/accel/embree/accelerator.h"
#include "render/accel/embree/trace.h"
#include "render/color/texture_table.h"
#include "render/shape/surface.h"
#include "support/kernel/double_point.h"
#include "support/long_form.h"

#define TESSERA_STRESS_STRING2(x) #x
#define TESSERA_STRESS_STRING(x) TESSERA_STRESS_STRING2(x)

namespace tessera::render::TESSERA_ISA {

/// Tests run `usual` times, or `at_length` times in their long form.
inline std::int64_t stress_count(double usual, double at_length) {
  return static_cast<std::int64_t>(test::long_form() ? at_length : usual);
}

using test::Point;
using test::unit;

/// Numbers in [0, 1) of a fixed sequence [Marsaglia 2003]: fast enough for 10^8 rays.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 1) {}
  double operator()() {
    state_ ^= state_ << 13, state_ ^= state_ >> 7, state_ ^= state_ << 17;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>((*this)() * static_cast<double>(n)); }
  /// Evenly over the unit sphere.
  Point direction() {
    const double z = 2 * (*this)() - 1, phi = 2 * M_PI * (*this)(), r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  std::uint64_t state_;
};

struct RayBatch {
  static constexpr int kSize = 256;
  alignas(64) float ox[kSize], oy[kSize], oz[kSize], dx[kSize], dy[kSize], dz[kSize];
  alignas(64) float t[kSize], u[kSize], v[kSize], distance[kSize];
  alignas(64) std::int32_t primitive[kSize], shape[kSize], instance[kSize], upper[kSize] = {};

  /// `d` of any length; rounded to floats as the renderer's own rays are.
  void set(int i, Point o, Point d) {
    const Point n = unit(d);
    ox[i] = static_cast<float>(o.x), oy[i] = static_cast<float>(o.y), oz[i] = static_cast<float>(o.z);
    dx[i] = static_cast<float>(n.x), dy[i] = static_cast<float>(n.y), dz[i] = static_cast<float>(n.z);
  }
  /// From a float origin towards a point.
  void aim(int i, Point o, Point target) {
    const Point from{static_cast<float>(o.x), static_cast<float>(o.y), static_cast<float>(o.z)};
    set(i, from, target - from);
  }
  Point origin(int i) const { return {ox[i], oy[i], oz[i]}; }
  Point direction(int i) const { return {dx[i], dy[i], dz[i]}; }
  RayArrays arrays() const { return {ox, oy, oz, dx, dy, dz}; }
};

class TracedTable {
 public:
  TracedTable(const ShapeTable& table, bool robust) : table_(table) {
    auto built = Accelerator::build(table, textures_, embree_kernel().callbacks,
                                    {1, TESSERA_STRESS_STRING(TESSERA_ISA), robust});
    EXPECT_TRUE(built.ok()) << built.status();
    accelerator_ = *std::move(built);
  }

  void nearest(RayBatch& r, int n = RayBatch::kSize, Traversal traversal = Traversal::kIncoherent) const {
    trace_nearest(accelerator_->scene(), r.arrays(), n, traversal,
                  static_cast<std::int32_t>(table_.shapes.size()),
                  {r.t, r.u, r.v, r.primitive, r.shape, r.instance, nullptr, r.upper},
                  table_.nested() ? &table_ : nullptr);
  }
  /// Surfaces that 16 rays from `first` on have met, which nearest() has traced.
  Surface surface(const RayBatch& r, int first) const {
    const Hit hit{Float::load(r.t + first),
                  Float::load(r.u + first),
                  Float::load(r.v + first),
                  Int::load(r.primitive + first),
                  Int::load(r.shape + first),
                  Int::load(r.instance + first),
                  Float(0.0f),
                  Int::load(r.upper + first)};
    return surface_at(table_, hit,
                      {Float::load(r.ox + first), Float::load(r.oy + first), Float::load(r.oz + first)},
                      {Float::load(r.dx + first), Float::load(r.dy + first), Float::load(r.dz + first)},
                      hit.shape >= 0, true);
  }
  /// Leaves a negative distance where something lies within it.
  void shadow(RayBatch& r, int n = RayBatch::kSize, Traversal traversal = Traversal::kIncoherent) const {
    trace_shadow(accelerator_->scene(), r.arrays(), n, traversal, r.distance);
  }

 private:
  const ShapeTable& table_;
  TextureTable textures_;
  std::unique_ptr<Accelerator> accelerator_;
};

}  // namespace tessera::render::TESSERA_ISA
