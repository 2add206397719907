// Interface between queries and the kernels, which know the shapes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/query/query_structure.h"
#include "render/shape/exact_ray.h"
#include "render/shape/round_form.h"

namespace tessera::render {

/// One of all the places where a ray goes through a surface. Render space.
struct Crossing {
  double t = 0;           // ray parameter
  double b1 = 0, b2 = 0;  // triangles: weights of the second and third corner
  std::int32_t shape = -1, primitive = 0;
  std::int32_t instance = -1;  // index; -1: a shape of the world's own
  std::int8_t against = 0;     // triangles: 1 where the ray goes against the normal, -1 along it; else 0
};

struct SurfacePoint {
  float normal[3];  // geometric, unit
  float uv[2];
};

struct QueryKernel {
  /// Replaces `found` by all crossings at t > 0, in order of t, then of instance, shape and primitive.
  ///
  /// Crossings of triangles are found in double precision, and each crossing of a mesh once. A ray through an
  /// edge or a vertex counts as one beside it, moved by an infinitely small distance that is the same for all
  /// triangles [Edelsbrunner1990]; so what is closed is crossed an even number of times by every line.
  void (*find_crossings)(const QueryStructure& structure, const ExactRay& ray, float time,
                         std::vector<Crossing>& found);
  /// Normals and parameters at crossings, in single precision; one of `rays` and one of `points` each. They
  /// are the same whatever else is described with them.
  void (*describe)(const ShapeTable& table, std::span<const ExactRay* const> rays, float time,
                   std::span<const Crossing> crossings, std::span<SurfacePoint> points);
  /// The function of an implicit surface at a point of its object space.
  double (*implicit_value)(const ImplicitRecord& surface, const double (&p)[3]);
  /// All that is known of a kind in closed form; null where nothing is.
  const RoundForm* (*round_form)(ShapeKind kind);
};

}  // namespace tessera::render
