// Paths that begin at lights, and what they meet: what all algorithms share that follow light from its
// sources.
#pragma once

#include "render/light/emission.h"
#include "render/sampling/discrete.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/light_spectrum.h"
#include "render/transport/vertex/pass_share.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// Whether light leaves any source at all.
TESSERA_INLINE bool emits_paths(const SceneTables& scene) {
  return !scene.lights.selection.threshold.empty();
}

/// Sixteen paths on their lights.
struct LightStart {
  WidePath path;  // beta: the flux that it stands for
  Int light;
  Float pmf;     // probability of picking that light
  Emission ray;  // path.origin is off the surface
  Mask alive;
};

/// One of `paths` paths that stand for all light of the scene. `Numbers` gives pairs of numbers by their
/// dimensions, as Sampler does, but for what a pass shares.
template <class Numbers>
TESSERA_INLINE LightStart start_at_light(const SceneTables& scene, const Numbers& numbers, float paths,
                                         Int slot, Mask active, const PassShare& shared = {}) {
  const DiscreteSample choice =
      sample_discrete(scene.lights.selection, numbers.get_2d(dimension::kEmitter).x, active);
  LightStart start;
  start.light = choice.index;
  start.pmf = choice.pmf;
  Float time(0.0f);
  if (scene.any_motion) {
    time =
        shared.time ? Float(*shared.time) : time_of_light(scene.sensor, numbers.get_2d(dimension::kTime).x);
  }
  start.ray = sample_emission(scene.lights, choice.index, time, numbers.get_2d(dimension::kEmissionPlace),
                              numbers.get_2d(dimension::kEmissionDirection), active);
  start.alive = active & start.ray.valid & (choice.pmf > 0.0f);
  const Float scale = 1.0f / (select(start.alive, choice.pmf, 1.0f) * paths);
  WidePath& path = start.path;
  path = WidePath{};
  path.origin = start.ray.origin + start.ray.offset;
  path.direction = start.ray.direction;
  path.wavelengths = wavelengths_of(scene, numbers, shared);
  path.beta = spectrum_of_light(scene, spectra_of(scene, path), start.light, start.ray.flux, active) * scale;
  path.dispersed = Int(0);
  path.roulette_scale = 1.0f / max(path.beta.max_component(), 1e-30f);
  path.slot = slot;
  path.time = time;
  return start;
}

/// Makes `v` the vertex where paths from lights are scattered, at surfaces in the lanes `hit` and by media in
/// others; its wo points back along them. `first_pair` is the first of this event's dimensions. Paths end
/// wavelengths there (dispersion.h).
template <class Numbers>
TESSERA_INLINE void meet_surface(const SceneTables& scene, WidePath& path, Hit found, const Numbers& numbers,
                                 int first_pair, Mask hit, Vertex& v) {
  if (scene.any_motion) found.time = path.time;
  v.wo = -path.direction;
  v.time = found.time;
  if (scene.volumetric) {
    v.medium = path.medium;
    v.in_medium = found.shape == kScatteredByMedium;
  }
  v.surface = surface_at(scene.shapes, found, path.origin, path.direction, hit, scene.any_tangents);
  interact(scene, v.surface, v.wo, numbers.get_2d(first_pair + dimension::kLightRoulette).y,
           spectra_of(scene, path), hit, v.at);
  if (any(v.in_medium)) put_into_medium(fma(path.direction, found.t, path.origin), v.in_medium, v);
  if (scene.any_opacity && !scene.volumetric) {
    if (const Mask partly = partly_open(v, hit); any(partly))
      open_surface(scene, numbers.get_2d(first_pair + dimension::kLobe).y, partly, v);
  }
  disperse_at(scene, v, hit, path);
}

/// Cosines with shading and geometric normal do not cancel as they do on a path from the eye: the factor of
/// importance that is scattered from `from` to `to` [Veach 1997, section 5.3].
TESSERA_INLINE Float normal_ratio(const Surface& s, const Frame& frame, Vec3 from, Vec3 to) {
  const Float in = abs(dot(from, frame.z)) / max(abs(dot(from, s.ng)), 1e-6f);
  return in * abs(dot(to, s.ng)) / max(abs(dot(to, frame.z)), 1e-6f);
}

/// The same where the value of what scatters has the cosine at the light's side.
TESSERA_INLINE Float adjoint_ratio(const Vertex& v, Vec3 to) {
  return select(v.in_medium, 1.0f, abs(dot(to, v.surface.ng)) / max(abs(dot(v.wo, v.surface.ng)), 1e-6f));
}

}  // namespace tessera::render::TESSERA_ISA
