// The paths in flight, and the rays that join them to lights and to the eye. Sorting, gathering and appending
// follow from one list of fields each.
#pragma once

#include <cstdint>

#include "render/integrator/scene_tables.h"
#include "render/shape/surface.h"
#include "render/transport/vertex/lanes.h"

namespace tessera::render::TESSERA_ISA {

/// Whether paths may end all of their wavelengths but the first (dispersion.h).
TESSERA_INLINE bool disperses(const SceneTables& scene) {
  return kSpectral && (scene.any_dispersion || scene.sensor.disperses);
}

/// One entry a path that is still alive, in no order that matters: `slot` says which sample it belongs to.
template <class Form>
struct alignas(64) PathFields {
  typename Form::Vector origin, direction;
  typename Form::Colour beta;  // throughput
  [[no_unique_address]] typename Form::Wavelengths wavelengths;
  // Density of the BSDF sample that led here, by solid angle; 0, or less, after a delta lobe or the camera.
  typename Form::Scalar pdf;
  // Makes beta what Russian roulette goes by: undoes the 1/eta^2 of refraction, or, of paths from lights,
  // what they began with.
  typename Form::Scalar roulette_scale;
  typename Form::Integer slot;
  // Where the path was last scattered, as in Receiver; with LightTable::uses_normals only.
  typename Form::Vector normal;
  typename Form::Integer dispersed;  // scenes with dispersion only: 1 once the first wavelength alone is left
  typename Form::Scalar time;  // scenes with motion only: 0 (the shutter opens) to 1, the same along a path
  // Volumetric scenes only
  // Where the path was last scattered; `origin` is where it last crossed something.
  typename Form::Vector reference;
  typename Form::Integer medium;       // around `origin`; -1: none
  typename Form::Integer layer_state;  // state of the layers' automaton, where there are layers

  /// Calls f for each field that paths of this scene have, in all of these forms at once.
  template <class F, class... Paths>
  static TESSERA_INLINE void for_each(const SceneTables& scene, F&& f, Paths&... paths) {
    f(paths.origin...);
    f(paths.direction...);
    f(paths.beta...);
    if constexpr (kSpectral) f(paths.wavelengths...);
    f(paths.pdf...);
    f(paths.roulette_scale...);
    f(paths.slot...);
    if (scene.lights.uses_normals) f(paths.normal...);
    if (disperses(scene)) f(paths.dispersed...);
    if (scene.any_motion) f(paths.time...);
    if (scene.volumetric) {
      f(paths.reference...);
      f(paths.medium...);
    }
    if (scene.layers.count > 0) f(paths.layer_state...);
  }
};
using PathState = PathFields<InMemory>;
using WidePath = PathFields<Wide16>;

/// Colours of the scene as these paths see them.
TESSERA_INLINE Spectra spectra_of(const SceneTables& scene, const WidePath& paths) {
  return {scene.spectral, paths.wavelengths};
}

/// Hit::shape of a path that was scattered by its medium, at Hit::t.
inline constexpr std::int32_t kScatteredByMedium = -2;

/// A ray from a vertex to a light, or to the eye, with what it carries if nothing is in the way.
template <class Form>
struct alignas(64) ConnectionFields {
  typename Form::Vector origin, direction;
  typename Form::Scalar distance;
  typename Form::Colour contribution;
  typename Form::Integer slot;
  typename Form::Scalar time;  // scenes with motion only
  // Volumetric scenes only
  typename Form::Integer medium;  // around the origin
  typename Form::Integer key;     // key of its random numbers
  [[no_unique_address]] typename Form::Wavelengths wavelengths;
  typename Form::Integer layers;  // bits of those that arriving light belongs to; where there are any
  // Where there are layers of unweighted light: what the contribution lacks to be it.
  typename Form::Scalar inverse_weight;

  template <class F, class... Connections>
  static TESSERA_INLINE void for_each(const SceneTables& scene, F&& f, Connections&... connections) {
    f(connections.origin...);
    f(connections.direction...);
    f(connections.distance...);
    f(connections.contribution...);
    f(connections.slot...);
    if (scene.any_motion) f(connections.time...);
    if (scene.volumetric) {
      f(connections.medium...);
      f(connections.key...);
      if constexpr (kSpectral) f(connections.wavelengths...);
    }
    if (scene.layers.count > 0) f(connections.layers...);
    if (scene.layers.unweighted != 0) f(connections.inverse_weight...);
  }
};
using WideConnection = ConnectionFields<Wide16>;

/// Connections that wait to be traced.
struct ConnectionQueue : ConnectionFields<InMemory> {
  int size = 0;
};

/// Stores the active lanes behind one another from entry `at` on; returns how many.
template <template <class> class Fields>
TESSERA_INLINE int append(const SceneTables& scene, const Fields<Wide16>& from, Mask active,
                          Fields<InMemory>& to, int at) {
  Fields<InMemory>::for_each(
      scene, [&](const auto& field, auto& lanes) { append_lanes(field, active, lanes, at); }, from, to);
  return count(active);
}

/// The 16 entries from entry i on.
template <template <class> class Fields>
TESSERA_INLINE void store(const SceneTables& scene, const Fields<Wide16>& from, Fields<InMemory>& to, int i) {
  Fields<InMemory>::for_each(
      scene, [&](const auto& field, auto& lanes) { store_lanes(field, lanes, i); }, from, to);
}
template <template <class> class Fields>
TESSERA_INLINE Fields<Wide16> load(const SceneTables& scene, const Fields<InMemory>& from, int i) {
  Fields<Wide16> result;
  Fields<InMemory>::for_each(
      scene, [&](auto& field, const auto& lanes) { load_lanes(lanes, i, field); }, result, from);
  return result;
}

TESSERA_INLINE Hit load_hit(const HitState& hits, int i) {
  return {Float::load(hits.t + i),
          Float::load(hits.u + i),
          Float::load(hits.v + i),
          Int::load(hits.primitive + i),
          Int::load(hits.shape + i),
          Int::load(hits.instance + i),
          Float(0.0f),
          Int::load(hits.upper + i)};
}

}  // namespace tessera::render::TESSERA_ISA
