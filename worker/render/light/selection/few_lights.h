// Picking one of lights so few that all are children of a light tree's root: light by light for 16 points at
// once, instead of point by point for 16 lights at once. The same bits either way.
#pragma once

#include "render/core/constants.h"
#include "render/light/selection/importance.h"

namespace tessera::render::TESSERA_ISA {

class FewLights {
 public:
  struct Choice {
    Int light;
    Float probability;  // zero where no light reaches
    Float u;            // what is left of the number that chose, uniform in [0, 1) again
  };

  /// Whether these are all lights of the tree, and no more than there are points.
  static TESSERA_INLINE bool suit(const LightTree& tree, Mask points) {
    return tree.few > 0 && tree.few <= count(points);
  }

  TESSERA_INLINE FewLights(const LightTree& tree, const Receiver& from)
      : links_(tree.nodes[0].link), size_(tree.few) {
    const LitPoint at(from.p, from.normal);
    for (int k = 0; k < kLightTreeWidth; ++k)
      each_[k] = k < size_ ? importance(LightClusters::one(tree.nodes[0], k), at) : Float(0.0f);
    total_ = sum_of_fours(each_, fours_);
  }

  /// A light for each point; `u` is uniform in [0, 1).
  TESSERA_INLINE Choice pick(Float u, Mask points) const {
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
    const Int link = gather(links_, i, points);
    return {select(link < 0, -1 - link, Int(0)), share(weight),
            select(rest < kOneMinusEpsilon, rest, kOneMinusEpsilon)};
  }

  /// The probability of the root's children.
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

  const std::int32_t* links_;
  int size_;
  Float each_[kLightTreeWidth], fours_[kFours], total_;
};

}  // namespace tessera::render::TESSERA_ISA
