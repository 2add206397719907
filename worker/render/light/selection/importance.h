// By how much one light, or one part of many, is preferred to another.
#pragma once

#include "render/light/light.h"
#include "render/light/selection/light_tree.h"

namespace tessera::render::TESSERA_ISA {

/// Children of a LightTreeNode, whose members these are.
struct LightClusters {
  Vec3 centre, axis;
  Float radius, most_spread, mean, cos_reach, sin_reach, intensity;
  Mask two_sided;

  /// All of them, one a lane.
  static TESSERA_INLINE LightClusters all(const LightTreeNode& node) {
    const auto load3 = [](const float(&rows)[3][kLightTreeWidth]) {
      return Vec3{Float::load(rows[0]), Float::load(rows[1]), Float::load(rows[2])};
    };
    return {load3(node.centre),
            load3(node.axis),
            Float::load(node.radius),
            Float::load(node.most_spread),
            Float::load(node.mean),
            Float::load(node.cos_reach),
            Float::load(node.sin_reach),
            Float::load(node.intensity),
            Int::load(node.two_sided) != 0};
  }
  /// The child `k`, in all lanes.
  static TESSERA_INLINE LightClusters one(const LightTreeNode& node, int k) {
    const auto spread3 = [k](const float(&rows)[3][kLightTreeWidth]) {
      return Vec3{Float(rows[0][k]), Float(rows[1][k]), Float(rows[2][k])};
    };
    return {spread3(node.centre),       spread3(node.axis),       Float(node.radius[k]),
            Float(node.most_spread[k]), Float(node.mean[k]),      Float(node.cos_reach[k]),
            Float(node.sin_reach[k]),   Float(node.intensity[k]), Int(node.two_sided[k]) != 0};
  }
};

/// Where light is to arrive: a Receiver's members.
struct LitPoint {
  Vec3 p, normal;
  Mask on_surface;  // there is a normal

  TESSERA_INLINE LitPoint(Vec3 point, Vec3 shading_normal)
      : p(point),
        normal(shading_normal),
        on_surface((normal.x != 0.0f) | (normal.y != 0.0f) | (normal.z != 0.0f)) {}
};

/// Receivers of 16 lanes, to be taken one by one.
struct ReceiverLanes {
  alignas(64) float p[3][kWidth], n[3][kWidth];

  explicit ReceiverLanes(const Receiver& from) {
    const Float values[] = {from.p.x, from.p.y, from.p.z, from.normal.x, from.normal.y, from.normal.z};
    for (int c = 0; c < 3; ++c) {
      values[c].store(p[c]);
      values[3 + c].store(n[c]);
    }
  }
  TESSERA_INLINE LitPoint lane(int l) const {
    return {{Float(p[0][l]), Float(p[1][l]), Float(p[2][l])},
            {Float(n[0][l]), Float(n[1][l]), Float(n[2][l])}};
  }
};

namespace detail {

/// Least part of what comes in from lights that an estimate may say: normals may be bent, a mix has two, and
/// the mean over many lights is a guess.
inline constexpr float kLeastPart = 0.02f;

/// Roundings of cosines: so nearly turned away, lights are not taken for dark.
inline constexpr float kSlack = 2e-6f;

/// The mean of max(cos, 0) over directions of which the mean vector has a length of `mean` and a cosine of
/// `cosine` with what they are measured against. Exact for one direction and for all.
TESSERA_INLINE Float mean_cosine(Float cosine, Float mean) {
  const Float c = cosine * mean;
  return 0.5f * (c + safe_sqrt(fma(c, c, 0.25f * fnma(mean, mean, Float(1.0f)))));
}

}  // namespace detail

/// Light that lights may bring to a point, were nothing in between: intensity over distance squared, times
/// the cosines at either end, as means over the lights' directions and extent. Zero where they turn their
/// backs on it.
TESSERA_INLINE Float importance(const LightClusters& lights, const LitPoint& at) {
  const Vec3 to = at.p - lights.centre;
  const Float distance_squared = length_squared(to);
  const Float inverse = 1.0f / max(sqrt(distance_squared), 1e-18f);
  // The cone under which the point sees the sphere about them.
  const Float sin_seen = lights.radius * inverse;
  const Mask outside = sin_seen < 1.0f;
  const Float cos_seen = select(outside, safe_sqrt(fnma(sin_seen, sin_seen, Float(1.0f))), -1.0f);
  const Float mean_seen = fma(cos_seen, Float(0.5f), Float(0.5f));

  Float cos_off = dot(lights.axis, to) * inverse;
  cos_off = select(lights.two_sided, abs(cos_off), cos_off);
  // They all turn away where it is seen at least as far off the axis as they reach from any point of the
  // sphere.
  const Float cos_all = fnma(lights.sin_reach, sin_seen, lights.cos_reach * cos_seen);
  const Mask dark = outside & (cos_seen > -lights.cos_reach) & (cos_off < cos_all - detail::kSlack);

  Float part = max(detail::mean_cosine(cos_off, lights.mean * mean_seen), detail::kLeastPart);
  if (any(at.on_surface)) {
    const Float received =
        max(detail::mean_cosine(-dot(at.normal, to) * inverse, mean_seen), detail::kLeastPart);
    part = part * select(at.on_surface, received, 1.0f);
  }
  const Float spread = min(sqr(inverse), lights.most_spread);
  return select_or_zero(~dark, lights.intensity * part * spread);
}

/// The sum of sixteen weights, and of each four: sums of four do not wait for each other.
template <class T>
TESSERA_INLINE T sum_of_fours(const T (&each)[kLightTreeWidth], T (&fours)[kLightTreeWidth / 4]) {
  for (int q = 0; q < kLightTreeWidth / 4; ++q)
    fours[q] = (each[4 * q] + each[4 * q + 1]) + (each[4 * q + 2] + each[4 * q + 3]);
  return (fours[0] + fours[1]) + (fours[2] + fours[3]);
}

}  // namespace tessera::render::TESSERA_ISA
