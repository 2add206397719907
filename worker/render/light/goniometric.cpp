#include "render/light/light_access.h"
#include "render/light/models.h"
#include "render/sampling/sphere_map.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A point light whose intensity in every direction is an equal-area octahedral map [pbrt-v4
/// GoniometricLight].
class GoniometricLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    LightSample s = point_light().sample(table, light, from, u, active);
    const LightLanes lanes{table, light, active};
    const Vec2 map = octahedral_from_direction(normalize(lanes.to_light(-s.wi)));
    // The map counts rows from the top, textures v from the bottom.
    if (table.any_textures) s.radiance = s.radiance * lanes.texture_at({map.x, 1.0f - map.y}, s.valid);
    return s;
  }

  Float pdf(const LightTable&, Int, const Receiver&, Vec3, Vec3, Vec3, Mask) const override { return 0.0f; }
};

}  // namespace

const LightModel& goniometric_light() {
  static const GoniometricLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
