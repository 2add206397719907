#include "render/light/light.h"
#include "render/light/positional_light.h"
#include "render/sampling/sphere_map.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A point light whose intensity in every direction is an equal-area octahedral map [pbrt-v4
/// GoniometricLight].
class GoniometricLight final : public PositionalLight {
 public:
  void apply_profile(const LightLanes& lanes, LightSample& s) const override {
    const Vec2 map = octahedral_from_direction(normalize(lanes.to_light(-s.wi)));
    // The map counts rows from the top, textures v from the bottom.
    if (lanes.table.any_textures) s.radiance = s.radiance * lanes.texture_at({map.x, 1.0f - map.y}, s.valid);
  }

  /// Power as if the picture were white.
  double power(const LightTable&, const LightRecord& light) const override {
    return 4 * std::numbers::pi * mean_radiance(light);
  }
};

}  // namespace

const ModelOf<GoniometricLight> goniometric(LightKind::kGoniometric);

}  // namespace tessera::render::TESSERA_ISA
