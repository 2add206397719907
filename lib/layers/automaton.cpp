#include "layers/automaton.h"

#include <algorithm>
#include <bit>
#include <map>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "layers/expression.h"
#include "layers/layer_check.h"

namespace tessera::layers {

namespace {

constexpr std::size_t kWords = kMaxPoints / 64;

/// Positions in all expressions.
struct Positions {
  std::uint64_t words[kWords] = {};

  void add(std::size_t i) { words[i / 64] |= std::uint64_t{1} << (i % 64); }
  Positions& operator|=(const Positions& other) {
    for (std::size_t w = 0; w < kWords; ++w) words[w] |= other.words[w];
    return *this;
  }
  Positions operator&(const Positions& other) const {
    Positions result;
    for (std::size_t w = 0; w < kWords; ++w) result.words[w] = words[w] & other.words[w];
    return result;
  }
  auto operator<=>(const Positions&) const = default;

  template <class F>
  void for_each(F&& f) const {
    for (std::size_t w = 0; w < kWords; ++w) {
      for (std::uint64_t bits = words[w]; bits != 0; bits &= bits - 1)
        f(w * 64 + static_cast<std::size_t>(std::countr_zero(bits)));
    }
  }
};

bool has_one_of(const std::vector<std::string>& own, const std::vector<std::string>& asked) {
  return std::ranges::any_of(
      asked, [&](const std::string& name) { return std::ranges::find(own, name) != own.end(); });
}

bool holds(const NameTest& test, const SurfaceNames& surface) {
  const bool found = (test.scope != Scope::kMaterial && has_one_of(surface.objects, test.names)) ||
                     (test.scope != Scope::kObject && has_one_of(surface.materials, test.names));
  return found != test.negated;
}

/// Whether the symbol matches the point that `in_set` and `test_holds` speak of.
template <class InSet, class TestHolds>
bool matches(const Node& symbol, InSet&& in_set, TestHolds&& test_holds) {
  const bool found = std::ranges::any_of(symbol.points, [&](const PointSet& points) {
    return in_set(points) && std::ranges::all_of(points.tests, test_holds);
  });
  return found != symbol.negated;
}

/// The position automaton of all expressions [Glushkov 1961]: a state is the symbol that was read last.
class PositionAutomaton {
 public:
  /// False where there are too many positions.
  bool add(const Node& expression, std::size_t layer) {
    const Part whole = visit(expression);
    if (full_) return false;
    first_ |= whole.first;
    whole.last.for_each([&](std::size_t p) { layers_of_last_[p] |= 1u << layer; });
    return true;
  }

  const Positions& first() const { return first_; }
  Positions followers(const Positions& set) const {
    Positions result;
    set.for_each([&](std::size_t p) { result |= follow_[p]; });
    return result;
  }
  std::int32_t layers_ended_by(const Positions& set) const {
    std::uint32_t layers = 0;
    set.for_each([&](std::size_t p) { layers |= layers_of_last_[p]; });
    return static_cast<std::int32_t>(layers);
  }
  /// The positions whose symbol satisfies `match`, which is asked once of a symbol and all of its copies.
  template <class Match>
  Positions where(Match&& match) const {
    Positions result;
    for (const auto& [symbol, copies] : positions_of_) {
      if (match(*symbol)) result |= copies;
    }
    return result;
  }

 private:
  struct Part {
    bool nullable = false;
    Positions first, last;
  };

  void connect(const Positions& from, const Positions& to) {
    from.for_each([&](std::size_t p) { follow_[p] |= to; });
  }
  Part in_sequence(Part a, const Part& b) {
    connect(a.last, b.first);
    if (a.nullable) a.first |= b.first;
    if (b.nullable) {
      a.last |= b.last;
    } else {
      a.last = b.last;
    }
    a.nullable = a.nullable && b.nullable;
    return a;
  }

  Part visit(const Node& node) {
    Part whole;
    if (full_) return whole;
    switch (node.kind) {
      case Node::Kind::kSymbol:
        return visit_symbol(node);
      case Node::Kind::kSequence:
        whole.nullable = true;
        for (const Node& child : node.children) whole = in_sequence(std::move(whole), visit(child));
        return whole;
      case Node::Kind::kChoice:
        for (const Node& child : node.children) {
          const Part part = visit(child);
          whole.nullable = whole.nullable || part.nullable;
          whole.first |= part.first;
          whole.last |= part.last;
        }
        return whole;
      case Node::Kind::kRepeat:
        return visit_repeat(node);
    }
    return whole;
  }

  Part visit_symbol(const Node& node) {
    Part part;
    const std::size_t p = follow_.size();
    if (p == kMaxPoints) {
      full_ = true;
      return part;
    }
    positions_of_[&node].add(p);
    follow_.emplace_back();
    layers_of_last_.push_back(0);
    part.first.add(p);
    part.last.add(p);
    return part;
  }

