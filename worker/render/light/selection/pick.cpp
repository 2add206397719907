#include "render/light/selection/pick.h"

#include "render/light/light_access.h"
#include "render/sampling/discrete.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Least part of what comes in from lights that a node's estimate may say: normals may be bent, a mix has
/// two, and the mean over many lights is a guess.
constexpr float kLeastPart = 0.02f;

/// One receiver, the same in all lanes.
struct OneReceiver {
  Vec3 p, normal;
  bool on_surface;
};

/// The mean of max(cos, 0) over directions of which the mean vector has a length of `mean` and a cosine of
/// `cosine` with what they are measured against. Exact for one direction and for all.
Float mean_cosine(Float cosine, Float mean) {
  const Float c = cosine * mean;
  return 0.5f * (c + safe_sqrt(fma(c, c, 0.25f * fnma(mean, mean, Float(1.0f)))));
}

/// Light that each of a node's sixteen children may bring to the receiver, were nothing in between: intensity
/// over distance squared, times the cosines at either end, as means over the child's directions and extent.
/// Zero for what turns its back on the receiver.
Float importance(const LightTreeNode& node, const OneReceiver& at) {
  const Vec3 centre{Float::load(node.centre[0]), Float::load(node.centre[1]), Float::load(node.centre[2])};
  const Vec3 axis{Float::load(node.axis[0]), Float::load(node.axis[1]), Float::load(node.axis[2])};
  const Float radius = Float::load(node.radius);
  const Vec3 to = at.p - centre;
  const Float distance_squared = length_squared(to);
  const Float inverse = 1.0f / max(sqrt(distance_squared), 1e-18f);
  // The cone under which the receiver sees the sphere about them.
  const Float sin_seen = radius * inverse;
  const Mask outside = sin_seen < 1.0f;
  const Float cos_seen = select(outside, safe_sqrt(fnma(sin_seen, sin_seen, Float(1.0f))), -1.0f);
  const Float mean_seen = fma(cos_seen, Float(0.5f), Float(0.5f));

  Float cos_off = dot(axis, to) * inverse;
  cos_off = select(Int::load(node.two_sided) != 0, abs(cos_off), cos_off);
  const Float sin_off = safe_sqrt(fnma(cos_off, cos_off, Float(1.0f)));
  const Float cos_least = select(cos_off >= cos_seen, 1.0f, fma(cos_off, cos_seen, sin_off * sin_seen));
  const Mask reaches = ~(outside & (cos_least <= Float::load(node.cos_reach)));

  Float part = max(mean_cosine(cos_off, Float::load(node.mean) * mean_seen), kLeastPart);
  if (at.on_surface) part = part * max(mean_cosine(-dot(at.normal, to) * inverse, mean_seen), kLeastPart);
  const Float spread = max(max(distance_squared, sqr(radius) * 0.25f), 1e-37f);
  return select_or_zero(reaches, Float::load(node.intensity) * part / spread);
}

/// Weights of a node's children, one by one and in fours: sums of four do not wait for each other.
struct Weights {
  alignas(64) float each[kWidth];
  float quads[4];
  float total;

  explicit Weights(Float weights) {
    weights.store(each);
    for (int q = 0; q < 4; ++q)
      quads[q] = (each[4 * q] + each[4 * q + 1]) + (each[4 * q + 2] + each[4 * q + 3]);
    total = (quads[0] + quads[1]) + (quads[2] + quads[3]);
  }
  /// Probability of a child; zero for all where nothing can be reached.
  float probability(int child) const { return total > 0 ? each[child] / total : 0; }
};

/// A child, and what is left of the number that chose it, uniform again.
struct Child {
  int index;
  float u;
};

Child pick_child(const Weights& weights, float u) {
  float left = u * weights.total;
  int q = 0;
  while (q < 3 && left >= weights.quads[q]) left -= weights.quads[q++];
  int i = 4 * q;
  while (i < 4 * q + 3 && left >= weights.each[i]) left -= weights.each[i++];
  // Roundings may lead to the end of a row that ends with nothing.
  while (i > 0 && !(weights.each[i] > 0)) --i;
  const float rest = left / weights.each[i];
  return {i, rest < kOneMinusEpsilon ? rest : kOneMinusEpsilon};
}

/// The receivers of 16 lanes, to be taken one by one.
struct ReceiverLanes {
  alignas(64) float p[3][kWidth], n[3][kWidth];

