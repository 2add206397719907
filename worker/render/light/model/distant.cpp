#include "render/core/constants.h"
#include "render/light/emission.h"
#include "render/light/light.h"
#include "render/light/light_access.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Parallel light from infinitely far away.
class DistantLight final : public LightModel {
 public:
  DistantLight() : LightModel({.at_infinity = true, .delta = true}) {}

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

  Emission emit(const LightTable& table, Int light, Float time, Vec2 u_place, Vec2 u_direction,
                Mask active) const override {
    return emit_from_infinity(*this, table, light, time, u_place, u_direction, active);
  }
  EmissionDensity emission_density(const LightTable& table, Int, Float, Vec3, Float, Vec3,
                                   Mask) const override {
    return {Float(kInvPi / (table.scene_radius * table.scene_radius)), Float(1.0f)};
  }

  double power(const LightTable& table, const LightRecord& light) const override {
    return scene_disk(table) * mean_radiance(light);
  }
  LightBounds bounds(const LightTable&, const LightRecord&) const override { return {}; }
};

}  // namespace

const ModelOf<DistantLight> distant(LightKind::kDistant);

}  // namespace tessera::render::TESSERA_ISA
