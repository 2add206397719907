// The things that paths have met at the ends of their latest segments, as all algorithms see them whose paths
// begin at the eye.
#pragma once

#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/sample_batch.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen paths and what they have met: a surface, a particle of a medium, or nothing. Their random numbers
/// come from `numbers.get_2d(pair of dimensions)`.
template <class Numbers>
struct NumberedEncounter {
  WidePath path;
  Hit hit;
  Receiver reference;  // place where the path was last scattered
  Numbers numbers;
  int depth;                     // scattering events before this one
  int first_pair;                // number of this event's first pair of dimensions
  Mask on_surface, met, missed;  // `met`: on a surface or in a medium
  Vertex vertex;
  // Drawn once something was met, and only where somebody looks at them
  Vec2 roulette;  // Russian roulette, mixed material
  Vec2 choice;    // light, BSDF lobe
  Int steered;    // Steering::met(); with a Steering only
  Mask settled;   // PathObserver::met()

  // Loaded in place, and what is filled in later is not zeroed: copying costs 4 % of shading, zeroing 6 %.
  /// Entries i to i + 15, `active` ones of them.
  TESSERA_INLINE NumberedEncounter(const SceneTables& scene, const SampleBatch& batch, const PathState& paths,
                                   const HitState& hits, int event, int i, Mask active)
      : path(load(scene, paths, i)),
        hit(load_hit(hits, i)),
        reference(path.origin),
        numbers(batch.sampler(path.slot, active)),
        depth(event),
        first_pair(dimension::kFirstEvent + event * dimension::kPairsPerEvent) {
    look(scene, active);
  }
  /// Any others.
  TESSERA_INLINE NumberedEncounter(const SceneTables& scene, const WidePath& paths, const Hit& hits,
                                   const Numbers& random, int event, Mask active)
      : path(paths),
        hit(hits),
        reference(paths.origin),
        numbers(random),
        depth(event),
        first_pair(dimension::kFirstEvent + event * dimension::kPairsPerEvent) {
    look(scene, active);
  }

  /// The numbers of a pair of this event's dimensions.
  TESSERA_INLINE Vec2 random(int pair) const { return numbers.get_2d(first_pair + pair); }

  /// Finds the surface in these lanes of `on_surface`.
  TESSERA_INLINE void find_surface(const SceneTables& scene, Mask lanes) {
    vertex.surface = surface_at(scene.shapes, hit, path.origin, path.direction, lanes, scene.any_tangents);
  }
  /// Finds what scatters light there: after find_surface() of all lanes.
  TESSERA_INLINE void find_scattering(const SceneTables& scene) {
    Vertex& v = vertex;
    if (scene.any_mix) roulette = random(dimension::kRoulette);
    interact(scene, v.surface, v.wo, roulette.y, spectra_of(scene, path), on_surface, v.at);
    if (any(v.in_medium)) put_into_medium(fma(path.direction, hit.t, path.origin), v.in_medium, v);
    if (scene.any_opacity && !scene.paths_pass) {  // otherwise Transit has seen to it
      if (const Mask partly = partly_open(v, on_surface); any(partly))
        open_surface(scene, numbers.get_2d(dimension::kOpacity + depth).x, partly, v);
    }
  }
  /// The number that ends paths.
  TESSERA_INLINE Float roulette_number(const SceneTables& scene) const {
    return scene.any_mix ? roulette.x : random(dimension::kRoulette).x;
  }

 private:
  TESSERA_INLINE void look(const SceneTables& scene, Mask active) {
    Vertex& v = vertex;
    on_surface = active & (hit.shape >= 0);
    v.wo = -path.direction;
    if (scene.volumetric) {
      reference.p = path.reference;
      v.medium = path.medium;
      v.in_medium = active & (hit.shape == kScatteredByMedium);
    }
    if (scene.any_motion) hit.time = path.time;
    v.time = reference.time = hit.time;
    if (scene.lights.uses_normals) reference.normal = path.normal;
    met = on_surface | v.in_medium;
    missed = and_not(active, met);
  }
};
/// With the samples' own numbers.
using Encounter = NumberedEncounter<Sampler>;

/// From this event on, lights are sampled roughly (measured: docs/decisions/0012-lights.md). Not in media,
/// whose points come arbitrarily close to lamps.
TESSERA_INLINE bool samples_roughly(const SceneTables& scene, int depth) {
  constexpr int kFirstRoughEvent = 2;
  return depth >= kFirstRoughEvent && !scene.volumetric;
}

/// The vertex as it samples lights.
TESSERA_INLINE Receiver receiver_at(const SceneTables& scene, const Encounter& e) {
  Receiver receiver = receiver_at(scene, e.vertex);
  receiver.roughly = samples_roughly(scene, e.depth);
  return receiver;
}

}  // namespace tessera::render::TESSERA_ISA
