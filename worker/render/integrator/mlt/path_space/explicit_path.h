// Paths as lists of their vertices, with all densities that mutations ask for.
//
// A path of n scattering events has vertices 0 (on the lens), 1 to n, and n + 1 (its end on a light). Sixteen
// of them are measured and grown at a time; in between, each lies in memory by itself, because vertices of
// one path become those of another at other places.
#pragma once

#include <algorithm>
#include <cstdint>

#include "render/integrator/mlt/path_space/limits.h"
#include "render/integrator/vertex/lanes.h"
#include "render/shape/surface.h"

namespace tessera::render::TESSERA_ISA {

/// Where the end of a path on a light is.
enum EndPlace : std::int32_t { kOnSurface, kAtPoint, kAtInfinity };

/// A vertex, as far as it does not depend on its neighbours. For an end at infinity `p` is the unit direction
/// to it.
template <class Form>
struct PointFields {
  typename Form::Vector p, ng, ns, dpdu, dpdv;
  typename Form::Scalar error, u, v, barycentric_u, barycentric_v;
  typename Form::Scalar mix;  // number that picks parts of mixed materials
  typename Form::Integer material, light, shape, primitive;
  typename Form::Integer specular;  // 1: light goes on by a delta lobe; 0: by others
  typename Form::Integer place;     // EndPlace

  template <class F, class... Points>
  static TESSERA_INLINE void for_each(F&& f, Points&... points) {
    f(points.p...), f(points.ng...), f(points.ns...), f(points.dpdu...), f(points.dpdv...);
    f(points.error...), f(points.u...), f(points.v...);
    f(points.barycentric_u...), f(points.barycentric_v...), f(points.mix...);
    f(points.material...), f(points.light...), f(points.shape...), f(points.primitive...);
    f(points.specular...), f(points.place...);
  }
};

/// One value of each field.
struct Alone {
  struct Vector {
    float x, y, z;
  };
  using Scalar = float;
  using Integer = std::int32_t;
};
/// Sixteen of each in memory.
struct SixteenInMemory {
  struct alignas(64) Vector {
    float x[kWidth], y[kWidth], z[kWidth];
  };
  using Scalar = float[kWidth];
  using Integer = std::int32_t[kWidth];
};
using PathPoint = PointFields<Alone>;
using WidePoint = PointFields<Wide16>;

/// A path, and how it could have been made. Densities are by area (of ends at infinity by solid angle, with
/// the place of the vertex beside them on a disk across the direction). Where light is mirrored or refracted
/// they and the value share one delta distribution, that of the direction to the light given that to the
/// eye; what stands here are its factors.
struct ExplicitPath {
  int events = 0;
  float lens_x = 0, lens_y = 0;  // in the unit square
  float time = 0;
  float film_x = 0, film_y = 0;  // pixels
  /// The measurement contribution function [Veach 1997, section 8.2] but for inverse squares and cosines of
  /// its edges, and the luminance of that; with them: 0 where the path carries no light, and nothing below is
  /// known.
  float light[kSpectrumLanes] = {};
  float luminance = 0;
  double brightness = 0;

  PathPoint points[kMostEvents + 2];  // but for the first

  // Density of vertex i, sampled from vertices i - 1 and i - 2 (the first: evenly on the film); sampled from
  // i + 1 and i + 2.
  float from_eye[kMostEvents + 2], from_light[kMostEvents + 2];
  // What those of the next vertex owe to the choice of a direction at i: density by solid angle, or of delta
  // lobes their probability.
  float eye_choice[kMostEvents + 2], light_choice[kMostEvents + 2];
  bool transmits[kMostEvents + 2];  // of delta lobes
  float sampled = 0;                // density of the end as a light that shines on vertex n
  float emitted = 0;                // of the end and of vertex n, as a path from the light
  float end_slope = 0;  // area of vertex n: solid angle (area, at infinity) at the end, times this

  const PathPoint& end() const { return points[events + 1]; }
  bool is_specular(int vertex) const { return points[vertex].specular != 0; }

