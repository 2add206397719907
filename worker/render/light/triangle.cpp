#include "render/light/area_point.h"
#include "render/light/light_access.h"
#include "render/light/models.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// One triangle of an emitting mesh, sampled uniformly by area.
class TriangleLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    const LightLanes lanes{table, light, active};
    const TrianglePoint sampled = sample_triangle_area(lanes, u);
    const AreaPoint& at = sampled.at;
    LightSample s = sample_from_point(lanes, from.p, at.point, at.normal, at.density, at.extent);
    s.barycentric = sampled.barycentric;
    return s;
  }

  Float pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point, Vec3 normal,
            Mask active) const override {
    const LightLanes lanes{table, light, active};
    return pdf_from_point(lanes, from.p, wi, point, normal, 1.0f / lanes.field(&LightRecord::area));
  }
};

}  // namespace

const LightModel& triangle_light() {
  static const TriangleLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
