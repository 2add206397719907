#include "render/light/light_access.h"
#include "render/light/models.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A slide projector: a point light within a pyramid, its intensity a picture [pbrt-v4 ProjectionLight;
/// Mitsuba 3 projector].
class ProjectionLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    LightSample s = point_light().sample(table, light, from, u, active);
    const LightLanes lanes{table, light, active};
    const Vec3 w = lanes.to_light(-s.wi);
    const Float inverse = 0.5f / max(w.z, 1e-30f);
    const Vec2 uv{0.5f - w.x * inverse / lanes.field(&LightRecord::tan_x),
                  0.5f - w.y * inverse / lanes.field(&LightRecord::tan_y)};
    s.valid &= (w.z > 0.0f) & (uv.x >= 0.0f) & (uv.x <= 1.0f) & (uv.y >= 0.0f) & (uv.y <= 1.0f);
    const Mask even = s.valid & (lanes.field(&LightRecord::profile) == kEvenScreen);
    s.radiance *= select(even, 1.0f / max(w.z * w.z * w.z, 1e-30f), 1.0f);
    if (table.any_textures) s.radiance = s.radiance * lanes.texture_at(uv, s.valid);
    return s;
  }

  Float pdf(const LightTable&, Int, const Receiver&, Vec3, Vec3, Vec3, Mask) const override { return 0.0f; }
};

}  // namespace

const LightModel& projection_light() {
  static const ProjectionLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
