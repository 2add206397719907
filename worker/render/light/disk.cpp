#include "render/light/light_access.h"
#include "render/light/models.h"
#include "render/light/quadric_access.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A disk, ring or sector, sampled uniformly by area. An affine map keeps a uniform density of a plane figure uniform,
/// so any transform will do.
class DiskLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, Vec3 reference, Vec2 u, Mask active) const override {
    const LightLanes lanes{table, light, active};
    const QuadricLanes quadric(lanes);
    const Float radius = quadric.field(&QuadricRecord::radius), inner = quadric.field(&QuadricRecord::inner_radius);

    // The unit disk, drawn out to the ring between the radii and squeezed into the sector; both keep ratios of areas.
    const Polar unit = square_to_disk_polar(u);
    const Float r = sqrt(lerp(sqr(unit.radius), sqr(inner), sqr(radius)));
    const Float turn = select(unit.angle < 0.0f, unit.angle + 2.0f * kPi, unit.angle);
    const Float phi = turn * (quadric.field(&QuadricRecord::phi_max) * kInv2Pi);
    const Vec3 in_object = {r * cos(phi), r * sin(phi), quadric.field(&QuadricRecord::height)};

    const WideAffine render_from_object = quadric.affine(&QuadricRecord::render_from_object);
    const WideAffine object_from_render = quadric.affine(&QuadricRecord::object_from_render);
    const Vec3 point = transform_point(render_from_object, in_object);
    const Vec3 normal = normalize(transform_normal(object_from_render, {0.0f, 0.0f, 1.0f}));
    const Float extent = max_abs(transform_vector(render_from_object, {radius, radius, 0.0f}));
    return sample_from_point(lanes, reference, point, quadric.front(normal), 1.0f / lanes.field(&LightRecord::area),
                             extent);
  }

  Float pdf(const LightTable& table, Int light, Vec3 reference, Vec3 wi, Vec3 point, Vec3 normal,
            Mask active) const override {
    const LightLanes lanes{table, light, active};
    return pdf_from_point(lanes, reference, wi, point, normal, 1.0f / lanes.field(&LightRecord::area));
  }
};

}  // namespace

const LightModel& disk_light() {
  static const DiskLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
