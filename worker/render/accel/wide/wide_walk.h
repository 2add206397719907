#pragma once

#include <algorithm>
#include <bit>
#include <functional>

#include "render/accel/structure/ray.h"
#include "render/accel/wide/wide_tree.h"

namespace tessera::render::TESSERA_ISA {

/// One ray against sixteen boxes at once.
class BoxRow {
 public:
  explicit TESSERA_INLINE BoxRow(const Ray& ray) {
    for (int k = 0; k < 3; ++k) {
      back_[k] = ray.inverse[k] < 0;
      near_origin_[k] = Float(back_[k] ? ray.high_o[k] : ray.low_o[k]);
      far_origin_[k] = Float(back_[k] ? ray.low_o[k] : ray.high_o[k]);
      inverse_[k] = Float(ray.inverse[k]);
    }
  }

  /// Bits of the boxes that the ray meets within [0, reach], and where it comes into them.
  TESSERA_INLINE std::uint32_t meet(const WideNode& node, float reach, float (&enter)[kWidth]) const {
    Float nearest(0.0f), farthest(reach);
    for (int k = 0; k < 3; ++k) {
      const Float near = Float::load(back_[k] ? node.high[k] : node.low[k]);
      const Float far = Float::load(back_[k] ? node.low[k] : node.high[k]);
      nearest = max(nearest, (near - near_origin_[k]) * inverse_[k]);
      farthest = min(farthest, (far - far_origin_[k]) * inverse_[k]);
    }
    nearest.store(enter);
    return (nearest <= farthest).bits();
  }

 private:
  bool back_[3];
  Float near_origin_[3], far_origin_[3], inverse_[3];
};

/// One ray against the triangles of a leaf, sixteen at once, in float: tells those apart that meet_triangle()
/// (meet.h) would not take, whatever was rounded here and there, and leaves the others to it.
///
/// With M the largest coordinate that takes part and e = 2^-24: a sheared corner is off by 14 e M at most (2
/// e M the difference of each coordinate and e M the origin's own rounding, along both axes; 2 e M each for
/// the shear's rounding and the product's; 4 e M for the last difference), which is below pad = 16 e M. A
/// product of two such, p q, is off by pad (|p| + |q|) + pad^2, and its own rounding, 2 e |p q|, is no more
/// than half of pad |p|, for |q| is no more than 4 M.
class TriangleRow {
 public:
  explicit TESSERA_INLINE TriangleRow(const Ray& ray)
      : x_(ray.x),
        y_(ray.y),
        z_(ray.z),
        ox_(ray.of[ray.x]),
        oy_(ray.of[ray.y]),
        oz_(ray.of[ray.z]),
        shear_x_(static_cast<float>(ray.shear_x)),
        shear_y_(static_cast<float>(ray.shear_y)),
        inverse_z_(static_cast<float>(ray.inverse_z)),
        pad_(ray.pad),
        pad_t_(ray.pad * std::abs(static_cast<float>(ray.inverse_z))) {}

  /// Bits of those of sixteen triangles that the ray may meet within (0, reach]. `rows`: nine of `stride`
  /// each.
  TESSERA_INLINE std::uint32_t meet(const float* rows, std::size_t stride, float reach) const {
    Float px[3], py[3], size[3], nearest, farthest;
    for (std::size_t c = 0; c < 3; ++c) {
      const float* const corner = rows + 3 * c * stride;
      const Float pz = Float::load_unaligned(corner + z_ * stride) - Float(oz_);
      px[c] = Float::load_unaligned(corner + x_ * stride) - Float(ox_) - Float(shear_x_) * pz;
      py[c] = Float::load_unaligned(corner + y_ * stride) - Float(oy_) - Float(shear_y_) * pz;
      size[c] = abs(px[c]) + abs(py[c]) + Float(pad_);
      const Float t = pz * Float(inverse_z_);
      nearest = c == 0 ? t : min(nearest, t);
      farthest = c == 0 ? t : max(farthest, t);
    }
    Mask below = Mask::none(), above = Mask::none();
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t p = (c + 2) % 3, q = (c + 1) % 3;
      constexpr float kUnderflow = 1e-36f;
      const Float w = px[p] * py[q] - py[p] * px[q];
      const Float off = Float(2 * pad_) * (size[p] + size[q]) + Float(kUnderflow);
      below |= w < Float(0.0f) - off;
      above |= w > off;
    }
    const Mask apart =
        (below & above) | (nearest - Float(pad_t_) > Float(reach)) | (farthest + Float(pad_t_) < Float(0.0f));
    return ~apart.bits() & 0xffffu;
  }

