#include "render/light/emission.h"

#include "render/core/constants.h"
#include "render/light/light_access.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {

Emission emit_from_infinity(const LightModel& model, const LightTable& table, Int light, Float time,
                            Vec2 u_place, Vec2 u_direction, Mask active) {
  const Vec3 centre{Float(table.scene_centre[0]), Float(table.scene_centre[1]), Float(table.scene_centre[2])};
  Receiver from(centre);
  from.time = time;
  const LightSample seen = model.sample(table, light, from, u_direction, active);
  const float radius = table.scene_radius;
  const Vec2 disk = square_to_disk(u_place);
  const Frame frame = Frame::from_normal(seen.wi);
  const Vec3 origin = centre + (frame.x * disk.x + frame.y * disk.y + seen.wi) * Float(radius);
  const Float area(kPi * radius * radius);
  return {origin, no_offset(), -seen.wi, seen.radiance * (area / select(seen.valid, seen.pdf, 1.0f)),
          active & seen.valid};
}

Emission sample_emission(const LightTable& table, Int light, Float time, Vec2 u_place, Vec2 u_direction,
                         Mask active) {
  Emission result{
      no_offset(), no_offset(), {Float(0.0f), Float(0.0f), Float(1.0f)}, Color(0.0f), Mask::none()};
  for_each_distinct(kind_of(table, light, active), active, [&](std::int32_t kind, Mask lanes) {
    const Emission one =
        light_model(static_cast<LightKind>(kind)).emit(table, light, time, u_place, u_direction, lanes);
    result.origin = select(lanes, one.origin, result.origin);
    result.offset = select(lanes, one.offset, result.offset);
    result.direction = select(lanes, one.direction, result.direction);
    result.flux = select(lanes, one.flux, result.flux);
    result.normal = select(lanes, one.normal, result.normal);
    result.barycentric = {select(lanes, one.barycentric.x, result.barycentric.x),
                          select(lanes, one.barycentric.y, result.barycentric.y)};
    result.valid |= lanes & one.valid;
  });
  return result;
}

EmissionDensity emission_density(const LightTable& table, Int light, Float time, Vec3 point, Float cosine,
                                 Vec3 direction, Mask active) {
  EmissionDensity result{Float(0.0f), Float(0.0f)};
  for_each_distinct(kind_of(table, light, active), active, [&](std::int32_t kind, Mask lanes) {
    const EmissionDensity one = light_model(static_cast<LightKind>(kind))
                                    .emission_density(table, light, time, point, cosine, direction, lanes);
    result.place = select(lanes, one.place, result.place);
    result.direction = select(lanes, one.direction, result.direction);
  });
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
