#include <algorithm>
#include <cmath>

#include "render/core/constants.h"
#include "render/light/area/quadric_access.h"
#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Area of a cylinder's wall under any affine map.
double cylinder_area(const QuadricRecord& q) {
  const vec64::Vec x = column(q.render_from_object, 0), y = column(q.render_from_object, 1),
                   z = column(q.render_from_object, 2);
  constexpr int kSteps = 1024;
  double around = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double phi = (i + 0.5) / kSteps * q.phi_max;
    vec64::Vec along;
    for (std::size_t c = 0; c < 3; ++c) along[c] = std::cos(phi) * y[c] - std::sin(phi) * x[c];
    around += length(cross(along, z));
  }
  return around / kSteps * q.phi_max * q.radius * (double{q.z_max} - q.z_min);
}

/// The wall of a cylinder, sampled uniformly in object space.
class CylinderLight final : public AreaLight {
 public:
  CylinderLight() : AreaLight({.surface = ShapeKind::kCylinder}) {}

 protected:
  AreaPoint sample_point(const LightLanes& lanes, Vec2 u) const override {
    const QuadricLanes quadric(lanes);
    const Float radius = quadric.field(&QuadricRecord::radius);
    const Float z_min = quadric.field(&QuadricRecord::z_min), z_max = quadric.field(&QuadricRecord::z_max);
    const Float phi = u.x * quadric.field(&QuadricRecord::phi_max);
    const Vec3 n{cos(phi), sin(phi), Float(0.0f)};
    const WideAffine to = quadric.affine(&QuadricRecord::render_from_object);
    const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
    return {transform_point(to, {n.x * radius, n.y * radius, lerp(u.y, z_min, z_max)}),
            quadric.front(normalize(transform_normal(from, n))),
            stretched_density(zone_area(quadric), to, from, n),
            max_abs(transform_vector(to, {radius, radius, max(abs(z_min), abs(z_max))}))};
  }
  Float density_at(const LightLanes& lanes, Vec3 point) const override {
    const QuadricLanes quadric(lanes);
    const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
    const Vec3 p = transform_point(from, point);
    return stretched_density(zone_area(quadric), quadric.affine(&QuadricRecord::render_from_object), from,
                             normalize(Vec3{p.x, p.y, Float(0.0f)}));
  }
  void describe(const ShapeTable& shapes, const ShapeRecord& shape, LightRecord& light) const override {
    light.area = static_cast<float>(cylinder_area(quadric_of(shapes, shape)));
  }
  void bound(const LightTable& table, const LightRecord& light, LightBounds& b) const override {
    const QuadricRecord& q = quadric_of(table, light);
    bound_quadric(q, q.z_min, q.z_max, b);
    b.angle = std::numbers::pi;
  }
};

}  // namespace

const ModelOf<CylinderLight> cylinder(LightKind::kCylinder);

}  // namespace tessera::render::TESSERA_ISA
