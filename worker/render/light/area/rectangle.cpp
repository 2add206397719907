#include "render/light/area/area_light.h"
#include "render/light/area/solid_angle_light.h"
#include "render/light/light.h"
#include "render/sampling/spherical_rectangle.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A rectangle is sampled by area below this solid angle, where its parametrisation by solid angle loses its
/// digits and the two are all but the same.
constexpr float kSmallestSolidAngle = 2e-3f;

/// A kRectangle's corner, the unit vectors along its sides and across, and the sides' lengths.
struct RectangleSides {
  Vec3 corner, x, y, normal;
  Float width, height;

  TESSERA_INLINE explicit RectangleSides(const LightLanes& lanes)
      : corner(lanes.field3(&LightRecord::vertices, 0)),
        x(lanes.field3(&LightRecord::vertices, 3)),
        y(lanes.field3(&LightRecord::vertices, 6)),
        normal(lanes.field3(&LightRecord::direction)),
        width(lanes.field(&LightRecord::tan_x)),
        height(lanes.field(&LightRecord::tan_y)) {}
};

/// The point of a rectangle at these parts of its sides.
TESSERA_INLINE AreaPoint rectangle_point(const LightLanes& lanes, const RectangleSides& r, Vec2 parts) {
  return {fma(r.y, parts.y * r.height, fma(r.x, parts.x * r.width, r.corner)), r.normal,
          1.0f / lanes.field(&LightRecord::area), max(r.width, r.height)};
}

/// A rectangular light seen from a receiver.
struct View {
  RectangleSides sides;
  SphericalRectangle seen;
  Mask by_angle;  // else by area
  Bilinear warp;  // the receiver's cosine

  View(const LightLanes& lanes, const Receiver& from)
      : sides(lanes),
        seen(sides.corner - from.p, sides.x, sides.y, sides.normal, sides.width, sides.height),
        by_angle(lanes.active & seen.precise() & (seen.solid_angle() > kSmallestSolidAngle)) {
    const Vec3 to = sides.corner - from.p, along_x = sides.x * sides.width, along_y = sides.y * sides.height;
    warp = {corner_weight(from, to, seen.inverse_distance(0)),
            corner_weight(from, to + along_x, seen.inverse_distance(1)),
            corner_weight(from, to + along_y, seen.inverse_distance(3)),
            corner_weight(from, to + along_x + along_y, seen.inverse_distance(2))};
  }

  /// Parts of the two sides at a point of the rectangle.
  Vec2 parts(Vec3 point) const {
    const Vec3 p = point - sides.corner;
    return {clamp(dot(p, sides.x) / sides.width, 0.0f, 1.0f),
            clamp(dot(p, sides.y) / sides.height, 0.0f, 1.0f)};
  }
};

/// Two triangles of an emitting mesh that make a rectangle, sampled by the solid angle that it is seen under,
/// times the cosine.
class RectangleLight final : public AreaLight {
 public:
  RectangleLight() : AreaLight({.uses_normals = true}) {}

  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    if (from.roughly) return AreaLight::sample(table, light, from, u, active);
    const LightLanes lanes{table, light, active};
    const View view(lanes, from);
    const Vec2 warped = view.warp.sample(u);
    const Vec2 by_angle = view.seen.sample(warped);
    const Vec2 parts{select(view.by_angle, by_angle.x, u.x), select(view.by_angle, by_angle.y, u.y)};

    const AreaPoint at = rectangle_point(lanes, view.sides, parts);
    const LightSample s = sample_from_point(lanes, from.p, at.point, at.normal, at.density, at.extent);
    return with_density(s, view.by_angle, view.warp.density(warped) / view.seen.solid_angle());
  }

  Float pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point, Vec3 normal,
            Mask active) const override {
    const Float by_area = AreaLight::pdf(table, light, from, wi, point, normal, active);
    if (from.roughly) return by_area;
    const View view({table, light, active}, from);
    const Vec2 u = view.seen.invert(view.parts(point));
    return select(view.by_angle & (by_area > 0.0f), view.warp.density(u) / view.seen.solid_angle(), by_area);
  }

 protected:
  AreaPoint sample_point(const LightLanes& lanes, Vec2 u) const override {
    return rectangle_point(lanes, RectangleSides(lanes), u);
  }
  void bound(const LightTable&, const LightRecord& light, LightBounds& b) const override {
    b.axis = unit(vec64::vec(light.direction));
    const vec64::Vec corner = vec64::vec(light.vertices), x = vec64::vec(light.vertices + 3) * light.tan_x,
                     y = vec64::vec(light.vertices + 6) * light.tan_y;
    for (const vec64::Vec& p : {corner, corner + x, corner + y, corner + x + y}) b.add(p);
  }
};

}  // namespace

const ModelOf<RectangleLight> rectangle(LightKind::kRectangle);

}  // namespace tessera::render::TESSERA_ISA
