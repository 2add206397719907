#include "render/light/light_access.h"
#include "render/light/models.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// One triangle of an emitting mesh, sampled uniformly by area.
class TriangleLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, Vec3 reference, Vec2 u, Mask active) const override {
    const LightLanes lanes{table, light, active};
    const Vec3 p0 = lanes.field3(&LightRecord::vertices, 0);
    const Vec3 p1 = lanes.field3(&LightRecord::vertices, 3);
    const Vec3 p2 = lanes.field3(&LightRecord::vertices, 6);
    const Vec3 e1 = p1 - p0, e2 = p2 - p0;
    const Barycentric b = square_to_triangle(u);
    const Vec3 point = p0 * b.b0 + p1 * b.b1 + p2 * b.b2;
    const Vec3 normal = normalize(cross(e1, e2));
    const Float extent = max(max_abs(e1), max_abs(e2));
    LightSample s = sample_from_point(lanes, reference, point, normal, 1.0f / lanes.field(&LightRecord::area), extent);
    s.barycentric = {b.b1, b.b2};
    return s;
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
