#include "render/light/light.h"
#include "render/light/positional_light.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A slide projector: a point light within a pyramid, its intensity a picture [pbrt-v4 ProjectionLight;
/// Mitsuba 3 projector].
class ProjectionLight final : public PositionalLight {
 public:
  void apply_profile(const LightLanes& lanes, LightSample& s) const override {
    const Vec3 w = lanes.to_light(-s.wi);
    const Float inverse = 0.5f / max(w.z, 1e-30f);
    const Vec2 uv{0.5f - w.x * inverse / lanes.field(&LightRecord::tan_x),
                  0.5f - w.y * inverse / lanes.field(&LightRecord::tan_y)};
    s.valid &= (w.z > 0.0f) & (uv.x >= 0.0f) & (uv.x <= 1.0f) & (uv.y >= 0.0f) & (uv.y <= 1.0f);
    const Mask even = s.valid & (lanes.field(&LightRecord::profile) == kEvenScreen);
    s.radiance *= select(even, 1.0f / max(w.z * w.z * w.z, 1e-30f), 1.0f);
    if (lanes.table.any_textures) s.radiance = s.radiance * lanes.texture_at(uv, s.valid);
  }

  /// Power as if the solid angle were that of a white picture seen from afar.
  double power(const LightTable&, const LightRecord& light) const override {
    return 4 * double{light.tan_x} * light.tan_y * mean_radiance(light);
  }

 protected:
  Directions directions(const LightLanes& lanes, Vec2 u) const override {
    const Float tan_x = lanes.field(&LightRecord::tan_x), tan_y = lanes.field(&LightRecord::tan_y);
    const Vec3 local = normalize(Vec3{(2.0f * u.x - 1.0f) * tan_x, (2.0f * u.y - 1.0f) * tan_y, Float(1.0f)});
    // The rows of the map into light space are its axes, as they are orthonormal.
    const Vec3 w = lanes.field3(&LightRecord::vertices, 0) * local.x +
                   lanes.field3(&LightRecord::vertices, 3) * local.y +
                   lanes.field3(&LightRecord::vertices, 6) * local.z;
    return {normalize(w), 4.0f * tan_x * tan_y * local.z * local.z * local.z};
  }
  Float direction_density(const LightLanes& lanes, Vec3 direction) const override {
    const Float tan_x = lanes.field(&LightRecord::tan_x), tan_y = lanes.field(&LightRecord::tan_y);
    const Vec3 w = lanes.to_light(direction);
    const Mask inside = (w.z > 0.0f) & (abs(w.x) <= tan_x * w.z) & (abs(w.y) <= tan_y * w.z);
    return select_or_zero(inside, 0.25f / max(tan_x * tan_y * w.z * w.z * w.z, 1e-30f));
  }
};

}  // namespace

const ModelOf<ProjectionLight> projection(LightKind::kProjection);

}  // namespace tessera::render::TESSERA_ISA
