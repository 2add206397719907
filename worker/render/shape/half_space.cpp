#include "render/shape/double_ray.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// z <= 0; its plane ends where QuadricRecord::radius says, since bounds are finite.
class HalfSpaceShape final : public CrossedShape {
 public:
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(shape.quadric)];
    return placed_bounds(q.render_from_object, {0, 0, 0}, {q.radius, q.radius, 0});
  }
  /// Spans of all that is below the plane, which has no end here.
  int spans(const ShapeTable&, const ShapeRecord&, const DoubleRay& ray, SolidSpans& found) const override {
    const Double s = -ray.o[2] / ray.d[2];
    const DoubleMask down = ray.d[2]<0.0, up = ray.d[2]> 0.0, outside = ~(down | up) & (ray.o[2] > 0.0);
    found.enter[0] = down ? s : splat(-kNoRoot);
    found.leave[0] = up ? s : splat(kNoRoot);
    found.leave[0] = outside ? splat(-kNoRoot) : found.leave[0];
    return 1;
  }

 protected:
  int cross(const ShapeTable&, const QuadricRecord& q, const DoubleRay& ray,
            Crossings& found) const override {
    const double reach = q.radius;
    const Double s = -ray.o[2] / ray.d[2], x = ray.at(0, s), y = ray.at(1, s);
    const DoubleMask on = (ray.d[2] != 0.0) & (x <= reach) & (x >= -reach) & (y <= reach) & (y >= -reach);
    found.s[0] = on ? s : splat(kNoRoot);
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
    o.extent = max(abs(p.x), abs(p.y));
    return o;
  }
};

}  // namespace

const ModelOf<HalfSpaceShape> half_space(ShapeKind::kHalfSpace);

}  // namespace tessera::render::TESSERA_ISA
