#include "render/shape/double_ray.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// All that is behind some planes [Haines 1991], in the cube from -1 to 1.
class PolyhedronShape final : public CrossedShape {
 public:
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    return placed_bounds(table.quadrics[static_cast<std::size_t>(shape.quadric)].render_from_object,
                         {0, 0, 0}, {1, 1, 1});
  }

 protected:
  int cross(const ShapeTable& table, const QuadricRecord& q, const DoubleRay& ray,
            Crossings& found) const override {
    ConvexSpan span;
    const Facet* const first = table.facets.data() + q.first_facet;
    for (const Facet* face = first; face != first + q.facet_count; ++face) {
      const double x = face->normal[0], y = face->normal[1], z = face->normal[2];
      span.cut(ray.o[0] * x + ray.o[1] * y + ray.o[2] * z - static_cast<double>(face->offset),
               ray.d[0] * x + ray.d[1] * y + ray.d[2] * z);
    }
    return span.crossings(found);
  }
  ObjectPoint point_in_object(const ShapeTable& table, const QuadricRecord& q, Vec3 p) const override {
    // The face that it is closest to, or farthest in front of.
    Float height(-__builtin_inff());
    ObjectPoint o;
    o.n = {Float(0.0f), Float(0.0f), Float(1.0f)};
    const Facet* const first = table.facets.data() + q.first_facet;
    for (const Facet* face = first; face != first + q.facet_count; ++face) {
      const Vec3 n{Float(face->normal[0]), Float(face->normal[1]), Float(face->normal[2])};
      const Float above = dot(n, p) - face->offset;
      const Mask nearer = above > height;
      height = select(nearer, above, height);
      o.n = select(nearer, n, o.n);
    }
    o.p = fma(o.n, -height, p);
    set_box_parameters(o.n, o);
    o.extent = Float(1.0f);
    return o;
  }
};

}  // namespace

const ModelOf<PolyhedronShape> polyhedron(ShapeKind::kPolyhedron);

}  // namespace tessera::render::TESSERA_ISA
