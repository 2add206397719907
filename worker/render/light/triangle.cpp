#include "render/light/light_access.h"
#include "render/light/models.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {
namespace {

struct Corners {
  Vec3 p0, p1, p2;
};

Corners corners(const LightLanes& lanes) {
  const ShapeTable& table = *lanes.table.shapes;
  const ShapeRecord* shapes = table.shapes.data();
  const Int shape = lanes.field(&LightRecord::shape);
  const Int triangle =
      gather_member(shapes, &ShapeRecord::first_triangle, shape, lanes.active) + lanes.field(&LightRecord::primitive);
  const Int first_vertex = gather_member(shapes, &ShapeRecord::first_vertex, shape, lanes.active);
  const auto vertex = [&](int corner) {
    const UInt index = gather(table.triangles.data() + corner, triangle * 3, lanes.active);
    return gather3(table.positions.data(), first_vertex + bit_cast<std::int32_t>(index), lanes.active);
  };
  return {vertex(0), vertex(1), vertex(2)};
}

/// One triangle of an emitting mesh, sampled uniformly by area.
class TriangleLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, Vec3 reference, Vec2 u, Mask active) const override {
    const LightLanes lanes{table, light, active};
    const Corners c = corners(lanes);
    const Vec3 e1 = c.p1 - c.p0, e2 = c.p2 - c.p0;
    const Barycentric b = square_to_triangle(u);
    const Vec3 point = c.p0 * b.b0 + c.p1 * b.b1 + c.p2 * b.b2;
    const Vec3 normal = normalize(cross(e1, e2));
    const Float extent = max(max_abs(e1), max_abs(e2));
    return sample_from_point(lanes, reference, point, normal, 1.0f / lanes.field(&LightRecord::area), extent);
  }

  Float pdf(const LightTable& table, Int light, Vec3 reference, Vec3 wi, Vec3 point, Vec3 normal,
            Mask active) const override {
    const LightLanes lanes{table, light, active};
    return pdf_from_point(lanes, reference, wi, point, normal, 1.0f / lanes.field(&LightRecord::area));
  }
};

}  // namespace

const LightModel& triangle_light() {
  static const TriangleLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
