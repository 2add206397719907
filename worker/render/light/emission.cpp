#include "render/light/emission.h"

#include "render/light/area_point.h"
#include "render/light/light_access.h"

namespace tessera::render::TESSERA_ISA {

namespace {

Vec3 no_offset() { return {Float(0.0f), Float(0.0f), Float(0.0f)}; }

/// Directions that a light at a point shines in, by solid angle.
struct Directions {
  Vec3 w;
  Float inverse_density;
};

Directions all_around(Vec2 u) { return {square_to_sphere(u), Float(4 * kPi)}; }

Directions within_cone(const LightLanes& lanes, Vec2 u) {
  const Float one_minus_cos = 1.0f - lanes.field(&LightRecord::cos_outer);
  const Frame frame = Frame::from_normal(lanes.field3(&LightRecord::direction));
  return {frame.to_world(square_to_cone(u, one_minus_cos)), 2.0f * kPi * one_minus_cos};
}

Directions within_pyramid(const LightLanes& lanes, Vec2 u) {
  const Float tan_x = lanes.field(&LightRecord::tan_x), tan_y = lanes.field(&LightRecord::tan_y);
  const Vec3 local = normalize(Vec3{(2.0f * u.x - 1.0f) * tan_x, (2.0f * u.y - 1.0f) * tan_y, Float(1.0f)});
  // The rows of the map into light space are its axes, as they are orthonormal.
  const Vec3 w = lanes.field3(&LightRecord::vertices, 0) * local.x +
                 lanes.field3(&LightRecord::vertices, 3) * local.y +
                 lanes.field3(&LightRecord::vertices, 6) * local.z;
  return {normalize(w), 4.0f * tan_x * tan_y * local.z * local.z * local.z};
}

/// Intensity is what arrives at distance 1.
Emission from_point(const LightTable& table, LightKind kind, Int light, Vec2 u, Mask active) {
  const LightLanes lanes{table, light, active};
  const Directions chosen = kind == LightKind::kSpot         ? within_cone(lanes, u)
                            : kind == LightKind::kProjection ? within_pyramid(lanes, u)
                                                             : all_around(u);
  const Vec3 position = lanes.field3(&LightRecord::position);
  const LightSample seen = light_model(kind).sample(table, light, position + chosen.w, u, active);
  return {position, no_offset(), chosen.w, seen.radiance * chosen.inverse_density, active & seen.valid};
}

/// Parallel light through a disk that covers the scene.
Emission from_infinity(const LightTable& table, LightKind kind, Int light, Vec2 u_place, Vec2 u_direction,
                       Mask active) {
  const Vec3 centre{Float(table.scene_centre[0]), Float(table.scene_centre[1]), Float(table.scene_centre[2])};
  const LightSample seen = light_model(kind).sample(table, light, centre, u_direction, active);
  const float radius = table.scene_radius;
  const Vec2 disk = square_to_disk(u_place);
  const Frame frame = Frame::from_normal(seen.wi);
  const Vec3 origin = centre + (frame.x * disk.x + frame.y * disk.y + seen.wi) * Float(radius);
  const Float area(kPi * radius * radius);
  return {origin, no_offset(), -seen.wi, seen.radiance * (area / select(seen.valid, seen.pdf, 1.0f)),
          active & seen.valid};
}

AreaPoint sample_area(LightKind kind, const LightLanes& lanes, Vec2 u, Vec2& barycentric) {
  switch (kind) {
    case LightKind::kRectangle:
      return rectangle_point(lanes, RectangleSides(lanes), u);
    case LightKind::kSphere:
      return sample_sphere_area(lanes, u);
    case LightKind::kDisk:
      return sample_disk_area(lanes, u);
    case LightKind::kCylinder:
      return sample_cylinder_area(lanes, u);
    default:
      break;
  }
  const TrianglePoint point = sample_triangle_area(lanes, u);
  barycentric = point.barycentric;
  return point.at;
}

Emission from_surface(const LightTable& table, LightKind kind, Int light, Vec2 u_place, Vec2 u_direction,
                      Mask active) {
  const LightLanes lanes{table, light, active};
  Vec2 barycentric{Float(0.0f), Float(0.0f)};
  const AreaPoint at = sample_area(kind, lanes, u_place, barycentric);
  // Either side of a two-sided emitter, by the first half of one number.
  const Mask two_sided = lanes.field(&LightRecord::two_sided) != 0;
  const Mask back = two_sided & (u_direction.x >= 0.5f);
  u_direction.x =
      select(two_sided, select(back, 2.0f * u_direction.x - 1.0f, 2.0f * u_direction.x), u_direction.x);
  const Vec3 normal = select(back, -at.normal, at.normal);
  const Vec3 direction = Frame::from_normal(normal).to_world(square_to_cosine_hemisphere(u_direction));

  Spectrum radiance = lanes.radiance();
  if (table.any_textures) radiance = radiance * emission_texture(table, light, at.point, barycentric, active);
  const Float flux = select(two_sided, Float(2 * kPi), Float(kPi)) / at.density;
  const Float error = ray_end_error(at.point, at.point, at.extent, Float(0.0f));
  return {at.point, normal * error, direction, radiance * flux, active & is_finite(flux)};
}

}  // namespace

Emission sample_emission(const LightTable& table, Int light, Vec2 u_place, Vec2 u_direction, Mask active) {
  Emission result{
      no_offset(), no_offset(), {Float(0.0f), Float(0.0f), Float(1.0f)}, Spectrum(0.0f), Mask::none()};
  for_each_distinct(kind_of(table, light, active), active, [&](std::int32_t k, Mask lanes) {
    const auto kind = static_cast<LightKind>(k);
    Emission one;
    switch (kind) {
      case LightKind::kPoint:
      case LightKind::kSpot:
      case LightKind::kProjection:
      case LightKind::kGoniometric:
        one = from_point(table, kind, light, u_direction, lanes);
        break;
      case LightKind::kDistant:
      case LightKind::kInfinite:
        one = from_infinity(table, kind, light, u_place, u_direction, lanes);
        break;
      default:
        one = from_surface(table, kind, light, u_place, u_direction, lanes);
        break;
    }
    result.origin = select(lanes, one.origin, result.origin);
    result.offset = select(lanes, one.offset, result.offset);
    result.direction = select(lanes, one.direction, result.direction);
    result.flux = select(lanes, one.flux, result.flux);
    result.valid |= lanes & one.valid;
  });
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
