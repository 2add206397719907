#include "render/light/area/area_light.h"

#include "render/core/constants.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

LightSample AreaLight::sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                              Mask active) const {
  const LightLanes lanes{table, light, active, from.time};
  const AreaPoint at = sample_point(lanes, u);
  LightSample s = sample_from_point(lanes, from.p, at.point, at.normal, at.density, at.extent);
  s.barycentric = at.barycentric;
  return s;
}

Float AreaLight::pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point,
                     Vec3 normal, Mask active) const {
  const LightLanes lanes{table, light, active, from.time};
  return pdf_from_point(lanes, from.p, wi, point, normal, density_at(lanes, point));
}

Emission AreaLight::emit(const LightTable& table, Int light, Float time, Vec2 u_place, Vec2 u_direction,
                         Mask active) const {
  const LightLanes lanes{table, light, active, time};
  const AreaPoint at = sample_point(lanes, u_place);
  // Either side of a two-sided emitter, by the first half of one number.
  const Mask two_sided = lanes.field(&LightRecord::two_sided) != 0;
  const Mask back = two_sided & (u_direction.x >= 0.5f);
  u_direction.x =
      select(two_sided, select(back, 2.0f * u_direction.x - 1.0f, 2.0f * u_direction.x), u_direction.x);
  const Vec3 normal = select(back, -at.normal, at.normal);
  const Vec3 direction = Frame::from_normal(normal).to_world(square_to_cosine_hemisphere(u_direction));

  Color radiance = lanes.radiance();
  if (table.any_textures)
    radiance = radiance * emission_texture(table, light, time, at.point, at.barycentric, active);
  const Float flux = select(two_sided, Float(2 * kPi), Float(kPi)) / at.density;
  const Float error = ray_end_error(at.point, at.point, at.extent, Float(0.0f));
  return {at.point, normal * error, direction, radiance * flux, active & is_finite(flux),
          normal,   at.barycentric};
}

EmissionDensity AreaLight::emission_density(const LightTable& table, Int light, Float time, Vec3 point,
                                            Float cosine, Vec3, Mask active) const {
  const LightLanes lanes{table, light, active, time};
  const Mask two_sided = lanes.field(&LightRecord::two_sided) != 0;
  const Float density = abs(cosine) * select(two_sided, Float(kInv2Pi), Float(kInvPi));
  return {density_at(lanes, point), select_or_zero(active & ((cosine > 0.0f) | two_sided), density)};
}

double AreaLight::power(const LightTable&, const LightRecord& light) const {
  return std::numbers::pi * light.area * mean_radiance(light) * (light.two_sided ? 2 : 1);
}

LightBounds AreaLight::bounds(const LightTable& table, const LightRecord& light) const {
  LightBounds b;
  b.reach = std::numbers::pi / 2;
  b.two_sided = light.two_sided != 0;
  b.intensity = mean_radiance(light) * light.area;
  bound(table, light, b);
  return b;
}

Float AreaLight::density_at(const LightLanes& lanes, Vec3) const {
  return 1.0f / lanes.field(&LightRecord::area);
}

void AreaLight::append(const ShapeTable& shapes, const ShapeRecord& shape, const LightRecord& light, float,
                       std::vector<LightRecord>& lights) const {
  describe(shapes, shape, lights.emplace_back(light));
}

}  // namespace tessera::render::TESSERA_ISA
