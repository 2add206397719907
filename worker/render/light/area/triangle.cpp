#include "render/core/constants.h"
#include "render/light/area/area_light.h"
#include "render/light/models.h"
#include "render/sampling/warp.h"
#include "render/shape/triangle_normal.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// One triangle of an emitting mesh, sampled uniformly by area.
class TriangleLight final : public AreaLight {
 protected:
  AreaPoint sample_point(const LightLanes& lanes, Vec2 u) const override {
    const Vec3 p0 = lanes.field3(&LightRecord::vertices, 0);
    const Vec3 p1 = lanes.field3(&LightRecord::vertices, 3);
    const Vec3 p2 = lanes.field3(&LightRecord::vertices, 6);
    const Vec3 e1 = p1 - p0, e2 = p2 - p0;
    const Float size = max(max_abs(e1), max_abs(e2));
    const Barycentric b = square_to_triangle(u);
    return {fma(p2, b.b2, fma(p1, b.b1, p0 * b.b0)),
            triangle_normal(e1, e2, size),
            1.0f / lanes.field(&LightRecord::area),
            size,
            {b.b1, b.b2}};
  }
  void bound(const LightTable& table, const LightRecord& light, LightBounds& b) const override {
    const vec64::Vec p0 = vec64::vec(light.vertices), p1 = vec64::vec(light.vertices + 3),
                     p2 = vec64::vec(light.vertices + 6);
    b.axis = unit(cross(p1 - p0, p2 - p0));
    for (const vec64::Vec& p : {p0, p1, p2}) b.add(p);
  }
};

}  // namespace

const LightModel& triangle_light() {
  static const TriangleLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
