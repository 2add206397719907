#include "render/scene/shape/object_graph.h"

#include <algorithm>
#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/values/located.h"

namespace tessera::render {

namespace {

/// Names with arrows between them; of many, the first and the last ones.
std::string way_of(const ObjectGraph::Objects& objects, const std::vector<int>& way) {
  constexpr std::size_t kMostEnds = 4;
  std::string text;
  for (std::size_t i = 0; i < way.size(); ++i) {
    if (i >= kMostEnds && i + kMostEnds < way.size()) {
      if (i == kMostEnds) absl::StrAppend(&text, " > ...");
      continue;
    }
    absl::StrAppend(&text, i == 0 ? "'" : " > '", objects[way[i]].name(), "'");
  }
  return text;
}

constexpr std::uint64_t kUncounted = std::uint64_t{1} << 62;

std::uint64_t sum(std::uint64_t a, std::uint64_t b) { return std::min(a + b, kUncounted); }

/// Makes counts of objects' own parts those of all parts that they come to where all levels are flattened.
void flatten_counts(const ObjectGraph& graph, std::vector<std::uint64_t>& parts) {
  for (const int object : graph.order()) {
    std::uint64_t& all = parts[static_cast<std::size_t>(object)];
    for (const int held : graph.held_by(object)) all = sum(all, parts[static_cast<std::size_t>(held)]);
  }
}

std::string in_words(std::uint64_t count) {
  return count < kUncounted ? absl::StrCat(count) : std::string("2^62 or more");
}

std::string note_on_world(std::uint64_t count) {
  return absl::StrCat("the world's ", count, " instances are kept as one level, for there are more than ",
                      kMostFlattened);
}

}  // namespace

absl::StatusOr<ObjectGraph> ObjectGraph::of(const Objects& objects, const NameTable& names) {
  FaultList faults(1);
  auto graph = of(objects, names, faults);
  if (!graph) return faults.first();
  return *std::move(graph);
}

std::optional<ObjectGraph> ObjectGraph::of(const Objects& objects, const NameTable& names,
                                           FaultList& faults) {
  ObjectGraph graph;
  graph.held_.resize(static_cast<std::size_t>(objects.size()));
  bool known = true;
  for (int i = 0; i < objects.size(); ++i) {
    known &= faults.add(objects[i], "",
                        append_held(objects[i], names, absl::StrCat("object '", objects[i].name(), "', "),
                                    graph.held_[static_cast<std::size_t>(i)]));
  }
  if (!known || !graph.sort(objects, faults) || !graph.measure(objects, faults)) return std::nullopt;
  return graph;
}

bool ObjectGraph::sort(const Objects& objects, FaultList& faults) {
  enum class State : std::uint8_t { kNew, kOpen, kDone };
  std::vector<State> state(held_.size(), State::kNew);
  // Depth first, with a stack of its own: a hostile scene may have any depth.
  struct Step {
    int object;
    std::size_t next = 0;  // index into held_[object]
  };
  std::vector<Step> way;
  for (int root = 0; root < objects.size(); ++root) {
    if (state[static_cast<std::size_t>(root)] == State::kNew) way.push_back({root});
    while (!way.empty()) {
      Step& step = way.back();
      const auto at = static_cast<std::size_t>(step.object);
      state[at] = State::kOpen;
      if (step.next == held_[at].size()) {
        state[at] = State::kDone;
        order_.push_back(step.object);
        way.pop_back();
        continue;
      }
      const int held = held_[at][step.next++];
      if (state[static_cast<std::size_t>(held)] == State::kNew) {
        way.push_back({held});
      } else if (state[static_cast<std::size_t>(held)] == State::kOpen) {
        std::vector<int> cycle;
        for (const Step& s : way) {
          if (s.object == held || !cycle.empty()) cycle.push_back(s.object);
        }
        cycle.push_back(held);
        return faults.add(objects[held], "",
                          absl::InvalidArgumentError(absl::StrCat(
                              "object '", objects[held].name(), "' holds itself: ", way_of(objects, cycle))));
      }
    }
  }
  return true;
}

bool ObjectGraph::measure(const Objects& objects, FaultList& faults) {
  std::vector<int> depth(held_.size(), 1);     // levels, the object itself included
  std::vector<int> deepest(held_.size(), -1);  // the held object that has most
  for (const int object : order_) {
    const auto at = static_cast<std::size_t>(object);
    for (const int held : held_[at]) {
      const int below = depth[static_cast<std::size_t>(held)] + 1;
      if (below > depth[at]) depth[at] = below, deepest[at] = held;
    }
    depth_ = std::max(depth_, depth[at]);
  }
  if (depth_ <= kDeepest) return true;
  std::vector<int> way;
  auto object = static_cast<int>(std::ranges::max_element(depth) - depth.begin());
  for (; object >= 0; object = deepest[static_cast<std::size_t>(object)]) way.push_back(object);
  return faults.add(
      objects[way.front()], "",
      absl::InvalidArgumentError(absl::StrCat("objects hold one another ", depth_, " deep, at most ",
                                              kDeepest, ": ", way_of(objects, way))));
}

std::uint64_t count_flattened(const ObjectGraph& graph, std::vector<std::uint64_t> own,
                              const std::vector<int>& placed) {
  flatten_counts(graph, own);
  std::uint64_t all = 0;
  for (const int object : placed) all = sum(all, own[static_cast<std::size_t>(object)]);
  return all;
}

absl::Status check_flattened(const ObjectGraph& graph, std::vector<std::uint64_t> own,
                             const std::vector<int>& placed, const std::string& what) {
  const std::uint64_t all = count_flattened(graph, std::move(own), placed);
  if (all <= kMostEverFlattened) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(what, " stand in the world one by one, here ", in_words(all),
                                                 " of them; at most ", kMostEverFlattened));
}

