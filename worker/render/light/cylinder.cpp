#include "render/light/area_point.h"
#include "render/light/light_access.h"
#include "render/light/models.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// The wall of a cylinder, sampled uniformly in object space.
class CylinderLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    const LightLanes lanes{table, light, active};
    const AreaPoint at = sample_cylinder_area(lanes, u);
    return sample_from_point(lanes, from.p, at.point, at.normal, at.density, at.extent);
  }

  Float pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point, Vec3 normal,
            Mask active) const override {
    const LightLanes lanes{table, light, active};
    return pdf_from_point(lanes, from.p, wi, point, normal, cylinder_area_density(lanes, point));
  }
};

}  // namespace

const LightModel& cylinder_light() {
  static const CylinderLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
