// Which objects hold which: a directed graph without cycles, and what is made of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/values/fault_list.h"
#include "render/scene/values/located.h"
#include "render/scene/values/name_table.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"

namespace tessera::render {

/// Objects are numbered as in the scene.
class ObjectGraph {
 public:
  using Objects = google::protobuf::RepeatedPtrField<v1::Object>;

  /// Objects on a way from the world down, at most: rays go down by recursion.
  static constexpr int kDeepest = 64;

  /// InvalidArgument names an instance of an object that does not exist, a cycle with its objects, or a way
  /// that is longer than kDeepest. `names` are those of the objects. Counts of packed instances are known to
  /// be those of their blobs.
  static absl::StatusOr<ObjectGraph> of(const Objects& objects, const NameTable& names);
  /// None where there is such a fault, which is added to the list.
  static std::optional<ObjectGraph> of(const Objects& objects, const NameTable& names, FaultList& faults);

  /// The objects that an object's instances place, in their order: messages, then packed ones.
  const std::vector<int>& held_by(int object) const { return held_[static_cast<std::size_t>(object)]; }
  /// All objects, each after those that it holds; without those in their own order.
  const std::vector<int>& order() const { return order_; }
  /// Objects on the longest way down, the first one included; 1 where none holds another.
  int depth() const { return depth_; }

 private:
  bool sort(const Objects& objects, FaultList& faults);
  bool measure(const Objects& objects, FaultList& faults);

  std::vector<std::vector<int>> held_;
  std::vector<int> order_;
  int depth_ = 1;
};

/// Which objects keep their instances, so that rays go down into them; all others are flattened: what they
/// hold is placed by whatever holds them.
struct NestingPlan {
  std::vector<bool> kept;
  // Instances of each object in the world and in objects that are placed there; 0: it is nowhere.
  std::vector<std::uint64_t> uses;
  bool world_kept = false;  // the world's instances are held by one object that stands in it
  std::string note = "";    // the decision, and why; empty where no level is kept and none was flattened
};

/// Adds to `held` the objects that a scene's, or an object's, instances place. Messages of errors begin with
/// `where`.
template <class Holder>
absl::Status append_held(const Holder& holder, const NameTable& names, const std::string& where,
                         std::vector<int>& held) {
  const auto add = [&](const std::string& name, std::uint64_t count) -> absl::Status {
    const auto object = names.find(name);
    if (!object.ok())
      return located(object.status(),
                     where + place_in_scene("instance", static_cast<int>(held.size()), name));
    held.insert(held.end(), count, *object);
    return absl::OkStatus();
  };
  for (const v1::Instance& instance : holder.instances()) {
    if (auto s = add(instance.object(), 1); !s.ok()) return s;
  }
  for (const auto& run : holder.packed_instances().runs()) {
    if (auto s = add(run.object(), run.count()); !s.ok()) return s;
  }
  return absl::OkStatus();
}

/// How often shapes' objects may be placed where a scene is flattened: by itself, and where it is asked for.
/// Figures behind the first: docs/decisions/0044-scene-graph.md.
inline constexpr std::uint64_t kMostFlattened = std::uint64_t{1} << 18;
inline constexpr std::uint64_t kMostEverFlattened = std::uint64_t{1} << 24;

/// Counts the parts that stand in the world where no level is kept: `own` are those of each object besides
/// its instances, `placed` the object of each instance in the world. 2^62 stands for all that is more.
std::uint64_t count_flattened(const ObjectGraph& graph, std::vector<std::uint64_t> own,
                              const std::vector<int>& placed);

/// InvalidArgument where the parts that `own` counts for each object, which no level keeps, would be placed
/// in the world more than kMostEverFlattened times; `what` names them. `placed`: as above.
absl::Status check_flattened(const ObjectGraph& graph, std::vector<std::uint64_t> own,
                             const std::vector<int>& placed, const std::string& what);

/// Who wants objects within objects flattened, for plan_nesting(); empty where the algorithm does not.
std::string wants_flat(const wire::AlgorithmTraits& algorithm);

/// `own`: how many of an object's parts are placed besides its instances; `placed`: the object of each
/// instance in the world. InvalidArgument where a scene that has to be flattened would have too many
/// instances, or there are more than 2^62 places; `wants_flat` names what cannot do with others, or is empty.
absl::StatusOr<NestingPlan> plan_nesting(const ObjectGraph& graph, const std::vector<std::uint64_t>& own,
                                         const std::vector<int>& placed, v1::Nesting asked,
                                         const std::string& wants_flat);

}  // namespace tessera::render
