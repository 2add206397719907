#include "render/shape/csg/csg_sweep.h"

#include <algorithm>
#include <iterator>
#include <tuple>

namespace tessera::render::TESSERA_ISA {

void CsgCrossings::add_to_rest(const CsgCrossing& crossing) {
  if (rest_.empty()) rest_.assign(std::begin(fixed_), std::end(fixed_));
  rest_.push_back(crossing);
  ++count_;
}

void CsgCrossings::cut(std::size_t size) {
  if (rest_.empty()) {
    count_ = size;
    return;
  }
  rest_.resize(size);
  if (size <= kFixed) {
    std::copy(rest_.begin(), rest_.end(), fixed_);
    rest_.clear();
  }
  count_ = size;
}

void CsgCrossings::sort() {
  CsgCrossing* const first = rest_.empty() ? fixed_ : rest_.data();
  std::sort(first, first + count_, [](const CsgCrossing& a, const CsgCrossing& b) {
    return std::tie(a.s, a.solid, a.primitive) < std::tie(b.s, b.solid, b.primitive);
  });
}

/// States of a thread's nodes, as many as the largest tree has that it met. Rays and places are counted on
/// from tree to tree, so that nothing is ever cleared.
struct CsgSweep::Scratch {
  struct State {
    std::int64_t ray = 0;    // all of it is that ray's
    std::int64_t place = 0;  // where it changed last
    std::int32_t sum = 0;
    bool inside = false, was_inside = false;
  };
  std::vector<State> states;
  std::int64_t ray = 0, place = 0;

  State& at(std::int32_t node) {
    State& state = states[static_cast<std::size_t>(node)];
    if (state.ray != ray) state = {ray, 0, 0, false, false};
    return state;
  }
  /// Sets whether the ray is inside, and keeps what it was before this place.
  void set(State& state, bool inside) {
    if (state.place != place) state.place = place, state.was_inside = state.inside;
    state.inside = inside;
  }
  bool changed(std::int32_t node) {
    const State& state = at(node);
    return state.place == place && state.inside != state.was_inside;
  }
  static Scratch& of_thread() {
    static thread_local Scratch scratch;
    return scratch;
  }
};

CsgSweep::CsgSweep(const CsgRecord& csg) : csg_(csg), scratch_(Scratch::of_thread()) {
  if (scratch_.states.size() < csg.nodes.size()) scratch_.states.resize(csg.nodes.size());
}

void CsgSweep::start(const CsgCrossings& crossings, double width) {
  here_ = crossings.data();
  end_ = here_ + crossings.size();
  width_ = width;
  ++scratch_.ray;
}

bool CsgSweep::inside(std::int32_t node) { return scratch_.at(node).inside; }

void CsgSweep::toggle(std::int32_t node) {
  bool now = !inside(node);
  for (;;) {
    scratch_.set(scratch_.at(node), now);
    const CsgNode& child = csg_.nodes[static_cast<std::size_t>(node)];
    if (child.parent < 0) return;
    auto& group = scratch_.at(child.parent);
    group.sum += now ? child.weight : -child.weight;
    const bool group_now = group.sum >= csg_.nodes[static_cast<std::size_t>(child.parent)].threshold;
    if (group_now == group.inside) return;
    node = child.parent, now = group_now;
  }
}

bool CsgSweep::changed_up_to_root(std::int32_t node) {
  for (; node >= 0; node = parent(node)) {
    if (!scratch_.changed(node)) return false;
  }
  return true;
}

bool CsgSweep::next(CsgBorder& border) {
  while (here_ != end_) {
    ++scratch_.place;
    const CsgCrossing* const first = here_;
    // Places at infinity are one, too: their difference is no number.
    for (; here_ != end_ && !(here_->s - first->s > width_); ++here_)
      toggle(csg_.solids[static_cast<std::size_t>(here_->solid)].node);
    if (!scratch_.changed(0)) continue;
    const CsgCrossing* owner = nullptr;
    for (const CsgCrossing* c = first; c != here_; ++c) {
      if ((owner == nullptr || c->solid < owner->solid) &&
          changed_up_to_root(csg_.solids[static_cast<std::size_t>(c->solid)].node))
        owner = c;
    }
    border = {*owner, inside(0)};
    return true;
  }
  return false;
}

std::int32_t CsgSweep::first_solid_inside(std::int32_t group) {
  // Groups that the ray is outside of are passed over, and so is all that is taken away.
  std::int32_t first = -1;
  for (std::int32_t i = group; i < csg_.nodes[static_cast<std::size_t>(group)].end;) {
    const CsgNode& node = csg_.nodes[static_cast<std::size_t>(i)];
    const bool counts = inside(i) && (i == group || node.weight > 0);
    if (counts && node.solid >= 0 && (first < 0 || node.solid < first)) first = node.solid;
    i = counts ? i + 1 : node.end;
  }
  return first;
}

std::int32_t CsgSweep::material_at(const CsgBorder& border) {
  std::int32_t solid = border.at.solid;
  std::int32_t node = csg_.solids[static_cast<std::size_t>(solid)].node;
  for (; node >= 0; node = parent(node)) {
    if (csg_.nodes[static_cast<std::size_t>(node)].weight > 0) continue;
    // Cut out of its group, whose first operand is the node behind it.
    const std::int32_t group = parent(node);
    if (!csg_.nodes[static_cast<std::size_t>(group)].keeps_material) continue;
    const std::int32_t cut = first_solid_inside(group + 1);
    if (cut >= 0) solid = cut;
  }
  return solid;
}

}  // namespace tessera::render::TESSERA_ISA