  /// Takes over another path, but not what its arrays have beyond its end.
  void take(const ExplicitPath& other) {
    events = other.events;
    lens_x = other.lens_x, lens_y = other.lens_y;
    time = other.time;
    film_x = other.film_x, film_y = other.film_y;
    std::copy_n(other.light, kSpectrumLanes, light);
    luminance = other.luminance;
    brightness = other.brightness;
    sampled = other.sampled, emitted = other.emitted, end_slope = other.end_slope;
    const int vertices = events + 2;
    std::copy_n(other.points, vertices, points);
    std::copy_n(other.from_eye, vertices, from_eye);
    std::copy_n(other.from_light, vertices, from_light);
    std::copy_n(other.eye_choice, vertices, eye_choice);
    std::copy_n(other.light_choice, vertices, light_choice);
    std::copy_n(other.transmits, vertices, transmits);
  }
};

/// f(lane) of sixteen lanes.
template <class F>
TESSERA_INLINE Float floats_of(F&& f) {
  alignas(64) float values[kWidth];
  for (int i = 0; i < kWidth; ++i) values[i] = f(i);
  return Float::load(values);
}
template <class F>
TESSERA_INLINE Int ints_of(F&& f) {
  alignas(64) std::int32_t values[kWidth];
  for (int i = 0; i < kWidth; ++i) values[i] = f(i);
  return Int::load(values);
}

/// at(lane) is the point of a lane.
template <class F>
TESSERA_INLINE WidePoint load_points(F&& at) {
  alignas(64) PointFields<SixteenInMemory> together;
  for (int i = 0; i < kWidth; ++i) {
    const PathPoint& point = at(i);
    PointFields<Alone>::for_each(
        [&](auto& to, const auto& from) {
          for_each_component([&](auto& lanes, const auto& value) { lanes[i] = value; }, to, from);
        },
        together, point);
  }
  WidePoint wide;
  PointFields<Wide16>::for_each([](auto& to, const auto& from) { load_lanes(from, 0, to); }, wide, together);
  return wide;
}

/// Stores the active lanes; at(lane) is where.
template <class F>
TESSERA_INLINE void store_points(const WidePoint& wide, Mask active, F&& at) {
  alignas(64) PointFields<SixteenInMemory> together;
  PointFields<Wide16>::for_each([](const auto& from, auto& to) { store_lanes(from, to, 0); }, wide, together);
  for (std::uint32_t bits = active.bits(); bits != 0; bits &= bits - 1) {
    const int i = __builtin_ctz(bits);
    PathPoint& point = at(i);
    PointFields<Alone>::for_each(
        [&](auto& to, const auto& from) {
          for_each_component([&](auto& value, const auto& lanes) { value = lanes[i]; }, to, from);
        },
        point, together);
  }
}

TESSERA_INLINE Surface surface_of(const WidePoint& point) {
  Surface s;
  s.p = point.p, s.ng = point.ng, s.ns = point.ns, s.dpdu = point.dpdu, s.dpdv = point.dpdv;
  s.error = point.error;
  s.uv = {point.u, point.v}, s.barycentric = {point.barycentric_u, point.barycentric_v};
  s.material = point.material, s.light = point.light;
  s.shape = point.shape, s.primitive = point.primitive;
  return s;
}

/// A vertex on a surface that nothing is known of but where it is.
TESSERA_INLINE WidePoint point_on(const Surface& s, Float mix) {
  WidePoint point;
  point.p = s.p, point.ng = s.ng, point.ns = s.ns, point.dpdu = s.dpdu, point.dpdv = s.dpdv;
  point.error = s.error;
  point.u = s.uv.x, point.v = s.uv.y;
  point.barycentric_u = s.barycentric.x, point.barycentric_v = s.barycentric.y;
  point.mix = mix;
  point.material = s.material, point.light = s.light;
  point.shape = s.shape, point.primitive = s.primitive;
  point.specular = Int(0), point.place = Int(kOnSurface);
  return point;
}

}  // namespace tessera::render::TESSERA_ISA
