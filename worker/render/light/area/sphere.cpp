#include <algorithm>
#include <cmath>

#include "render/core/constants.h"
#include "render/light/area/quadric_access.h"
#include "render/light/light.h"
#include "render/light/sphere_cone.h"

namespace tessera::render::TESSERA_ISA {
namespace {

Cone cone(const LightLanes& lanes, Vec3 reference) {
  Cone c =
      cone(lanes.field3(&LightRecord::position), lanes.field(&LightRecord::radius), reference, lanes.active);
  // Points of its own surface may be outside by rounding, where the origins of their rays are inside: of
  // both, the density is that by area.
  const Float error = ray_end_error(reference, reference, c.radius, c.centre_distance);
  c.usable &= c.centre_distance - c.radius > error;
  return c;
}

/// Samples the solid angle of a sphere uniformly, from outside.
LightSample sample_cone(const LightLanes& lanes, const Cone& c, Vec3 reference, Vec2 u) {
  const Chord chord = sample_chord(c, c.one_minus_cos_max, u);
  LightSample s;
  s.wi = chord.wi;
  const Float distance = chord.near_end(c);
  // At the limb the error along the ray grows no further than the chord over which the surface bends away by
  // that much.
  const Float error = ray_end_error(reference, fma(s.wi, distance, reference), c.radius, distance);
  const Float cos_light = max(chord.half_length, sqrt(0.5f * c.radius * error)) / c.radius;
  s.distance = shortened(distance, error, cos_light);
  s.cosine = chord.half_length / c.radius;
  s.radiance = lanes.radiance();
  s.pdf = cone_pdf(c.one_minus_cos_max);
  // Outside is the front, unless the shape is flipped.
  const Mask front = ~QuadricLanes(lanes).flipped() | (lanes.field(&LightRecord::two_sided) != 0);
  s.valid = c.usable & front;
  s.delta = Mask::none();
  return s;
}

/// The factor by which an affine map scales every direction, 0 when it is not one factor (to a part in 10^4).
double similarity_scale(const Affine& a) {
  const vec64::Vec x = column(a, 0), y = column(a, 1), z = column(a, 2);
  const double scale = length(x);
  const double skew =
      std::max({std::abs(length(y) - scale), std::abs(length(z) - scale), std::abs(dot(x, y)) / scale,
                std::abs(dot(x, z)) / scale, std::abs(dot(y, z)) / scale});
  return skew <= 1e-4 * scale ? scale : 0;
}

/// Area of a zone of a sphere under any affine map, by quadrature where there is no closed form.
double sphere_area(const QuadricRecord& q) {
  const double zone = double{q.radius} * q.phi_max * (double{q.z_max} - q.z_min);
  const Affine& m = q.render_from_object;
  const vec64::Vec x = column(m, 0), y = column(m, 1), z = column(m, 2);
  if (const double scale = similarity_scale(m); scale > 0) return zone * scale * scale;
  // Areas scale by |cofactor(M) n|, whose columns are these.
  const vec64::Vec cx = cross(y, z), cy = cross(z, x), cz = cross(x, y);
  constexpr int kSteps = 128;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double nz = (q.z_min + (i + 0.5) / kSteps * (double{q.z_max} - q.z_min)) / q.radius;
    const double r = std::sqrt(std::max(0.0, 1 - nz * nz));
    for (int j = 0; j < kSteps; ++j) {
      const double phi = (j + 0.5) / kSteps * q.phi_max;
      const double nx = r * std::cos(phi), ny = r * std::sin(phi);
      vec64::Vec n;
      for (std::size_t c = 0; c < 3; ++c) n[c] = nx * cx[c] + ny * cy[c] + nz * cz[c];
      sum += length(n);
    }
  }
  return zone * sum / (kSteps * kSteps);
}

/// A sphere: its solid angle is sampled uniformly from outside, else its surface.
class SphereLight final : public AreaLight {
 public:
  SphereLight() : AreaLight({.surface = ShapeKind::kSphere}) {}

  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    const LightLanes lanes{table, light, active};
    const Cone c = cone(lanes, from.p);
    const Mask by_surface = and_not(active, c.usable);
    LightSample s = sample_cone({table, light, c.usable}, c, from.p, u);
    if (any(by_surface)) s = select(c.usable, s, AreaLight::sample(table, light, from, u, by_surface));
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
      const Float by_area = AreaLight::pdf(table, light, from, wi, point, normal, by_surface);
      density = select(by_surface, by_area, density);
    }
    return density;
  }

 protected:
  /// From inside, and for spheres that are cut or squeezed.
  AreaPoint sample_point(const LightLanes& lanes, Vec2 u) const override {
    const QuadricLanes quadric(lanes);
    const Float radius = quadric.field(&QuadricRecord::radius);
    const Float z = lerp(u.x, quadric.field(&QuadricRecord::z_min), quadric.field(&QuadricRecord::z_max));
    const Float r = safe_sqrt((radius - z) * (radius + z));
    const Float phi = u.y * quadric.field(&QuadricRecord::phi_max);
    const Vec3 in_object = {r * cos(phi), r * sin(phi), z};

    const WideAffine to = quadric.affine(&QuadricRecord::render_from_object);
    const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
    const Vec3 n = in_object * (1.0f / radius);
    return {transform_point(to, in_object), quadric.front(normalize(transform_normal(from, n))),
            stretched_density(zone_area(quadric), to, from, n),
            max_abs(transform_vector(to, {radius, radius, radius}))};
  }
  Float density_at(const LightLanes& lanes, Vec3 point) const override {
    const QuadricLanes quadric(lanes);
    const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
    return stretched_density(zone_area(quadric), quadric.affine(&QuadricRecord::render_from_object), from,
                             normalize(transform_point(from, point)));
  }
  void describe(const ShapeTable& shapes, const ShapeRecord& shape, LightRecord& light) const override {
    const QuadricRecord& q = quadric_of(shapes, shape);
    light.area = static_cast<float>(sphere_area(q));
    const auto& m = q.render_from_object.m;
    light.position[0] = m[3];
    light.position[1] = m[7];
    light.position[2] = m[11];
    light.radius = q.partial ? 0.0f : static_cast<float>(q.radius * similarity_scale(q.render_from_object));
  }
  void bound(const LightTable& table, const LightRecord& light, LightBounds& b) const override {
    const QuadricRecord& q = quadric_of(table, light);
    bound_quadric(q, q.z_min, q.z_max, b);
    b.angle = std::numbers::pi;
  }
};

}  // namespace

const ModelOf<SphereLight> sphere(LightKind::kSphere);

}  // namespace tessera::render::TESSERA_ISA
