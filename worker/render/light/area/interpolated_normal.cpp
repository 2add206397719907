#include "render/light/area/interpolated_normal.h"

#include "render/light/light_access.h"

namespace tessera::render::TESSERA_ISA {

Mask has_interpolated_normals(const LightTable& table, Int light, Mask active) {
  if (!table.any_interpolated) return Mask::none();
  return active &
         (gather_member(table.lights.data(), &LightRecord::profile, light, active) == kInterpolated) &
         (kind_of(table, light, active) == static_cast<std::int32_t>(LightKind::kTriangle));
}

Float interpolated_normal_factor(const LightTable& table, Int light, const Surface& surface, Vec3 wo,
                                 Float distance, Float bsdf_pdf, Mask active) {
  const Mask wanted = has_interpolated_normals(table, light, active);
  if (none(wanted)) return Float(1.0f);
  const LightLanes lanes{table, light, wanted};
  // Either side of a two-sided emitter is a front.
  const Float side = select((lanes.field(&LightRecord::two_sided) != 0) & (dot(surface.ng, wo) < 0.0f),
                            Float(-1.0f), Float(1.0f));
  const Float cos_s = dot(surface.ns, wo) * side, cos_g = dot(surface.ng, wo) * side;
  const Mask lit = wanted & (cos_s > 0.0f);
  const Float pick = lanes.field(&LightRecord::tan_x), area = lanes.field(&LightRecord::tan_y);
  // p_b / p_l, which may be huge where p_l is not.
  const Float ratio = bsdf_pdf * area * cos_s / (pick * sqr(distance));
  const Float weight = select_or_zero(bsdf_pdf > 0.0f, 1.0f / (1.0f + sqr(ratio)));
  const Float factor = fma(weight, cos_s / max(cos_g, 1e-6f) - 1.0f, Float(1.0f));
  return select(wanted, select_or_zero(lit, factor), Float(1.0f));
}

Float interpolated_normal_factor(const LightTable& table, Int light, Vec3 reference,
                                 const LightSample& sample, Float bsdf_pdf, Mask active) {
  const Mask wanted = has_interpolated_normals(table, light, active);
  if (none(wanted)) return Float(1.0f);
  const auto field = [&](std::int32_t LightRecord::*member) {
    return gather_member(table.lights.data(), member, light, wanted);
  };
  const Hit hit{Float(0.0f),
                sample.barycentric.x,
                sample.barycentric.y,
                field(&LightRecord::primitive),
                field(&LightRecord::shape),
                Int(-1)};
  const Surface surface = surface_at(*table.shapes, hit, reference, sample.wi, wanted, false);
  return interpolated_normal_factor(table, light, surface, -sample.wi, sample.distance, bsdf_pdf, wanted);
}

}  // namespace tessera::render::TESSERA_ISA