std::string wants_flat(const wire::AlgorithmTraits& algorithm) {
  return algorithm.lists_instances ? absl::StrCat("integrator '", algorithm.name, "'") : std::string();
}

absl::StatusOr<NestingPlan> plan_nesting(const ObjectGraph& graph, const std::vector<std::uint64_t>& own,
                                         const std::vector<int>& placed, v1::Nesting asked,
                                         const std::string& wants_flat) {
  NestingPlan plan{.kept = std::vector<bool>(own.size()), .uses = std::vector<std::uint64_t>(own.size())};
  const auto at = [](int object) { return static_cast<std::size_t>(object); };
  std::vector<std::uint64_t>& uses = plan.uses;
  for (const int object : placed) ++uses[at(object)];
  for (auto holder = graph.order().rbegin(); holder != graph.order().rend(); ++holder) {
    if (uses[at(*holder)] == 0) continue;
    for (const int held : graph.held_by(*holder)) ++uses[at(held)];
  }
  const bool may_keep = wants_flat.empty() && asked != v1::NESTING_FLATTENED;
  if (graph.depth() == 1) {
    std::uint64_t all = 0;
    for (const int object : placed) all = sum(all, own[at(object)]);
    plan.world_kept = may_keep && all > kMostFlattened;
    if (plan.world_kept) plan.note = note_on_world(all);
    return plan;
  }
  // Flattened parts of each object, and how many places its tree has.
  std::vector<std::uint64_t> flat = own, places = own;
  for (std::uint64_t& count : places) count = sum(count, 1);
  flatten_counts(graph, flat);
  flatten_counts(graph, places);
  std::uint64_t all = 0, all_places = 0;
  for (const int object : placed) {
    all = sum(all, flat[at(object)]);
    all_places = sum(all_places, places[at(object)]);
  }
  if (all_places >= kUncounted)
    return absl::InvalidArgumentError("instances of objects within objects: 2^62 places or more");

  const bool flatten = !wants_flat.empty() || asked == v1::NESTING_FLATTENED ||
                       (asked != v1::NESTING_KEPT && all <= kMostFlattened);
  if (flatten && all > kMostEverFlattened) {
    return absl::InvalidArgumentError(
        absl::StrCat(wants_flat.empty() ? std::string("nesting 'flattened'") : wants_flat,
                     " places every object in the world, here ", in_words(all), " instances; at most ",
                     kMostEverFlattened));
  }
  if (flatten) {
    const char* const why = !wants_flat.empty()              ? "as the integrator wants it"
                            : asked == v1::NESTING_FLATTENED ? "as asked"
                                                             : "for there is room";
    plan.note = absl::StrCat("objects within objects, ", graph.depth(), " deep, are flattened, ", why, ": ",
                             all, " instances");
    return plan;
  }
  // Small objects that are used seldom are still flattened, those at the bottom first: a level saved for few
  // instances, as long as there is room.
  std::uint64_t room = asked == v1::NESTING_KEPT ? 0 : kMostFlattened;
  std::vector<std::uint64_t> parts = own;
  std::size_t kept = 0;
  std::uint64_t in_world = 0;
  for (const int object : graph.order()) {
    if (graph.held_by(object).empty() || uses[at(object)] == 0) continue;
    for (const int held : graph.held_by(object))
      parts[at(object)] = sum(parts[at(object)], plan.kept[at(held)] ? 1 : parts[at(held)]);
    if (parts[at(object)] == 1) continue;
    plan.kept[at(object)] = parts[at(object)] > room / uses[at(object)];
    if (!plan.kept[at(object)]) room -= uses[at(object)] * parts[at(object)];
    kept += plan.kept[at(object)];
  }
  for (const int object : placed) in_world = sum(in_world, plan.kept[at(object)] ? 1 : parts[at(object)]);
  plan.world_kept = in_world > kMostFlattened;
  plan.note = absl::StrCat(
      plan.world_kept ? absl::StrCat(note_on_world(in_world), "; ") : "", "objects within objects, ",
      graph.depth(), " deep: ", kept, " of them are kept as levels, ",
      asked == v1::NESTING_KEPT ? std::string("as asked")
                                : absl::StrCat("for flattened there were more than ", kMostFlattened),
      ": ", in_words(all), " instances");
  return plan;
}

}  // namespace tessera::render
