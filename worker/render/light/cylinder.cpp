#include "render/light/light_access.h"
#include "render/light/models.h"
#include "render/light/quadric_access.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Area of the surface element of a cylinder under its affine map, over that element in object space.
Float stretch(const WideAffine& render_from_object, const WideAffine& object_from_render, Vec3 n) {
  const auto& m = render_from_object.m;
  const Float determinant = dot(Vec3{m[0], m[1], m[2]}, cross({m[4], m[5], m[6]}, {m[8], m[9], m[10]}));
  return abs(determinant) * length(transform_normal(object_from_render, n));
}

/// The wall of a cylinder, sampled uniformly in object space.
class CylinderLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, Vec3 reference, Vec2 u, Mask active) const override {
    const LightLanes lanes{table, light, active};
    const QuadricLanes quadric(lanes);
    const Float radius = quadric.field(&QuadricRecord::radius);
    const Float z_min = quadric.field(&QuadricRecord::z_min), z_max = quadric.field(&QuadricRecord::z_max);
    const Float phi = u.x * quadric.field(&QuadricRecord::phi_max);
    const Vec3 n{cos(phi), sin(phi), Float(0.0f)};
    const Vec3 in_object{n.x * radius, n.y * radius, lerp(u.y, z_min, z_max)};
    const WideAffine to = quadric.affine(&QuadricRecord::render_from_object);
    const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
    const Float extent = max_abs(transform_vector(to, {radius, radius, max(abs(z_min), abs(z_max))}));
    return sample_from_point(lanes, reference, transform_point(to, in_object),
                             quadric.front(normalize(transform_normal(from, n))), density(quadric, to, from, n), extent);
  }

  Float pdf(const LightTable& table, Int light, Vec3 reference, Vec3 wi, Vec3 point, Vec3 normal,
            Mask active) const override {
    const LightLanes lanes{table, light, active};
    const QuadricLanes quadric(lanes);
    const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
    Vec3 n = transform_point(from, point);
    n.z = Float(0.0f);
    return pdf_from_point(lanes, reference, wi, point, normal,
                          density(quadric, quadric.affine(&QuadricRecord::render_from_object), from, normalize(n)));
  }

 private:
  static Float density(const QuadricLanes& quadric, const WideAffine& to, const WideAffine& from, Vec3 n) {
    const Float object_area = quadric.field(&QuadricRecord::radius) * quadric.field(&QuadricRecord::phi_max) *
                              (quadric.field(&QuadricRecord::z_max) - quadric.field(&QuadricRecord::z_min));
    return 1.0f / (object_area * stretch(to, from, n));
  }
};

}  // namespace

const LightModel& cylinder_light() {
  static const CylinderLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
