#include "render/light/light_access.h"
#include "render/light/models.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Parallel light from infinitely far away.
class DistantLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, const Receiver&, Vec2, Mask active) const override {
    const LightLanes lanes{table, light, active};
    LightSample s;
    s.wi = -lanes.field3(&LightRecord::direction);
    s.distance = Float(kInfiniteDistance);
    s.radiance = lanes.radiance();
    s.pdf = Float(1.0f);
    s.valid = and_not(active, is_black(s.radiance));
    s.delta = active;
    return s;
  }

  Float pdf(const LightTable&, Int, const Receiver&, Vec3, Vec3, Vec3, Mask) const override { return 0.0f; }
};

}  // namespace

const LightModel& distant_light() {
  static const DistantLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
