// Paths that begin at the lights, a batch at a time: what algorithms share that follow light on its way.
#pragma once

#include <cstdint>

#include "render/integrator/integrator.h"
#include "render/integrator/stage_timer.h"
#include "render/sampling/sampler.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/light_start.h"
#include "render/transport/vertex/path_state.h"
#include "render/transport/vertex/sample_keys.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// Codes that the `pdf` of a light path holds instead of a density: what led it here.
inline constexpr float kMirrored = 0;   // perfect mirrors and glass, from a delta light; or nothing, from one
inline constexpr float kScattered = 1;  // a wide lobe at least once
inline constexpr float kBundled = 2;  // mirrors, glass and narrow lobes alone; or nothing, from other lights

/// Sixteen paths at a surface.
struct LightEvent {
  WidePath path;
  Sampler sampler;
  int depth;       // events before this one
  int first_pair;  // number of this event's first pair of dimensions
  Vertex vertex;   // vertex whose wo points back to the light

  // The vertex is large and filled in later: it is not zeroed.
  LightEvent(const WidePath& wide_path, const Sampler& numbers, int number)
      : path(wide_path),
        sampler(numbers),
        depth(number),
        first_pair(dimension::kFirstLightEvent + number * dimension::kPairsPerLightEvent) {}
};

class LightPaths {
 public:
  /// All light of the scene is shared by `paths` paths, those of a pass: their throughput is flux.
  LightPaths(const IntegratorContext& context, float paths)
      : scene_(context.scene),
        rays_(context.rays),
        seed_(context.seed),
        stats_(context.stats),
        paths_of_pass_(paths) {}

  /// Starts paths first .. first + count - 1 of a pass, kBatch of them at most, in slots 0 .. count - 1.
  void start(std::int32_t first, std::int32_t count, std::uint32_t pass, const PassShare& shared = {});
  /// Some path is still on its way.
  bool alive() const { return alive_ > 0; }

  /// Follows all paths to the surfaces that they meet next, after `depth` events, calls meet(event, hit) for
  /// each 16 of which some have met one, and scatters them there if they may have more than depth + 1 events.
  template <class Meet>
  void advance(int depth, Meet&& meet) {
    intersect();
    const StageTimer timer(stats_.times, Stage::kShading);
    int kept = 0;
    for (int i = 0; i < alive_; i += kWidth) {
      const Mask active = Mask::first(alive_ - i);
      const Hit found = load_hit(hits_, i);
      const Mask hit = active & (found.shape >= 0);
      if (none(hit)) continue;
      const WidePath path = load(scene_, paths_, i);
      LightEvent e(path, keys_.sampler(scene_.sampler.kind, path.slot, active), depth);
      meet_surface(scene_, e.path, found, e.sampler, e.first_pair, hit, e.vertex);
      meet(e, hit);
      if (depth + 1 < scene_.max_depth) kept = scatter(e, hit, kept);
    }
    alive_ = kept;
  }

 private:
  void intersect();
  /// Appends the paths that go on to the first `kept`; returns how many there are then.
  int scatter(const LightEvent& e, Mask hit, int kept);

  const SceneTables& scene_;
  const RayQuery& rays_;
  const std::uint64_t seed_;
  RenderStats& stats_;
  const float paths_of_pass_;
  int alive_ = 0;
  PathState paths_;
  HitState hits_;
  SampleKeys keys_;
};

}  // namespace tessera::render::TESSERA_ISA
