// Light between two scattering events in volumetric scenes: media that it flies through, surfaces that it
// passes without being scattered. For paths, and for rays that join points.
#pragma once

#include "render/integrator/integrator.h"
#include "render/medium/medium.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/passing.h"
#include "render/transport/vertex/path_state.h"
#include "render/transport/vertex/sample_batch.h"
#include "render/transport/vertex/sample_keys.h"

namespace tessera::render::TESSERA_ISA {

/// Numbers that decide what becomes of paths on their way.
struct TransitNumbers {
  const SampleKeys& keys;
  int flight;          // the first of the pairs of dimensions for distances in media, one an event
  std::uint32_t salt;  // 0, or what sets these paths apart from those of the same keys that have 0
  // The pair for the distance at this event, by slot, in place of the keys' own; null: those
  const float* distance_x = nullptr;
  const float* distance_y = nullptr;

  /// The key of a sample's number streams.
  UInt key(Int slot, Mask active) const {
    const UInt key = keys.key(slot, active);
    return salt == 0 ? key : hash(key ^ salt);
  }
};

class Transit {
 public:
  explicit Transit(const IntegratorContext& context)
      : scene_(context.scene), rays_(context.rays), stats_(context.stats) {}

  /// Moves the first `count` paths, whose nearest hits are known, on to their next scattering events, of
  /// which this is number `event`. What media emit goes to `emission`, if that is given.
  void move(PathState& paths, HitState& hits, int count, int event, const TransitNumbers& numbers,
            SampleBatch* emission);

  /// Takes all rays of the queue to their ends, as far as they pass what is in their way: calls
  /// arrived(ray, lanes) for 16 at a time, contributions being what is left. `hits` is room for what the rays
  /// meet.
  template <class Arrived>
  void march(Passenger who, ConnectionQueue& queue, HitState& hits, int event, Arrived&& arrived);

 private:
  /// Paths that passed a surface and are traced on.
  struct Passed {
    alignas(64) Lanes<std::int32_t> path;  // entry of PathState
    Vec3Lanes origin, direction;
    alignas(64) Lanes<float> time;  // scenes with motion only
    HitState hits;
  };
  /// The 16 paths at these entries within a batch.
  struct Flying {
    PathState& paths;
    HitState& hits;
    int event;
    const TransitNumbers& numbers;
    SampleBatch* emission;
  };

  Mask fly(const Flying& flying, Int path, int round, Mask active);
  void retrace(PathState& paths, HitState& hits, int count);
  void end_stuck_paths(PathState& paths, HitState& hits, int count);
  /// Takes rays to the next surface that they meet: the lanes that end there are `arrived`, those that are
  /// returned go on behind it.
  Mask cross(Passenger who, WideConnection& ray, Hit hit, int event, int round, Mask active, Mask& arrived);
  const float* times_of(const Lanes<float>& times) const { return scene_.any_motion ? times : nullptr; }

  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  Passed passed_;
};

template <class Arrived>
void Transit::march(Passenger who, ConnectionQueue& queue, HitState& hits, int event, Arrived&& arrived) {
  int n = queue.size;
  for (int round = 0; n > 0 && round <= dimension::kMostCrossings; ++round) {
    rays_.nearest(arrays_of(queue.origin, queue.direction, times_of(queue.time)), n, false, hits.arrays());
    stats_.shadow_rays += static_cast<std::uint64_t>(n);
    int kept = 0;
    for (int i = 0; i < n; i += kWidth) {
      WideConnection ray = load(scene_, static_cast<const ConnectionFields<InMemory>&>(queue), i);
      Mask ends = Mask::none();
      const Mask on = cross(who, ray, load_hit(hits, i), event, round, Mask::first(n - i), ends);
      if (any(ends)) arrived(ray, ends);
      kept += append(scene_, ray, on, queue, kept);
    }
    n = kept;
  }
  queue.size = 0;
}

}  // namespace tessera::render::TESSERA_ISA
