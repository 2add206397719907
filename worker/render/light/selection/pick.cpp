#include "render/light/selection/pick.h"

#include "render/light/light_access.h"
#include "render/light/selection/child_choice.h"
#include "render/sampling/discrete.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// The way of 16 points down the tree, level by level.
class Descent {
 public:
  Descent(const LightTree& tree, const Receiver& from, Mask points)
      : tree_(tree), from_(from), receivers_(from), going_(points) {}

  /// Points that are not at a light yet.
  Mask going() const { return going_; }
  /// Children that those points are to choose from.
  ChildChoice choice() const {
    // Child by child costs as much a child as point by point a point.
    if (at_root_ && tree_.root_children <= count(going_))
      return {tree_.nodes[0], tree_.root_children, LitPoint(from_.p, from_.normal)};
    return {tree_.nodes.data(), link_, receivers_, going_};
  }
  void go_to(Int child) {
    constexpr int kStride = sizeof(LightTreeNode) / 4;
    link_ = select(going_, gather(tree_.nodes[0].link, link_ * kStride + child, going_), link_);
    going_ &= link_ >= 0;
    at_root_ = false;
  }
  void stop(Mask points) { going_ = and_not(going_, points); }
  /// Where those that are at a light have come to; 0 elsewhere.
  Int light() const { return select(link_ < 0, -1 - link_, Int(0)); }

 private:
  const LightTree& tree_;
  const Receiver& from_;
  const ReceiverLanes receivers_;
  Mask going_;
  Int link_{0};  // the node that a point is at; ~light
  bool at_root_ = true;
};

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

  Descent descent(tree, from, bounded);
  while (any(descent.going())) {
    const Mask going = descent.going();
    // One number makes all the choices.
    const ChildChoice::Picked picked = descent.choice().pick(pick.u, going);
    pick.u = select(going, picked.u, pick.u);
    pick.pmf = select(going, pick.pmf * picked.probability, pick.pmf);
    descent.go_to(picked.child);
    descent.stop(~(pick.pmf > 0.0f));
  }
  pick.light = select(bounded, descent.light(), pick.light);
  pick.picked &= pick.pmf > 0.0f;
  return pick;
}

Float pmf_of_tree(const LightTree& tree, Int light, const Receiver& from, Mask at_infinity, Mask active) {
  Float pmf = gather(tree.shares.data(), light, active);
  const Mask bounded = and_not(active & (pmf > 0.0f), at_infinity);
  if (none(bounded)) return pmf;
  UInt path = gather(tree.paths.data(), light, bounded);
  Descent descent(tree, from, bounded);
  while (any(descent.going())) {
    const Int child = bit_cast<std::int32_t>(path & 15u);
    pmf = select(descent.going(), pmf * descent.choice().probability(child), pmf);
    descent.go_to(child);
    descent.stop(~(pmf > 0.0f));
    path = shift_right<4>(path);
  }
  return pmf;
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
