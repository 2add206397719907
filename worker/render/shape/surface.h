// From a hit to the geometry of the surface there, 16 hits at a time.
#pragma once

#include "render/core/texture_point.h"
#include "render/core/vec.h"
#include "render/shape/shape_table.h"

namespace tessera::render::TESSERA_ISA {

/// Hit of a ray. `shape` is -1 for a miss; `instance` is -1 outside instances. Members are as HitArrays has
/// them.
struct Hit {
  Float t;     // ray parameter
  Float u, v;  // barycentric weights of vertices 1 and 2 (triangles)
  Int primitive;
  Int shape;
  Int instance;
  Float time = Float(0.0f);  // the ray's, 0 (the shutter opens) to 1; without motion it does not matter
  Int upper = Int(0);        // upper bits of the place, in scenes with objects within objects
};

/// A point on a surface, in render space.
struct Surface {
  Vec3 p;
  Float error;  // distance along `ng` within which the true surface lies
  Vec3 ng;      // geometric normal, unit
  Vec3 ns;      // shading normal, unit, on the side of ng
  Vec2 uv;
  Vec3 dpdu, dpdv;  // set with `want_tangents` alone
  Int material;
  Int light;  // -1: does not emit
  Int shape, primitive;
  Vec2 barycentric;
};

/// Geometry at the active hits of rays with origin `o` and direction `d`. Hit points are recomputed from the
/// surface itself (barycentrics, reprojection), not from the ray, so that `error` depends on the shape and
/// not on t [Pharr, Jakob & Humphreys, Physically Based Rendering, 4th ed., sec. 6.8].
Surface surface_at(const ShapeTable& table, const Hit& hit, Vec3 o, Vec3 d, Mask active, bool want_tangents);

TESSERA_INLINE TexturePoint texture_point(const Surface& s) {
  TexturePoint point;
  point.uv = s.uv, point.p = s.p, point.n = s.ns;
  point.shape = s.shape, point.primitive = s.primitive, point.barycentric = s.barycentric;
  return point;
}

/// `p` moved off its surface to the side that `w` points to.
TESSERA_INLINE Vec3 offset_origin(const Surface& s, Vec3 w) {
  return fma(s.ng, copysign(s.error, dot(w, s.ng)), s.p);
}

}  // namespace tessera::render::TESSERA_ISA
