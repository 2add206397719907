// Filtered look-ups in the pyramid of an image, 16 places at a time.
#pragma once

#include "render/color/spectrum.h"
#include "render/color/texture_table.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// The half-axes of a footprint in (s, t).
struct TexelFootprint {
  Vec2 a, b;
};

/// One pyramid with the way it is read. Coordinates are as for ImageLookup.
class MipLookup {
 public:
  /// `channel` is as in TextureNode.
  TESSERA_INLINE MipLookup(const MipPyramid& pyramid, WrapModes wrap, std::int32_t channel)
      : pyramid_(pyramid), wrap_(wrap), channel_(channel) {}

  /// At full resolution.
  Color bilinear(Vec2 st, Mask active) const { return scaled(at_level(st, Int(0), active)); }

  /// Look-up in two levels, whose texels are as wide as the shorter axis of the footprint: what is thinner
  /// along one way than a texel stays sharp, and along the other is left to the samples of the pixel.
  Color trilinear(Vec2 st, const TexelFootprint& footprint, Mask active) const {
    return scaled(between_levels(st, level_of(axes(footprint).shorter), active));
  }

  /// Trilinear look-ups along the longer axis of the footprint, weighted by a Gaussian [McCormack et al.
  /// 1999]. Where it is more than `max_anisotropy` times as long as the shorter one, that is made longer.
  Color elliptic(Vec2 st, const TexelFootprint& footprint, float max_anisotropy, Mask active) const {
    const Axes ellipse = axes(footprint);
    const Float shorter = max(ellipse.shorter, ellipse.longer * (1 / max_anisotropy));
    const Float level = level_of(shorter);
    const Float probes = clamp(floor(ellipse.longer / max(shorter, 1e-30f) + 0.999f), 1.0f, max_anisotropy);
    const float most = reduce_max(select(active, probes, 1.0f));
    Color sum(0.0f);
    Float weights(0.0f);
    for (float i = 0; i < most; ++i) {
      const Mask lanes = active & (probes > i);
      const Float along = (2 * i + 1) / probes - 1.0f;  // -1 to 1; one probe alone is in the middle
      const Float weight = select_or_zero(lanes, exp(-2.0f * sqr(along)));
      const Vec2 place{fma(ellipse.direction.x, along, st.x), fma(ellipse.direction.y, along, st.y)};
      sum += select_or_zero(lanes, between_levels(place, level, lanes)) * weight;
      weights = weights + weight;
    }
    return scaled(sum * (1.0f / max(weights, 1e-30f)));
  }

 private:
  /// Half-axes of the ellipse that a footprint's two half-axes (which need not be at right angles) span:
  /// lengths in texels of full resolution, the longer one also as a vector in (s, t).
  struct Axes {
    Float longer, shorter;
    Vec2 direction;
  };

  Axes axes(const TexelFootprint& footprint) const {
    const MipLevel& full = pyramid_.levels.front();
    const auto width = static_cast<float>(full.width), height = static_cast<float>(full.height);
    const Vec2 a{footprint.a.x * width, footprint.a.y * height},
        b{footprint.b.x * width, footprint.b.y * height};
    // Singular values of the matrix of both: eigenvalues of its product with its transpose.
    const Float xx = fma(a.x, a.x, b.x * b.x), yy = fma(a.y, a.y, b.y * b.y), xy = fma(a.x, a.y, b.x * b.y);
    const Float area = abs(difference_of_products(a.x, b.y, a.y, b.x));
    const Float half = 0.5f * (xx - yy), root = sqrt(fma(half, half, xy * xy));
    const Float largest = fma(xx + yy, Float(0.5f), root), longer = sqrt(largest);
    // (cos, sin) of the axis, by the column of (matrix - other eigenvalue) that does not cancel.
    const Vec2 column{select(half > 0.0f, half + root, xy), select(half > 0.0f, xy, root - half)};
    const Float column_length = sqrt(fma(column.x, column.x, column.y * column.y));
    const Float scale = select_or_zero(column_length > 0.0f, longer / max(column_length, Float(1e-30f)));
    return {longer,
            area / max(longer, Float(1e-30f)),
            {column.x * scale * (1 / width), column.y * scale * (1 / height)}};
  }

  /// The level whose texels are twice as wide as a half-axis: as wide as the whole axis. At least 0, and
  /// finite.
  Float level_of(Float half_axis) const {
    const auto last = static_cast<float>(pyramid_.levels.size() - 1);
    constexpr float kPerOctave = 1.44269504089f;
    return clamp(kPerOctave * log(clamp(2.0f * half_axis, 1.0f, 1e9f)), 0.0f, last);
  }

