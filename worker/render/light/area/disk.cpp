#include <algorithm>
#include <cmath>

#include "render/core/constants.h"
#include "render/light/area/quadric_access.h"
#include "render/light/light.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {
namespace {

double disk_area(const QuadricRecord& q) {
  const double in_object =
      0.5 * q.phi_max * (double{q.radius} * q.radius - double{q.inner_radius} * q.inner_radius);
  return in_object * length(cross(column(q.render_from_object, 0), column(q.render_from_object, 1)));
}

/// A disk, ring or sector, sampled uniformly by area: an affine map keeps a uniform density of a plane figure
/// uniform, so any transform will do.
class DiskLight final : public AreaLight {
 public:
  DiskLight() : AreaLight({.surface = ShapeKind::kDisk}) {}

 protected:
  AreaPoint sample_point(const LightLanes& lanes, Vec2 u) const override {
    const QuadricLanes quadric(lanes);
    const Float radius = quadric.field(&QuadricRecord::radius),
                inner = quadric.field(&QuadricRecord::inner_radius);
    // The unit disk, drawn out to the ring between the radii and squeezed into the sector; both keep ratios
    // of areas.
    const Polar unit = square_to_disk_polar(u);
    const Float r = sqrt(lerp(sqr(unit.radius), sqr(inner), sqr(radius)));
    const Float turn = select(unit.angle < 0.0f, unit.angle + 2.0f * kPi, unit.angle);
    const Float phi = turn * (quadric.field(&QuadricRecord::phi_max) * kInv2Pi);
    const WideAffine to = quadric.affine(&QuadricRecord::render_from_object);
    const WideAffine from = quadric.affine(&QuadricRecord::object_from_render);
    return {transform_point(to, {r * cos(phi), r * sin(phi), quadric.field(&QuadricRecord::height)}),
            quadric.front(normalize(transform_normal(from, {0.0f, 0.0f, 1.0f}))),
            1.0f / lanes.field(&LightRecord::area), max_abs(transform_vector(to, {radius, radius, 0.0f}))};
  }
  void describe(const ShapeTable& shapes, const ShapeRecord& shape, LightRecord& light) const override {
    light.area = static_cast<float>(disk_area(quadric_of(shapes, shape)));
  }
  void bound(const LightTable& table, const LightRecord& light, LightBounds& b) const override {
    const QuadricRecord& q = quadric_of(table, light);
    bound_quadric(q, q.height, q.height, b);
    // Normals are mapped by the inverse transpose: the cross product of what two tangents become, up to its
    // sign.
    const auto& m = q.render_from_object.m;
    const vec64::Vec x = {m[0], m[4], m[8]}, y = {m[1], m[5], m[9]}, z = {m[2], m[6], m[10]};
    const bool flipped =
        (table.shapes->shapes[static_cast<std::size_t>(light.shape)].flags & kFlipNormal) != 0;
    b.axis = unit(cross(x, y));
    if ((dot(b.axis, z) < 0) != flipped) b.axis = b.axis * -1;
  }
};

}  // namespace

const ModelOf<DiskLight> disk(LightKind::kDisk);

}  // namespace tessera::render::TESSERA_ISA
