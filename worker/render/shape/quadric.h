// Functions that shapes with an object space of their own share: rays in it, roots, and the surface in render
// space.
#pragma once

#include <cmath>

#include "render/core/affine.h"
#include "render/core/constants.h"
#include "render/shape/analytic_shape.h"

namespace tessera::render::TESSERA_ISA {

/// A sum and the rest that rounding took: `value` + `rest` is right to twice the digits of a float.
struct Exact {
  Float value, rest;
};
TESSERA_INLINE Exact two_product(Float a, Float b) {
  const Float p = a * b;
  return {p, fma(a, b, -p)};
}
TESSERA_INLINE Exact two_sum(Float a, Float b) {
  const Float s = a + b, of_b = s - a;
  return {s, (a - (s - of_b)) + (b - of_b)};
}
/// a . b + c [Ogita, Rump & Oishi 2005].
TESSERA_INLINE Exact exact_dot(const float (&a)[12], int row, Vec3 b, float c) {
  const Exact x = two_product(Float(a[row]), b.x), y = two_product(Float(a[row + 1]), b.y),
              z = two_product(Float(a[row + 2]), b.z);
  const Exact xy = two_sum(x.value, y.value), zc = two_sum(z.value, Float(c)),
              all = two_sum(xy.value, zc.value);
  return two_sum(all.value, ((x.rest + y.rest) + z.rest) + ((xy.rest + zc.rest) + all.rest));
}

/// Rays in the quadric's object space, with what rounding took off them: seen from a million radii away, a
/// float's last place is a tenth of the radius.
struct ObjectRays {
  Vec3 o, d;
  Vec3 o_rest, d_rest;
  Float t_near, t_far;
  Mask active;

  ObjectRays(const Affine& object_from_render, const ShapeRays& r)
      : t_near(r.t_near), t_far(r.t_far), active(r.active) {
    const auto& m = object_from_render.m;
    const auto place = [&](Vec3 v, float with_shift, Vec3& value, Vec3& rest) {
      const Exact x = exact_dot(m, 0, v, with_shift * m[3]), y = exact_dot(m, 4, v, with_shift * m[7]),
                  z = exact_dot(m, 8, v, with_shift * m[11]);
      value = {x.value, y.value, z.value};
      rest = {x.rest, y.rest, z.rest};
    };
    place(r.o, 1, o, o_rest);
    place(r.d, 0, d, d_rest);
  }
  /// The point at `t`, each coordinate rounded at its own size however far away it is.
  TESSERA_INLINE Vec3 at(Float t) const {
    const auto along = [t](Float from, Float way, Float from_rest, Float way_rest) {
      return fma(way, t, from) + fma(way_rest, t, from_rest);
    };
    return {along(o.x, d.x, o_rest.x, d_rest.x), along(o.y, d.y, o_rest.y, d_rest.y),
            along(o.z, d.z, o_rest.z, d_rest.z)};
  }
};

/// One ray in the object's space, about the point at which it is nearest to the origin: at o + (t - shift) d.
struct ExactObjectRay : ExactRay {
  double shift = 0;

  ExactObjectRay(const Affine& object_from_render, const ExactRay& ray) {
    const float* const m = object_from_render.m;
    double od = 0, dd = 0;
    for (int i = 0; i < 3; ++i) {
      const float* const row = m + 4 * i;
      o[i] = row[0] * ray.o[0] + row[1] * ray.o[1] + row[2] * ray.o[2] + row[3];
      d[i] = row[0] * ray.d[0] + row[1] * ray.d[1] + row[2] * ray.d[2];
      od += o[i] * d[i], dd += d[i] * d[i];
    }
    shift = -od / dd;
    for (int i = 0; i < 3; ++i) o[i] = at(i, shift);
  }
};

/// The same azimuth, of one point in double precision.
inline double azimuth(double x, double y) {
  const double phi = std::atan2(y, x);
  return phi < 0 ? phi + 2 * 3.14159265358979323846 : phi;
}

/// Nearest root in (t_near, t_far) whose point is inside the limits, or a negative number. The roots are t +
/// rest -+ half_chord, and `middle` is the point at t + rest.
template <class Inside>
TESSERA_INLINE Float nearest_root(const ObjectRays& r, Mask meets, Float t, Float rest, Float half_chord,
                                  Vec3 middle, Inside&& inside) {
  const Float t0 = t + (rest - half_chord), t1 = t + (rest + half_chord);
  const auto usable = [&](Float root, Vec3 p) {
    return meets & (root > r.t_near) & (root < r.t_far) & inside(p);
  };
  const Mask first = usable(t0, middle - r.d * half_chord);
  const Mask second = and_not(usable(t1, middle + r.d * half_chord), first);
  return select(first, t0, select(second, t1, -1.0f));
}

/// The azimuth, from 0 to 2 pi.
TESSERA_INLINE Float azimuth(Vec3 p) {
  const Float phi = atan2(p.y, p.x);
  return select(phi < 0.0f, phi + 2 * kPi, phi);
}

/// Point, normal and parameters on a shape, in its object space.
struct ObjectPoint {
  Vec3 p, n, dpdu, dpdv;
  Vec2 uv;
  Float extent;
};

/// All that is the same for all of them.
class QuadricShape : public AnalyticShape {
 public:
  Float nearest(const ShapeTable& table, const ShapeRecord& shape, std::int32_t,
                const ShapeRays& rays) const final {
    const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(shape.quadric)];
    return nearest_in_object(table, q, ObjectRays(q.object_from_render, rays));
  }
  void surface(const ShapeTable& table, const ShapeRecord& shape, const Hit& hit, Vec3 o, Vec3 d, Mask active,
               bool want_tangents, Surface& s) const final;

 protected:
  virtual Float nearest_in_object(const ShapeTable& table, const QuadricRecord& q,
                                  const ObjectRays& rays) const = 0;
  /// The point of the surface next to `p`.
  virtual ObjectPoint point_in_object(const ShapeTable& table, const QuadricRecord& q, Vec3 p) const = 0;
};

}  // namespace tessera::render::TESSERA_ISA
