// Events of paths from the eye, told to whatever concerns itself with them: layers of light, light that
// neighbours share, guides that learn, caches. Scenes and jobs without any of these have no observers, and
// algorithms know none of them by name.
#pragma once

#include "render/transport/vertex/encounter.h"

namespace tessera::render::TESSERA_ISA {

/// Light that paths have come to: a lamp, or the sky behind everything.
struct MetLight {
  Int light;         // index in the scene's table
  bool at_infinity;  // true or false for all lanes alike
  Mask lanes;
  Spectrum radiance;    // radiance that comes along the path
  Mask weighed;         // lanes in which samples of lights could have found it ...
  Float by_lights{};    // ... with this density, solid angle
  Spectrum arriving{};  // radiance as the sample takes it, but for the path's throughput; may be changed
};

/// A sample of a light.
struct SampledLight {
  Int light;  // index in the scene's table
  const LightSample& sample;
  Spectrum radiance;   // the sample's, as the path carries it
  Float pdf;           // density of the light and the direction together
  Float weight;        // weight among other ways to find that light
  Mask lanes;          // lanes in which the light can be reached if nothing is between
  WideConnection ray;  // carries the light's contribution, which may be changed
};

/// Paths on their way to what they meet next.
struct Scattering {
  Mask lanes;  // lanes that are scattered
  BsdfSample bsdf;
  WidePath next;               // may be changed
  Mask alive;                  // lanes in which the path goes on
  Mask spared = Mask::none();  // lanes that Russian roulette may not end; may be changed

  explicit TESSERA_INLINE Scattering(Mask scattered) : lanes(scattered) {}
};

/// All events are those of 16 paths but for the last three, which are of all paths of a batch.
class PathObserver {
 public:
  virtual ~PathObserver() = default;

  /// Something is met that scatters light: `e.met`. The path may be changed. Lanes that are added to
  /// `e.settled` have all light but that of lamps and the sky, and end here.
  virtual void met(Encounter&) {}
  virtual void emitted(const Encounter&, MetLight&) {}
  virtual void lit(const Encounter&, SampledLight&) {}
  /// Russian roulette is yet to come.
  virtual void scattered(const Encounter&, Scattering&) {}
  /// Paths that are not `alive` now have ended.
  virtual void ended(const Encounter&, const Scattering&) {}

  /// `n` paths have met their first things.
  virtual void begun(const PathState&, const HitState&, int) {}
  /// All paths are scattered at the event of a depth; sampled light is to come.
  virtual void all_scattered(int) {}
  /// Light that was sampled at the event of this depth has come. `n` paths go on.
  virtual void all_lit(int, const PathState&, int) {}
};

/// An observer that chooses directions of paths in place of BSDFs alone.
class Steering : public PathObserver {
 public:
  /// The density with which sample() gives the direction `wi`, where met() left `steered` in
  /// Encounter::steered and the BSDF's own density is `bsdf_pdf`.
  virtual Float pdf(Int steered, Vec3 wi, Float bsdf_pdf, Mask lanes) const = 0;
  /// A direction in which the path of the latest encounter goes on; `u` is uniform in [0, 1).
  virtual BsdfSample sample(const Encounter& e, Vec2 u, Mask lanes) = 0;
};

}  // namespace tessera::render::TESSERA_ISA
