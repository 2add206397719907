// The paths in flight: structure of arrays, so that 16 of them load as one wide value.
#pragma once

#include <cstdint>

#include "render/accel/trace.h"
#include "render/color/spectrum.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Paths a thread has in flight. Measured: 512 to 2k is best, 16k costs 5-12 % (docs/architecture.md).
inline constexpr int kBatch = 1024;
/// Room for a full wide store at any position.
inline constexpr int kPadded = kBatch + kWidth;

template <class T>
using Lanes = T[kPadded];

struct alignas(64) Vec3Lanes {
  alignas(64) Lanes<float> x, y, z;

  TESSERA_INLINE Vec3 load(int i) const { return {Float::load(x + i), Float::load(y + i), Float::load(z + i)}; }
  TESSERA_INLINE void append(Vec3 v, Mask active, int i) {
    compress_store(v.x, active, x + i);
    compress_store(v.y, active, y + i);
    compress_store(v.z, active, z + i);
  }
};

struct alignas(64) SpectrumLanes {
  alignas(64) float c[kSpectrumLanes][kPadded];

  TESSERA_INLINE Spectrum load(int i) const {
    Spectrum s;
    for (int k = 0; k < kSpectrumLanes; ++k) s.c[k] = Float::load(c[k] + i);
    return s;
  }
  TESSERA_INLINE void store(Spectrum s, int i) {
    for (int k = 0; k < kSpectrumLanes; ++k) s.c[k].store(c[k] + i);
  }
  TESSERA_INLINE void append(Spectrum s, Mask active, int i) {
    for (int k = 0; k < kSpectrumLanes; ++k) compress_store(s.c[k], active, c[k] + i);
  }
};

/// One entry a path that is still alive, in no order that matters: `slot` says which sample it belongs to.
struct PathState {
  Vec3Lanes origin, direction;
  SpectrumLanes beta;            // throughput
  alignas(64) Lanes<float> pdf;  // of the BSDF sample that led here, solid angle; 0 after a delta lobe or the camera
  alignas(64) Lanes<float> eta_scale;  // undoes the 1/eta^2 of refraction, for Russian roulette
  alignas(64) Lanes<std::int32_t> slot;
  Vec3Lanes normal;  // where the path was last scattered, as in Receiver; only with LightTable::uses_normals
  // Scenes with motion only: from 0 (the shutter opens) to 1, the same along a path
  alignas(64) Lanes<float> time;
  // Volumetric scenes only
  Vec3Lanes reference;  // where the path was last scattered; `origin` is where it last crossed something
  alignas(64) Lanes<std::int32_t> medium;  // around `origin`; -1: none
};

/// HitState::shape of a path that was scattered by its medium, at hits.t.
inline constexpr std::int32_t kScatteredByMedium = -2;

/// What the rays met, entry by entry.
struct HitState {
  alignas(64) Lanes<float> t, u, v;
  alignas(64) Lanes<std::int32_t> primitive, shape, instance;
};

/// Paths and what they met in the order in which they are shaded.
struct SortedState {
  PathState paths;
  HitState hits;
  alignas(64) Lanes<std::int32_t> order;  // entries of the unsorted state
  std::uint8_t group[kPadded];            // of each of those
};

/// One entry a sample of the batch.
struct SampleState {
  alignas(64) Lanes<std::uint32_t> pixel_hash, reversed_sample;
  SpectrumLanes radiance;
  alignas(64) Lanes<float> filter_weight, coverage, depth;
  SpectrumLanes albedo;
  Vec3Lanes normal;
};

/// Shadow rays waiting to be traced, with what they carry if nothing is in the way.
struct ShadowQueue {
  Vec3Lanes origin, direction;
  alignas(64) Lanes<float> distance;
  SpectrumLanes contribution;
  alignas(64) Lanes<std::int32_t> slot;
  alignas(64) Lanes<float> time;           // scenes with motion only
  alignas(64) Lanes<std::int32_t> medium;  // volumetric scenes only: around the origin
  int size = 0;
};

/// Paths that passed a surface and are traced on.
struct TransitState {
  alignas(64) Lanes<std::int32_t> path;  // entry of PathState
  Vec3Lanes origin, direction;
  alignas(64) Lanes<float> time;  // scenes with motion only
  HitState hits;
};

// As the tracer wants them.
inline HitArrays arrays_of(HitState& hits) {
  return {hits.t, hits.u, hits.v, hits.primitive, hits.shape, hits.instance};
}
inline RayArrays arrays_of(const Vec3Lanes& origin, const Vec3Lanes& direction, const float* times) {
  return {origin.x, origin.y, origin.z, direction.x, direction.y, direction.z, times};
}

}  // namespace tessera::render::TESSERA_ISA
