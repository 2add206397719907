#include "render/shape/double_ray.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A polygon in z = 0, about the origin and of size 1; its corners are Facets.
class PolygonShape final : public CrossedShape {
 public:
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    return placed_bounds(table.quadrics[static_cast<std::size_t>(shape.quadric)].render_from_object,
                         {0, 0, 0}, {1, 1, 0});
  }

 protected:
  int cross(const ShapeTable& table, const QuadricRecord& q, const DoubleRay& ray,
            Crossings& found) const override {
    const Double s = -ray.o[2] / ray.d[2], x = ray.at(0, s), y = ray.at(1, s);
    // Edges that the line from here along +x crosses [Shimrat 1962]; each has its lower end and not its
    // upper.
    const Facet* const corners = table.facets.data() + q.first_facet;
    DoubleMask inside = x != x;
    for (int i = 0, j = q.facet_count - 1; i < q.facet_count; j = i++) {
      const double ax = corners[j].normal[0], ay = corners[j].normal[1], bx = corners[i].normal[0],
                   by = corners[i].normal[1];
      const DoubleMask spans = (y < ay) ^ (y < by);
      const Double side = (x - ax) * (by - ay) - (y - ay) * (bx - ax);
      inside ^= spans & ((side < 0.0) ^ (splat(by) < ay));
    }
    found.s[0] = inside & (ray.d[2] != 0.0) & (s == s) ? s : splat(kNoRoot);
    return 1;
  }
  ObjectPoint point_in_object(const ShapeTable&, const QuadricRecord&, Vec3 p) const override {
    const Float zero(0.0f), one(1.0f);
    ObjectPoint o;
    o.p = {p.x, p.y, zero};
    o.n = {zero, zero, one};
    o.uv = {p.x, p.y};
    o.dpdu = {one, zero, zero};
    o.dpdv = {zero, one, zero};
    o.extent = one;
    return o;
  }
};

}  // namespace

const ModelOf<PolygonShape> polygon(ShapeKind::kPolygon);

}  // namespace tessera::render::TESSERA_ISA
