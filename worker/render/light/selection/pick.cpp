#include "render/light/selection/pick.h"

#include "render/light/light_access.h"
#include "render/light/selection/few_lights.h"
#include "render/light/selection/importance.h"
#include "render/sampling/discrete.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Weights of a node's children.
struct Weights {
  alignas(64) float each[kWidth];
  float fours[4];
  float total;

  explicit Weights(Float weights) {
    weights.store(each);
    total = sum_of_fours(each, fours);
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
  while (q < 3 && left >= weights.fours[q]) left -= weights.fours[q++];
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
  LitPoint lane(int l) const {
    return {{Float(p[0][l]), Float(p[1][l]), Float(p[2][l])},
            {Float(n[0][l]), Float(n[1][l]), Float(n[2][l])}};
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

  if (FewLights::suit(tree, bounded)) {
    const FewLights few(tree, from);
    const FewLights::Choice choice = few.pick(left, bounded);
    pick.light = select(bounded, choice.light, pick.light);
    pick.pmf = select(bounded, pick.pmf * choice.probability, pick.pmf);
    pick.u = select(bounded, choice.u, pick.u);
    pick.picked &= pick.pmf > 0.0f;
    return pick;
  }

  const ReceiverLanes receivers(from);
  alignas(64) float rest[kWidth], pmf[kWidth];
  alignas(64) std::int32_t light[kWidth];
  left.store(rest);
  pick.pmf.store(pmf);
  pick.light.store(light);
  for (std::uint32_t lanes = bounded.bits(); lanes != 0; lanes &= lanes - 1) {
    const int l = __builtin_ctz(lanes);
    const LitPoint at = receivers.lane(l);
    std::int32_t link = 0;
    do {
      const LightTreeNode& node = tree.nodes[static_cast<std::size_t>(link)];
      const Weights weights(importance(LightClusters::all(node), at));
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
  const UInt ways = gather(tree.paths.data(), light, bounded);
  if (FewLights::suit(tree, bounded)) {
    const Float chosen = FewLights(tree, from).probability(bit_cast<std::int32_t>(ways));
    return select(bounded, shares * chosen, shares);
  }
  const ReceiverLanes receivers(from);
  alignas(64) float pmf[kWidth];
  alignas(64) std::uint32_t paths[kWidth];
  shares.store(pmf);
  ways.store(paths);
  for (std::uint32_t lanes = bounded.bits(); lanes != 0; lanes &= lanes - 1) {
    const int l = __builtin_ctz(lanes);
    const LitPoint at = receivers.lane(l);
    std::int32_t link = 0;
    for (std::uint32_t path = paths[l]; link >= 0 && pmf[l] > 0; path >>= 4) {
      const LightTreeNode& node = tree.nodes[static_cast<std::size_t>(link)];
      const auto child = static_cast<int>(path & 15);
      pmf[l] *= Weights(importance(LightClusters::all(node), at)).probability(child);
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