  /// Each time is a copy; the last of those without end is followed by itself.
  Part visit_repeat(const Node& node) {
    const Node& child = node.children.front();
    Part whole{.nullable = true, .first = {}, .last = {}};
    const int copies = node.most == kForEver ? std::max(node.least, 1) : node.most;
    for (int i = 0; i < copies && !full_; ++i) {
      Part copy = visit(child);
      copy.nullable = copy.nullable || i >= node.least;
      if (node.most == kForEver && i + 1 == copies) connect(copy.last, copy.first);
      whole = in_sequence(std::move(whole), copy);
    }
    return whole;
  }

  std::map<const Node*, Positions> positions_of_;
  std::vector<Positions> follow_;  // positions that may follow each position
  std::vector<std::uint32_t> layers_of_last_;
  Positions first_;
  bool full_ = false;
};

/// The tree read from its other end.
void reverse(Node& node) {
  if (node.kind == Node::Kind::kSequence) std::ranges::reverse(node.children);
  for (Node& child : node.children) reverse(child);
}

static_assert(kEventStride == kEvents + 1 && kNoEvent == kEvents);

/// The positions that match each point of the alphabet, kEvents a surface.
struct Matches {
  std::vector<Positions> eye, events, sources;

  Matches(const PositionAutomaton& positions, const Alphabet& alphabet) {
    eye.push_back(positions.where([](const Node& symbol) {
      return !symbol.negated && std::ranges::any_of(symbol.points, &PointSet::eye);
    }));
    for (const SurfaceNames& surface : alphabet.surfaces) {
      for (int event = 0; event < kEvents; ++event) {
        events.push_back(positions.where([&](const Node& symbol) {
          return matches(
              symbol, [&](const PointSet& points) { return (points.events >> event & 1) != 0; },
              [&](const NameTest& test) { return holds(test, surface); });
        }));
      }
    }
    for (const std::vector<std::string>& light : alphabet.lights) {
      for (int source = 0; source < kSources; ++source) {
        sources.push_back(positions.where([&](const Node& symbol) {
          return matches(
              symbol, [&](const PointSet& points) { return (points.sources >> source & 1) != 0; },
              [&](const NameTest& test) { return has_one_of(light, test.names) != test.negated; });
        }));
      }
    }
  }
};

/// The subset construction [Rabin & Scott 1959], along paths alone: one point to begin with, events, one
/// point to end with. Nothing where there are too many states.
std::optional<Automaton> determinise(const PositionAutomaton& positions, const Matches& matches,
                                     Direction direction) {
  const bool from_camera = direction == Direction::kFromCamera;
  const std::vector<Positions>& begins = from_camera ? matches.eye : matches.sources;
  const std::vector<Positions>& ends = from_camera ? matches.sources : matches.eye;
  const auto size = [](const std::vector<Positions>& points) {
    return static_cast<std::int32_t>(points.size());
  };
  Automaton result{.states = 0,
                   .events = size(matches.events) / kEvents * kEventStride,
                   .begins = size(begins),
                   .ends = size(ends),
                   .begin = {},
                   .next = {},
                   .layers = {}};
  std::map<Positions, std::int32_t> states;
  std::vector<Positions> sets;
  const auto state_of = [&](const Positions& set) {
    const auto [found, is_new] = states.try_emplace(set, static_cast<std::int32_t>(sets.size()));
    if (is_new) sets.push_back(set);
    return found->second;
  };
  for (const Positions& point : begins) result.begin.push_back(state_of(positions.first() & point));
  for (std::size_t state = 0; state < sets.size(); ++state) {
    if (sets.size() > kMaxStates || sets.size() * static_cast<std::size_t>(result.events) > kMaxEntries)
      return std::nullopt;
    const Positions followers = positions.followers(sets[state]);
    for (std::size_t e = 0; e < matches.events.size(); ++e) {
      result.next.push_back(state_of(followers & matches.events[e]));
      if ((e + 1) % kEvents == 0) result.next.push_back(static_cast<std::int32_t>(state));  // kNoEvent
    }
    for (const Positions& point : ends) result.layers.push_back(positions.layers_ended_by(followers & point));
  }
  result.states = static_cast<std::int32_t>(sets.size());
  return result;
}

/// Merges states that no continuation tells apart, by refining classes until none splits [Moore 1956].
Automaton minimised(const Automaton& automaton) {
  const auto states = static_cast<std::size_t>(automaton.states),
             events = static_cast<std::size_t>(automaton.events),
             ends = static_cast<std::size_t>(automaton.ends);
  std::vector<std::int32_t> classes(states, 0);
  std::size_t count = 0;
  for (;;) {
    std::map<std::vector<std::int32_t>, std::int32_t> known;
    std::vector<std::int32_t> refined(states);
    for (std::size_t s = 0; s < states; ++s) {
      std::vector<std::int32_t> signature(
          automaton.layers.begin() + static_cast<std::ptrdiff_t>(s * ends),
          automaton.layers.begin() + static_cast<std::ptrdiff_t>((s + 1) * ends));
      for (std::size_t e = 0; e < events; ++e)
        signature.push_back(classes[static_cast<std::size_t>(automaton.next[s * events + e])]);
      refined[s] =
          known.try_emplace(std::move(signature), static_cast<std::int32_t>(known.size())).first->second;
    }
    classes = std::move(refined);
    if (known.size() == count) break;
    count = known.size();
  }
  Automaton result = automaton;
  result.states = static_cast<std::int32_t>(count);
  result.next.assign(count * events, 0);
  result.layers.assign(count * ends, 0);
  for (std::size_t s = 0; s < states; ++s) {
    const auto to = static_cast<std::size_t>(classes[s]);
    for (std::size_t e = 0; e < events; ++e)
      result.next[to * events + e] = classes[static_cast<std::size_t>(automaton.next[s * events + e])];
    for (std::size_t e = 0; e < ends; ++e) result.layers[to * ends + e] = automaton.layers[s * ends + e];
  }
  for (std::int32_t& state : result.begin) state = classes[static_cast<std::size_t>(state)];
  return result;
}

/// Not minimised. Nothing where it would be too large.
std::optional<Automaton> automaton_of(std::span<const Node> trees, const Alphabet& alphabet,
                                      Direction direction) {
  PositionAutomaton positions;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    if (!positions.add(trees[i], i)) return std::nullopt;
  }
  return determinise(positions, Matches(positions, alphabet), direction);
}

absl::StatusOr<std::vector<Node>> trees_of(std::span<const Layer> layers, Direction direction) {
  std::vector<Node> trees;
  for (const Layer& layer : layers) {
    absl::StatusOr<Node> tree = paths_of(layer);
    if (!tree.ok()) return tree.status();
    if (direction == Direction::kFromLights) reverse(*tree);
    trees.push_back(*std::move(tree));
  }
  return trees;
}

/// The first layer with which the automaton becomes too large.
absl::Status too_large(std::span<const Layer> layers, std::span<const Node> trees, const Alphabet& alphabet,
                       Direction direction) {
  std::size_t fits = 0;
  for (std::size_t too_many = trees.size(); fits + 1 < too_many;) {
    const std::size_t middle = (fits + too_many) / 2;
    (automaton_of(trees.first(middle), alphabet, direction) ? fits : too_many) = middle;
  }
  return absl::ResourceExhaustedError(absl::StrCat(
      "layer '", layers[fits].name, "' is too much: with those before it the automaton has more than ",
      kMaxStates, " states, ", kMaxPoints, " points or ", kMaxEntries, " entries"));
}

}  // namespace

