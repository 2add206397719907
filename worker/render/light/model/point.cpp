#include "render/light/light.h"
#include "render/light/positional_light.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Shines equally in all directions from one point.
class PointLight final : public PositionalLight {
 public:
  double power(const LightTable&, const LightRecord& light) const override {
    return 4 * std::numbers::pi * mean_radiance(light);
  }
};

}  // namespace

LightSample PositionalLight::sample(const LightTable& table, Int light, const Receiver& from, Vec2,
                                    Mask active) const {
  const LightLanes lanes{table, light, active};
  const Vec3 position = lanes.field3(&LightRecord::position);
  const Vec3 to_light = position - from.p;
  const Float distance_squared = length_squared(to_light);
  const Float distance = sqrt(distance_squared);
  const Mask apart = active & (distance_squared > 0.0f);
  LightSample s;
  s.wi = to_light * (1.0f / select(apart, distance, 1.0f));
  s.distance = shortened(distance, ray_end_error(from.p, position, 0.0f, distance), 1.0f);
  s.radiance = lanes.radiance() * (1.0f / select(apart, distance_squared, 1.0f));
  s.pdf = Float(1.0f);
  s.valid = and_not(apart, is_black(s.radiance));
  s.delta = active;
  apply_profile(lanes, s);
  return s;
}

const ModelOf<PointLight> point(LightKind::kPoint);

}  // namespace tessera::render::TESSERA_ISA
