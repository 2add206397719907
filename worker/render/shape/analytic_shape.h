// The interface of shapes that rays meet by a formula of ours. One shape a file: its bounds, its nearest hit,
// and the surface there. Whatever structure finds the candidates (accel/) asks these.
#pragma once

#include <vector>

#include "render/core/model_table.h"
#include "render/shape/exact_ray.h"
#include "render/shape/surface.h"

namespace tessera::render {

struct RoundForm;  // round_form.h

namespace TESSERA_ISA {

/// 16 rays, in the space that the shape is placed in. Directions may have any length; hits are wanted in
/// (t_near, t_far).
struct ShapeRays {
  Vec3 o, d;
  Float t_near, t_far;
  Mask active;
};

// double_ray.h
struct DoubleRay;
struct SolidSpans;

struct ShapeBounds {
  float low[3], high[3];
};

/// Models are stateless: one object serves all shapes of its kind. `primitive` counts from 0 within a shape.
class AnalyticShape {
 public:
  virtual ~AnalyticShape() = default;
  virtual std::int32_t primitive_count(const ShapeTable&, const ShapeRecord&) const { return 1; }
  /// A box about the primitive, with room for the roundings of transform and intersection, in the space that
  /// the shape is placed in.
  virtual ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape,
                             std::int32_t primitive) const = 0;
  /// The ray parameter of the nearest hit of each active lane; negative where there is none.
  virtual Float nearest(const ShapeTable& table, const ShapeRecord& shape, std::int32_t primitive,
                        const ShapeRays& rays) const = 0;
  /// Active lanes that hit it at all: of shapes that know this sooner than where.
  virtual Mask occluded(const ShapeTable& table, const ShapeRecord& shape, std::int32_t primitive,
                        const ShapeRays& rays) const {
    return rays.active & (nearest(table, shape, primitive, rays) >= 0.0f);
  }
  /// Appends the parameters, in any order, at which the line of `ray` crosses the primitive; those at t <= 0
  /// may be among them. A place where it touches the shape counts twice. In double precision where the shape
  /// has roots of its own in it; else (this default) by going on from one nearest hit to the next, in single
  /// precision, by which crossings closer together than 2^-21 of t are taken for one.
  virtual void crossings(const ShapeTable& table, const ShapeRecord& shape, std::int32_t primitive,
                         const ExactRay& ray, std::vector<double>& found) const;
  /// Fills point, error, normals, parameters and, with `want_tangents`, tangents of lanes that hit the shape;
  /// `o` and `d` are the rays that did.
  virtual void surface(const ShapeTable& table, const ShapeRecord& shape, const Hit& hit, Vec3 o, Vec3 d,
                       Mask active, bool want_tangents, Surface& s) const = 0;

  /// All that is known in closed form; null for shapes that are not round, and of those where nobody needs
  /// it.
  virtual const RoundForm* round_form() const { return nullptr; }

  /// All of the ways of rays through a closed shape, for CSG; `ray` is in the shape's object space. Fills the
  /// first of `found`, in order, and returns their number. None for shapes that are not closed.
  virtual int spans(const ShapeTable&, const ShapeRecord&, const DoubleRay&, SolidSpans&) const { return 0; }
};

/// The model of a kind; null for kTriangles and kCurves, which Embree meets itself.
const AnalyticShape* analytic_shape(ShapeKind kind);

/// ModelOf calls this.
void set_model(ShapeKind kind, const AnalyticShape& model);

/// Adds a model that has no kind of its own; records of the kind returned have it. Before anything is built
/// or rendered: not thread-safe.
ShapeKind add_analytic_shape(const AnalyticShape& model);

/// Bounds of a box, given by its centre and half of its sides, that `transform` places: with that room.
ShapeBounds placed_bounds(const Affine& transform, const float (&centre)[3], const float (&half)[3]);

}  // namespace TESSERA_ISA

}  // namespace tessera::render