  explicit ReceiverLanes(const Receiver& from) {
    const Float values[] = {from.p.x, from.p.y, from.p.z, from.normal.x, from.normal.y, from.normal.z};
    for (int c = 0; c < 3; ++c) {
      values[c].store(p[c]);
      values[3 + c].store(n[c]);
    }
  }
  OneReceiver lane(int l) const {
    return {{Float(p[0][l]), Float(p[1][l]), Float(p[2][l])},
            {Float(n[0][l]), Float(n[1][l]), Float(n[2][l])},
            n[0][l] != 0 || n[1][l] != 0 || n[2][l] != 0};
  }
};

/// Lane by lane: there are sixteen children to look at in each, and lanes are soon at nodes of their own.
LightPick pick_from_tree(const LightTree& tree, const Receiver& from, Float u, Mask active) {
  const int unbounded = static_cast<int>(tree.unbounded.size());
  const int ways = unbounded + (tree.nodes.empty() ? 0 : 1);
  const Float scaled = u * static_cast<float>(ways);
  const Int way = min(to_int(scaled), ways - 1);
  const Float left = min(scaled - to_float(way), kOneMinusEpsilon);
  LightPick pick{Int(0), Float(1.0f / static_cast<float>(ways)), left, active};
  if (unbounded > 0) pick.light = gather(tree.unbounded.data(), way, active & (way < unbounded));
  const Mask bounded = active & (way >= unbounded);
  if (none(bounded)) return pick;

  const ReceiverLanes receivers(from);
  alignas(64) float rest[kWidth], pmf[kWidth];
  alignas(64) std::int32_t light[kWidth];
  left.store(rest);
  pick.pmf.store(pmf);
  pick.light.store(light);
  for (std::uint32_t lanes = bounded.bits(); lanes != 0; lanes &= lanes - 1) {
    const int l = __builtin_ctz(lanes);
    const OneReceiver at = receivers.lane(l);
    std::int32_t link = 0;
    do {
      const LightTreeNode& node = tree.nodes[static_cast<std::size_t>(link)];
      const Weights weights(importance(node, at));
      // One number makes all the choices.
      const Child child = pick_child(weights, rest[l]);
      rest[l] = child.u;
      pmf[l] *= weights.probability(child.index);
      link = node.link[child.index];
    } while (link >= 0 && pmf[l] > 0);
    light[l] = link < 0 ? ~link : 0;
  }
  pick.pmf = Float::load(pmf);
  pick.light = Int::load(light);
  pick.u = Float::load(rest);
  pick.picked &= pick.pmf > 0.0f;
  return pick;
}

Float pmf_of_tree(const LightTree& tree, Int light, const Receiver& from, Mask at_infinity, Mask active) {
  Float shares = gather(tree.shares.data(), light, active);
  const Mask bounded = and_not(active & (shares > 0.0f), at_infinity);
  if (none(bounded)) return shares;
  const ReceiverLanes receivers(from);
  alignas(64) float pmf[kWidth];
  alignas(64) std::uint32_t paths[kWidth];
  shares.store(pmf);
  gather(tree.paths.data(), light, bounded).store(paths);
  for (std::uint32_t lanes = bounded.bits(); lanes != 0; lanes &= lanes - 1) {
    const int l = __builtin_ctz(lanes);
    const OneReceiver at = receivers.lane(l);
    std::int32_t link = 0;
    for (std::uint32_t path = paths[l]; link >= 0 && pmf[l] > 0; path >>= 4) {
      const LightTreeNode& node = tree.nodes[static_cast<std::size_t>(link)];
      const auto child = static_cast<int>(path & 15);
      pmf[l] *= Weights(importance(node, at)).probability(child);
      link = node.link[child];
    }
  }
  return Float::load(pmf);
}

}  // namespace

LightPick pick_light(const LightTable& table, const Receiver& from, Float u, Mask active) {
  if (!table.tree.empty()) return pick_from_tree(table.tree, from, u, active);
  const DiscreteSample choice = sample_discrete(table.selection, u, active);
  return {choice.index, choice.pmf, choice.u, active};
}

Float pick_pmf(const LightTable& table, Int light, const Receiver& from, Mask active) {
  if (table.tree.empty()) return discrete_pmf(table.selection, light, active);
  Mask at_infinity = Mask::none();
  for_each_distinct(kind_of(table, light, active), active, [&](std::int32_t kind, Mask lanes) {
    if (light_model(static_cast<LightKind>(kind)).traits.at_infinity) at_infinity |= lanes;
  });
  return pmf_of_tree(table.tree, light, from, at_infinity, active);
}

}  // namespace tessera::render::TESSERA_ISA
