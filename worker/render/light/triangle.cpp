#include "render/light/area_point.h"
#include "render/light/light_access.h"
#include "render/light/models.h"
#include "render/light/solid_angle_light.h"
#include "render/sampling/spherical_triangle.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A triangle light seen from a receiver.
struct View {
  Vec3 p0, e1, e2;
  SphericalTriangle seen;
  Mask by_angle;  // else by area
  Bilinear warp;  // the receiver's cosine over SphericalTriangle::sample's square

  View(const LightLanes& lanes, const Receiver& from)
      : p0(lanes.field3(&LightRecord::vertices, 0)),
        e1(lanes.field3(&LightRecord::vertices, 3) - p0),
        e2(lanes.field3(&LightRecord::vertices, 6) - p0),
        seen(p0 - from.p, e1, e2),
        by_angle(lanes.active & seen.precise()) {
    const Float at_corner1 = corner_weight(from, seen.to_corner1(), 1.0f);
    warp = {at_corner1, at_corner1, corner_weight(from, seen.to_corner0(), 1.0f),
            corner_weight(from, seen.to_corner2(), 1.0f)};
  }

  Float size() const { return max(max_abs(e1), max_abs(e2)); }

  /// Of a point of the triangle: the weights of corners 1 and 2.
  Vec2 barycentric(Vec3 point) const {
    const Float inverse = 1.0f / max(size(), 1e-30f);
    const Vec3 s1 = e1 * inverse, s2 = e2 * inverse, p = (point - p0) * inverse;
    const Vec3 n = cross(s1, s2);
    const Float scale = 1.0f / max(length_squared(n), 1e-37f);
    return {dot(cross(p, s2), n) * scale, dot(cross(s1, p), n) * scale};
  }
};

/// One triangle of an emitting mesh, sampled by the solid angle that it is seen under, times the cosine.
class TriangleLight final : public LightModel {
 public:
  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u, Mask active) const override {
    const LightLanes lanes{table, light, active};
    const View view(lanes, from);
    const Vec2 warped = view.warp.sample(u);
    const Barycentric even = square_to_triangle(u);
    const Vec2 by_angle = view.seen.sample(warped);
    const Vec2 b{select(view.by_angle, by_angle.x, even.b1), select(view.by_angle, by_angle.y, even.b2)};

    const Float size = view.size();
    LightSample s =
        sample_from_point(lanes, from.p, view.p0 + view.e1 * b.x + view.e2 * b.y,
                          triangle_normal(view.e1, view.e2, size), 1.0f / lanes.field(&LightRecord::area), size);
    s.barycentric = b;
    return with_density(s, view.by_angle, view.warp.density(warped) / view.seen.solid_angle());
  }

  Float pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point, Vec3 normal,
            Mask active) const override {
    const LightLanes lanes{table, light, active};
    const View view(lanes, from);
    const Float by_area = pdf_from_point(lanes, from.p, wi, point, normal, 1.0f / lanes.field(&LightRecord::area));
    const Vec2 u = view.seen.invert(view.barycentric(point));
    return select(view.by_angle & (by_area > 0.0f), view.warp.density(u) / view.seen.solid_angle(), by_area);
  }
};

}  // namespace

const LightModel& triangle_light() {
  static const TriangleLight model;
  return model;
}

}  // namespace tessera::render::TESSERA_ISA