  /// Texels that a look-up reads along one axis: two neighbours, of which one may have no weight.
  struct Pair {
    Int first, second;
    Float first_weight, second_weight;
  };

  static Pair pair(Float s, WrapMode wrap, Int resolution) {
    const Float n = to_float(resolution);
    if (wrap == WrapMode::kRepeat) {
      const Float x = fma(s - floor(s), n, Float(-0.5f)), whole = floor(x), t = x - whole;
      const Int i = to_int(whole), first = select(i < 0, resolution - 1, i), next = first + 1;
      return {first, select(next == resolution, Int(0), next), 1.0f - t, t};
    }
    if (wrap == WrapMode::kMirror) {
      s = s - 2.0f * floor(s * 0.5f);
      s = min(s, 2.0f - s);
    }
    // A pixel beyond either side is as good as any.
    const Float unbounded = fma(clamp(s, -1.0f, 2.0f), n, Float(-0.5f));
    const Float x = wrap == WrapMode::kBlack ? unbounded : min(max(unbounded, Float(0.0f)), n - 1.0f);
    const Float whole = floor(x), t = x - whole;
    const Int i = to_int(whole), last = resolution - 1;
    Pair pair{min(max(i, 0), last), min(max(i + 1, 0), last), 1.0f - t, t};
    if (wrap == WrapMode::kBlack) {
      pair.first_weight = select_or_zero((i >= 0) & (i <= last), pair.first_weight);
      pair.second_weight = select_or_zero((i >= -1) & (i < last), pair.second_weight);
    }
    return pair;
  }

  /// The columns as they are read: the second is the neighbour in memory of the first.
  Pair columns(Float s, Int resolution) const {
    Pair result = pair(s, wrap_.u, resolution);
    if (wrap_.u == WrapMode::kRepeat) return result;  // the first texel follows the last of a row
    const Mask before = (result.second == result.first) & (result.first == 0);
    // Left of the first texel (black): that is the second of the pair.
    result.first_weight = select(before, result.first_weight + result.second_weight, result.first_weight);
    result.second_weight = select_or_zero(result.second != result.first, result.second_weight);
    return result;
  }

  Color between_levels(Vec2 st, Float level, Mask active) const {
    const Float whole = floor(level), t = level - whole;
    const Int lower = to_int(whole);
    const Color fine = at_level(st, lower, active);
    const Mask blended = active & (t > 0.0f);
    if (none(blended)) return fine;
    const Int last(static_cast<std::int32_t>(pyramid_.levels.size()) - 1);
    return lerp(t, fine, at_level(st, min(lower + 1, last), blended));
  }

  Color at_level(Vec2 st, Int level, Mask active) const {
    const Int4 record =
        gather4(reinterpret_cast<const std::int32_t*>(pyramid_.levels.data()), level * 4, active);
    const Int &first = record.c[0], &width = record.c[1], &height = record.c[2], &stride = record.c[3];
    const Pair x = columns(st.x, width), y = pair(1.0f - st.y, wrap_.v, height);
    return row(first + y.first * stride + x.first, x, active) * y.first_weight +
           row(first + y.second * stride + x.first, x, active) * y.second_weight;
  }

  /// Two texels from `texel` on, weighted.
  Color row(Int texel, const Pair& x, Mask active) const {
    return pyramid_.texels16.empty() ? float_row(texel, x, active) : packed_row(texel, x, active);
  }

  Color float_row(Int texel, const Pair& x, Mask active) const {
    const float* const base = pyramid_.texels32.data();
    const Float4 one = gather4(base, texel * 4, active), two = gather4(base + 4, texel * 4, active);
    const auto channel = [&](int c) { return fma(one.c[c], x.first_weight, two.c[c] * x.second_weight); };
    if (channel_ >= 0) return Color(channel(channel_));
    return color_of(channel);
  }

  Color packed_row(Int texel, const Pair& x, Mask active) const {
    const Wide4<std::uint32_t> two = gather4(pyramid_.texels16.data(), texel * 2, active);
    const auto channel = [&](int c) {
      const auto value = [&](UInt packed) {
        return to_float(bit_cast<std::int32_t>(c % 2 == 0 ? packed & 0xffffu : shift_right<16>(packed)));
      };
      return fma(value(two.c[c / 2]), x.first_weight, value(two.c[2 + c / 2]) * x.second_weight);
    };
    if (channel_ >= 0) return Color(channel(channel_));
    return color_of(channel);
  }

  Color scaled(Color value) const { return pyramid_.texels16.empty() ? value : value * (1.0f / 65535); }

  const MipPyramid& pyramid_;
  const WrapModes wrap_;
  const std::int32_t channel_;
};

}  // namespace tessera::render::TESSERA_ISA
