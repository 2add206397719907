#include "render/shape/double_ray.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// The cube from -1 to 1: three slabs [Kay & Kajiya 1986].
class BoxShape final : public CrossedShape {
 public:
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    return placed_bounds(table.quadrics[static_cast<std::size_t>(shape.quadric)].render_from_object,
                         {0, 0, 0}, {1, 1, 1});
  }

 protected:
  int cross(const ShapeTable&, const QuadricRecord&, const DoubleRay& ray, Crossings& found) const override {
    ConvexSpan span;
    for (int axis = 0; axis < 3; ++axis) {
      span.cut(ray.o[axis] - 1.0, ray.d[axis]);
      span.cut(-ray.o[axis] - 1.0, -ray.d[axis]);
    }
    return span.crossings(found);
  }
  ObjectPoint point_in_object(const ShapeTable&, const QuadricRecord&, Vec3 p) const override {
    const Float x = abs(p.x), y = abs(p.y), z = abs(p.z), zero(0.0f);
    const Mask on_x = (x >= y) & (x >= z), on_y = and_not(y >= z, on_x), on_z = ~(on_x | on_y);
    const auto side = [](Float a) { return copysign(Float(1.0f), a); };
    const auto within = [](Float a) { return clamp(a, -1.0f, 1.0f); };
    ObjectPoint o;
    o.n = {select(on_x, side(p.x), zero), select(on_y, side(p.y), zero), select(on_z, side(p.z), zero)};
    o.p = {select(on_x, o.n.x, within(p.x)), select(on_y, o.n.y, within(p.y)),
           select(on_z, o.n.z, within(p.z))};
    set_box_parameters(o.n, o);
    o.extent = Float(1.0f);
    return o;
  }
};

}  // namespace

const ModelOf<BoxShape> box(ShapeKind::kBox);

}  // namespace tessera::render::TESSERA_ISA
