#include "render/light/light.h"
#include "render/light/positional_light.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A point light within a cone. The intensity falls from whole at cos_inner to none at cos_outer as a
/// smoothstep of the cosine [pbrt-v4 SpotLight] or in proportion to the angle [Mitsuba 3 spot]. A texture
/// covers the square about the cone.
class SpotLight final : public PositionalLight {
 public:
  void apply_profile(const LightLanes& lanes, LightSample& s) const override {
    const Float cosine = -dot(lanes.field3(&LightRecord::direction), s.wi);
    const Float outer = lanes.field(&LightRecord::cos_outer), inner = lanes.field(&LightRecord::cos_inner);
    const Float width = inner - outer;
    // A cone without a soft edge is a step.
    const Mask soft = width > 0.0f;
    const Float t = clamp((cosine - outer) / select(soft, width, 1.0f), 0.0f, 1.0f);
    Float falloff =
        select(soft, t * t * (3.0f - 2.0f * t), select(cosine >= outer, Float(1.0f), Float(0.0f)));
    const Mask linear = lanes.active & soft & (lanes.field(&LightRecord::profile) == kLinearAngle);
    if (any(linear)) {
      const Float angle = acos(clamp(cosine, -1.0f, 1.0f)), outer_angle = acos(outer);
      const Float part = clamp((outer_angle - angle) / max(outer_angle - acos(inner), 1e-30f), 0.0f, 1.0f);
      falloff = select(linear, part, falloff);
    }
    s.radiance *= falloff;
    if (lanes.table.any_textures) {
      const Vec3 w = lanes.to_light(-s.wi);
      const Float scale = 0.5f / (lanes.field(&LightRecord::tan_x) * max(w.z, 1e-30f));
      s.radiance = s.radiance * lanes.texture_at({fma(w.x, scale, 0.5f), fma(w.y, scale, 0.5f)},
                                                 lanes.active & (falloff > 0.0f));
    }
    s.valid &= falloff > 0.0f;
  }

  /// The mean of a smoothstep over its range is one half.
  double power(const LightTable&, const LightRecord& light) const override {
    return 2 * std::numbers::pi * mean_radiance(light) *
           ((1 - light.cos_inner) + (light.cos_inner - light.cos_outer) / 2);
  }

  /// It shines into its cone, beyond cos_inner ever less.
  LightBounds bounds(const LightTable&, const LightRecord& light) const override {
    LightBounds b;
    b.intensity = mean_radiance(light);
    b.add(vec64::vec(light.position));
    b.axis = unit(vec64::vec(light.direction));
    b.angle = std::acos(std::clamp(double{light.cos_inner}, -1.0, 1.0));
    b.reach = std::acos(std::clamp(double{light.cos_outer}, -1.0, 1.0)) - b.angle;
    return b;
  }

 protected:
  Directions directions(const LightLanes& lanes, Vec2 u) const override {
    const Float one_minus_cos = 1.0f - lanes.field(&LightRecord::cos_outer);
    const Frame frame = Frame::from_normal(lanes.field3(&LightRecord::direction));
    return {frame.to_world(square_to_cone(u, one_minus_cos)), 2.0f * kPi * one_minus_cos};
  }
  Float direction_density(const LightLanes& lanes, Vec3 w) const override {
    const Float cosine = dot(lanes.field3(&LightRecord::direction), w);
    const Float outer = lanes.field(&LightRecord::cos_outer);
    return select_or_zero(cosine >= outer, kInv2Pi / (1.0f - outer));
  }
};

}  // namespace

const ModelOf<SpotLight> spot(LightKind::kSpot);

}  // namespace tessera::render::TESSERA_ISA
