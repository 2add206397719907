#include "render/light/models.h"
#include "render/light/positional_light.h"
#include "render/sampling/sphere_map.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A point light whose intensity in every direction is an equal-area octahedral map [pbrt-v4
/// GoniometricLight].
class GoniometricLight final : public PositionalLight {
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

  /// Power as if the picture were white.
  double power(const LightTable&, const LightRecord& light) const override {
    return 4 * std::numbers::pi * mean_radiance(light);
  }
};

}  // namespace

const LightModel& goniometric_light() {
  static const GoniometricLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