absl::StatusOr<Automaton> compile(std::span<const Layer> layers, const Alphabet& alphabet,
                                  Direction direction) {
  const auto trees = trees_of(layers, direction);
  if (!trees.ok()) return trees.status();
  const std::optional<Automaton> result = automaton_of(*trees, alphabet, direction);
  if (!result) return too_large(layers, *trees, alphabet, direction);
  return minimised(*result);
}

std::vector<std::int32_t> layers_of_joins(const Automaton& from_camera, const Automaton& from_lights) {
  // A minimal automaton's state is all that matters of what was read [Nerode 1958], so any one way to a state
  // of the reversed automaton stands for all. Its last event is the first that the other part would read.
  const auto states = static_cast<std::size_t>(from_camera.states),
             others = static_cast<std::size_t>(from_lights.states),
             events = static_cast<std::size_t>(from_camera.events);
  std::vector<std::int32_t> layers(states * others);
  std::vector<bool> known(others, false);
  std::vector<std::size_t> found;
  const auto reach = [&](std::int32_t state, auto&& layers_of) {
    const auto s = static_cast<std::size_t>(state);
    if (known[s]) return;
    known[s] = true;
    found.push_back(s);
    for (std::size_t q = 0; q < states; ++q) layers[q * others + s] = layers_of(q);
  };
  for (std::size_t source = 0; source < from_lights.begin.size(); ++source) {
    reach(from_lights.begin[source], [&](std::size_t q) {
      return from_camera.layers[q * static_cast<std::size_t>(from_camera.ends) + source];
    });
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t before = found[i];
    for (std::size_t e = 0; e < events; ++e) {
      reach(from_lights.next[before * events + e], [&](std::size_t q) {
        return layers[static_cast<std::size_t>(from_camera.next[q * events + e]) * others + before];
      });
    }
  }
  return layers;
}

}  // namespace tessera::layers
