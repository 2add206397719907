// Rays in an implicit surface's object space, in double precision: seen from ten million sizes away, a
// double's last place is still a billionth of the size.
#pragma once

#include "render/core/wide_double.h"
#include "render/shape/analytic_shape.h"
#include "render/shape/implicit/implicit_record.h"

namespace tessera::render::TESSERA_ISA {

struct Point3 {
  Double x, y, z;
};

inline Double length_of(const Point3& v) { return sqrt(fma(v.x, v.x, fma(v.y, v.y, v.z * v.z))); }

/// A point or direction of object space: the sum of the two, right to about 2^-100 of the terms that it was
/// made of.
struct ExactPoint3 {
  Point3 value, rest;
};

/// The part [begin, end] of 16 rays that lies within the bounds of the surface.
struct ObjectChord {
  ExactPoint3 origin, direction;
  Double begin, end;
  Mask meets;

  /// Rounded at its own size, however far away the ray begins.
  Point3 at(Double t) const {
    const auto along = [t](Double from, Double way, Double from_rest, Double way_rest) {
      const Double product = t * way, rest = fma(t, way, -product);
      const Double sum = product + from, of_from = sum - product;
      const Double lost = (product - (sum - of_from)) + (from - of_from);
      return sum + (lost + (rest + fma(t, way_rest, from_rest)));
    };
    const Point3 &o = origin.value, &d = direction.value, &p = origin.rest, &q = direction.rest;
    return {along(o.x, d.x, p.x, q.x), along(o.y, d.y, p.y, q.y), along(o.z, d.z, p.z, q.z)};
  }
};

/// The map applied to (v, w): products of floats are exact in doubles, their sums are kept with what rounding
/// took [Ogita2005].
inline ExactPoint3 place_in_object(const Affine& a, Vec3 v, float w) {
  const Double x(v.x), y(v.y), z(v.z);
  ExactPoint3 p;
  const auto row = [&](int i, Double& value, Double& rest) {
    value = Double(double{a.m[i + 3]} * w), rest = Double(0.0);
    for (const Double& term : {x * Double(a.m[i]), y * Double(a.m[i + 1]), z * Double(a.m[i + 2])}) {
      const Double sum = value + term, of_term = sum - value;
      rest = rest + ((value - (sum - of_term)) + (term - of_term));
      value = sum;
    }
  };
  row(0, p.value.x, p.rest.x);
  row(4, p.value.y, p.rest.y);
  row(8, p.value.z, p.rest.z);
  return p;
}

inline void clip_to_box(const ImplicitRecord& surface, ObjectChord& chord) {
  const Point3 &o = chord.origin.value, &d = chord.direction.value;
  const Double from[3] = {o.x, o.y, o.z}, along[3] = {d.x, d.y, d.z};
  for (int a = 0; a < 3; ++a) {
    const Double low(surface.low[a]), high(surface.high[a]);
    const DoubleMask moves = abs(along[a]) > Double(1e-150);
    const Double inverse = Double(1.0) / select(moves, along[a], Double(1.0));
    const Double t0 = (low - from[a]) * inverse, t1 = (high - from[a]) * inverse;
    chord.begin = select(moves, max(chord.begin, min(t0, t1)), chord.begin);
    chord.end = select(moves, min(chord.end, max(t0, t1)), chord.end);
    chord.meets &= mask_of(moves | ((from[a] >= low) & (from[a] <= high)));
  }
}

inline void clip_to_sphere(const ImplicitRecord& surface, ObjectChord& chord) {
  const Point3& d = chord.direction.value;
  const auto from_centre = [&](const Point3& p) {
    return Point3{p.x - Double(surface.centre[0]), p.y - Double(surface.centre[1]),
                  p.z - Double(surface.centre[2])};
  };
  const auto dot = [](const Point3& a, const Point3& b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); };
  const Double inverse = Double(1.0) / dot(d, d);
  const Double middle = -dot(from_centre(chord.origin.value), d) * inverse;
  // From there again: seen from afar the first answer is off by roundings of the distance.
  const Point3 near = from_centre(chord.at(middle));
  const Double rest = -dot(near, d) * inverse;
  const Point3 nearest = from_centre(chord.at(middle + rest));
  const Double square = (Double(double{surface.radius} * surface.radius) - dot(nearest, nearest)) * inverse;
  const Double half = sqrt(max(square, Double(0.0)));
  chord.begin = max(chord.begin, middle + (rest - half));
  chord.end = min(chord.end, middle + (rest + half));
  chord.meets &= mask_of(square > Double(0.0));
}

inline ObjectChord chord_within(const ImplicitRecord& surface, Vec3 o, Vec3 d, Double t_near, Double t_far,
                                Mask active) {
  ObjectChord chord{place_in_object(surface.object_from_render, o, 1),
                    place_in_object(surface.object_from_render, d, 0), t_near, t_far, active};
  clip_to_box(surface, chord);
  if (surface.in_sphere) clip_to_sphere(surface, chord);
  chord.meets &= mask_of(chord.begin < chord.end);
  return chord;
}

/// The whole line of one ray within the bounds, in the first lane.
inline ObjectChord chord_of(const ImplicitRecord& surface, const ExactRay& ray) {
  const auto place = [&](const double(&v)[3], double w) {
    double p[3];
    for (int i = 0; i < 3; ++i) {
      const float* const row = surface.object_from_render.m + 4 * i;
      p[i] = row[0] * v[0] + row[1] * v[1] + row[2] * v[2] + w * row[3];
    }
    const Double zero(0.0);
    return ExactPoint3{{Double(p[0]), Double(p[1]), Double(p[2])}, {zero, zero, zero}};
  };
  ObjectChord chord{place(ray.o, 1), place(ray.d, 0), Double(-1e300), Double(1e300), Mask::first(1)};
  clip_to_box(surface, chord);
  if (surface.in_sphere) clip_to_sphere(surface, chord);
  chord.meets &= mask_of(chord.begin < chord.end);
  return chord;
}

}  // namespace tessera::render::TESSERA_ISA