 private:
  std::size_t x_, y_, z_;
  float ox_, oy_, oz_, shear_x_, shear_y_, inverse_z_, pad_, pad_t_;
};

/// Shows the primitives of a leaf that may be met; true where the walk may end.
template <class Visitor>
TESSERA_INLINE bool meet_leaf(const WideTree& tree, const TriangleRow& triangles, std::int32_t child,
                              std::int32_t count, Visitor& visitor) {
  const auto first = static_cast<std::size_t>(~child);
  if (count < 0) {
    for (std::size_t i = first; i < first + static_cast<std::size_t>(-count); ++i) {
      if (visitor.meet(tree.items[i])) return true;
    }
    return false;
  }
  const auto n = static_cast<std::size_t>(count);
  for (std::size_t begin = 0; begin < n; begin += kWidth) {
    const float* const rows = tree.rows.data() + 9 * first + begin;
    std::uint32_t met = triangles.meet(rows, n, visitor.reach());
    if (n - begin < kWidth) met &= (1u << (n - begin)) - 1;
    for (; met != 0; met &= met - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(met));
      float corners[3][3];
      for (std::size_t c = 0; c < 9; ++c) corners[c / 3][c % 3] = rows[c * n + i];
      if (visitor.meet_corners(corners, tree.items[first + begin + i])) return true;
    }
  }
  return false;
}

/// Children of nodes that a walk has still to see, the last the nearest of those that were met together. Each
/// is one number: where the ray comes into it, as the bits of a float that is not negative and so keeps its
/// order, whose last four are the child's; then its node.
class WideStack {
 public:
  bool empty() const { return size_ == 0; }
  std::uint64_t pop() { return waiting_[--size_]; }

  /// Pushes the children of `met`; where `in_order`, the farthest first.
  TESSERA_INLINE void push(std::int32_t node, std::uint32_t met, const float (&enter)[kWidth],
                           bool in_order) {
    std::uint64_t* const place = waiting_ + size_;
    int n = 0;
    for (; met != 0; met &= met - 1) {
      const auto i = static_cast<std::uint32_t>(__builtin_ctz(met));
      const std::uint64_t key = (std::bit_cast<std::uint32_t>(enter[i]) & ~15u) | i;
      place[n++] = key << 32 | static_cast<std::uint32_t>(node);
    }
    size_ += n;
    if (!in_order || n < 2) return;
    const auto exchange = [place](int a, int b) {
      const std::uint64_t x = place[a], y = place[b];
      place[a] = std::max(x, y), place[b] = std::min(x, y);
    };
    if (n == 2) return exchange(0, 1);
    if (n <= 4) {
      if (n == 4) exchange(0, 1), exchange(2, 3), exchange(0, 2), exchange(1, 3), exchange(1, 2);
      if (n == 3) exchange(0, 1), exchange(1, 2), exchange(0, 1);
      return;
    }
    std::sort(place, place + n, std::greater<>());
  }

 private:
  static constexpr int kDeepest = 96;  // a BVH's, which is the deeper one
  std::uint64_t waiting_[(kWidth - 1) * kDeepest + kWidth];
  int size_ = 0;
};

/// Front to back: children that are met wait in the order of their distance, and are left out when something
/// nearer has been met by then.
template <class Visitor>
void walk_wide(const WideTree& tree, const Ray& ray, Visitor& visitor) {
  WideStack stack;
  const BoxRow boxes(ray);
  const TriangleRow triangles(ray);
  std::int32_t at = 0;
  for (;;) {
    visitor.enter();
    const WideNode& node = tree.nodes[static_cast<std::size_t>(at)];
    alignas(64) float enter[kWidth];
    const std::uint32_t met = boxes.meet(node, visitor.reach(), enter);
    stack.push(at, met, enter, !Visitor::kAnyHit);
    for (;;) {
      if (stack.empty()) return;
      const std::uint64_t next = stack.pop();
      if (std::bit_cast<float>(static_cast<std::uint32_t>(next >> 32) & ~15u) > visitor.reach()) continue;
      const WideNode& parent = tree.nodes[next & 0xffffffffu];
      const std::size_t i = next >> 32 & 15;
      at = parent.child[i];
      if (at >= 0) break;
      if (meet_leaf(tree, triangles, at, parent.count[i], visitor)) return;
    }
  }
}

}  // namespace tessera::render::TESSERA_ISA
