#include "render/light/area_point.h"
#include "render/light/light_access.h"
#include "render/light/models.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// How a whole sphere looks from outside.
struct Cone {
  Vec3 axis;
  Float distance;  // to the centre
  Float radius;
  Float clearance_squared;  // distance^2 - radius^2
  Float one_minus_cos_max;
  Mask usable;  // a whole, round sphere seen from outside
};

Cone cone(const LightLanes& lanes, Vec3 reference) {
  Cone c;
  c.radius = lanes.field(&LightRecord::radius);
  const Vec3 to_centre = lanes.field3(&LightRecord::position) - reference;
  c.distance = length(to_centre);
  c.clearance_squared = (c.distance - c.radius) * (c.distance + c.radius);
  c.usable = lanes.active & (c.radius > 0.0f) & (c.clearance_squared > 0.0f);
  const Float inv = 1.0f / select(c.usable, c.distance, 1.0f);
  c.axis = to_centre * inv;
  // 1 - cos = sin^2 / (1 + cos) keeps its digits for small angles.
  const Float sin_squared = sqr(c.radius * inv);
  const Float cos_max = sqrt(max(c.clearance_squared, 0.0f)) * inv;
  c.one_minus_cos_max = select(c.usable, sin_squared / (1.0f + cos_max), 1.0f);
  return c;
}

/// Samples the solid angle of a sphere uniformly, from outside.
LightSample sample_cone(const LightLanes& lanes, const Cone& c, Vec3 reference, Vec2 u) {
  const Vec3 local = square_to_cone(u, c.one_minus_cos_max);
  LightSample s;
  s.wi = Frame::from_normal(c.axis).to_world(local);
  // The nearer intersection t = b - h, where b is the distance along wi of the point nearest to the centre
  // and h the half chord; written as a quotient because b and h may be close.
  const Float b = c.distance * local.z;
  const Float off_axis_squared = sqr(c.distance) * (sqr(local.x) + sqr(local.y));
  const Float half_chord = safe_sqrt(sqr(c.radius) - off_axis_squared);
  const Float distance = c.clearance_squared / max(b + half_chord, 1e-30f);
  // At the limb the error along the ray grows no further than the chord over which the surface bends away by
  // that much.
  const Float error = ray_end_error(reference, fma(s.wi, distance, reference), c.radius, distance);
  const Float cos_light = max(half_chord, sqrt(0.5f * c.radius * error)) / c.radius;
  s.distance = shortened(distance, error, cos_light);
  s.radiance = lanes.radiance();
  s.pdf = cone_pdf(c.one_minus_cos_max);
  // Outside is the front, unless the shape is flipped.
  const Mask front = ~QuadricLanes(lanes).flipped() | (lanes.field(&LightRecord::two_sided) != 0);
  s.valid = c.usable & front;
  s.delta = Mask::none();
  return s;
}

/// Samples the surface: from inside, and spheres that are cut or squeezed.
LightSample sample_surface(const LightLanes& lanes, Vec3 reference, Vec2 u) {
  const AreaPoint at = sample_sphere_area(lanes, u);
  return sample_from_point(lanes, reference, at.point, at.normal, at.density, at.extent);
}

Float surface_pdf(const LightLanes& lanes, Vec3 reference, Vec3 wi, Vec3 point, Vec3 normal) {
  return pdf_from_point(lanes, reference, wi, point, normal, sphere_area_density(lanes, point));
}

/// A sphere: its solid angle is sampled uniformly from outside, else its surface.
class SphereLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    const LightLanes lanes{table, light, active};
    const Cone c = cone(lanes, from.p);
    const Mask by_surface = and_not(active, c.usable);
    LightSample s = sample_cone({table, light, c.usable}, c, from.p, u);
    if (any(by_surface)) s = select(c.usable, s, sample_surface({table, light, by_surface}, from.p, u));
    return s;
  }

  Float pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point, Vec3 normal,
            Mask active) const override {
    const LightLanes lanes{table, light, active};
    const Cone c = cone(lanes, from.p);
    const Mask by_surface = and_not(active, c.usable);
    Float density =
        select_or_zero(lanes.shines_towards(normal, -wi) & c.usable, cone_pdf(c.one_minus_cos_max));
    if (any(by_surface)) {
      density =
          select(by_surface, surface_pdf({table, light, by_surface}, from.p, wi, point, normal), density);
    }
    return density;
  }
};

}  // namespace

const LightModel& sphere_light() {
  static const SphereLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
