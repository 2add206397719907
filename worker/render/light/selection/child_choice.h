// One of a light tree node's children for each of 16 points: all at one node, or each at a node of its own.
#pragma once

#include "render/core/constants.h"
#include "render/light/light_access.h"
#include "render/light/selection/importance.h"

namespace tessera::render::TESSERA_ISA {

/// The children's weights, child by child, for 16 points at once. How they came about leaves no trace: the
/// same bits for a point whatever the others are at.
class ChildChoice {
 public:
  struct Picked {
    Int child;
    Float probability;  // zero where no light reaches
    Float u;            // rest of the number that chose, uniform in [0, 1) again
  };

  /// All points at `node`, which has `size` children: child by child.
  TESSERA_INLINE ChildChoice(const LightTreeNode& node, int size, const LitPoint& at) : size_(size) {
    for (int k = 0; k < kLightTreeWidth; ++k)
      each_[k] = k < size ? importance(LightClusters::one(node, k), at) : Float(0.0f);
    total_ = sum_of_fours(each_, fours_);
  }

  /// Point by point, each at its own of `nodes`: nothing else hangs on what is found for a point, so that the
  /// processor works on several of them.
  TESSERA_INLINE ChildChoice(const LightTreeNode* nodes, Int own, const ReceiverLanes& points, Mask active)
      : size_(kLightTreeWidth) {
    static_assert(kWidth == kLightTreeWidth);
    alignas(64) float rows[kWidth][kLightTreeWidth] = {};
    alignas(64) std::int32_t node[kWidth];
    own.store(node);
    for (std::uint32_t lanes = active.bits(); lanes != 0; lanes &= lanes - 1) {
      const int l = __builtin_ctz(lanes);
      importance(LightClusters::all(nodes[node[l]]), points.lane(l)).store(rows[l]);
    }
    const Int first = Int::iota(0) * kLightTreeWidth;
    for (int k = 0; k < kLightTreeWidth; ++k) each_[k] = gather(rows[0] + k, first);
    total_ = sum_of_fours(each_, fours_);
  }

  /// A child for each point; `u` is uniform in [0, 1).
  TESSERA_INLINE Picked pick(Float u, Mask points) const {
    Float left = u * total_;
    const Int four_of = passed(fours_, points, left);
    Float row[4];
    for (int s = 0; s < 4; ++s) {
      row[s] = each_[s];
      for (int q = 1; q < kFours; ++q) row[s] = select(four_of == q, each_[4 * q + s], row[s]);
    }
    Int i = four_of * 4 + passed(row, points, left);
    Float weight = weight_of(i);
    if (const Mask empty = points & ~(weight > 0.0f); any(empty)) {
      // Roundings may lead to the end of a row that ends with nothing.
      for (int k = kLightTreeWidth - 1; k > 0; --k)
        i = select(empty & (i == k) & ~(each_[k] > 0.0f), Int(k - 1), i);
      weight = weight_of(i);
    }
    const Float rest = left / weight;
    return {i, share(weight), select(rest < kOneMinusEpsilon, rest, kOneMinusEpsilon)};
  }

  /// The probability of a child.
  TESSERA_INLINE Float probability(Int child) const { return share(weight_of(child)); }

 private:
  static constexpr int kFours = kLightTreeWidth / 4;

  /// How many of the first three weights `left` is beyond, which are taken off it.
  static TESSERA_INLINE Int passed(const Float (&weights)[4], Mask on, Float& left) {
    Int n(0);
    for (int k = 0; k < 3; ++k) {
      on &= left >= weights[k];
      left = select(on, left - weights[k], left);
      n = select(on, Int(k + 1), n);
    }
    return n;
  }
  TESSERA_INLINE Float weight_of(Int child) const {
    Float weight = each_[0];
    for (int k = 1; k < size_; ++k) weight = select(child == k, each_[k], weight);
    return select_or_zero(child < size_, weight);
  }
  TESSERA_INLINE Float share(Float weight) const { return select_or_zero(total_ > 0.0f, weight / total_); }

  int size_;
  Float each_[kLightTreeWidth], fours_[kFours], total_;
};

}  // namespace tessera::render::TESSERA_ISA
