#include <cmath>

#include "render/shape/double_ray.h"
#include "render/shape/round_form.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr RoundForm kForm{
    .is_solid = [](const QuadricRecord& q) { return q.capped && !q.partial; },
    .contains =
        [](const QuadricRecord& q, const double (&p)[3]) {
          return std::abs(p[2]) < 1 &&
                 std::hypot(p[0], p[1]) <
                     (double{q.radius} + q.top_radius) / 2 + (double{q.top_radius} - q.radius) / 2 * p[2];
        },
    .support =
        [](const QuadricRecord& q, const double (&a)[3]) {
          const double across = std::hypot(a[0], a[1]);
          return std::fmax(double{q.radius} * across - a[2], double{q.top_radius} * across + a[2]);
        },
    .profile =
        [](const QuadricRecord& q) {
          const double bottom = q.radius, top = q.top_radius;
          std::vector<ProfilePiece> pieces{{.ax = bottom, .az = -1, .bx = top, .bz = 1}};
          if (q.capped) {
            pieces.push_back({.ax = 0, .az = -1, .bx = bottom, .bz = -1});
            pieces.push_back({.ax = 0, .az = 1, .bx = top, .bz = 1});
          }
          return pieces;
        }};

/// The wall of a frustum about the z axis between z = -1 and 1, perhaps with both disks that close it,
/// perhaps cut by an azimuth: a cone, or a cylinder with caps.
class FrustumShape final : public CrossedShape {
 public:
  const RoundForm* round_form() const override { return &kForm; }
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    return placed_bounds(table.quadrics[static_cast<std::size_t>(shape.quadric)].render_from_object,
                         {0, 0, 0}, {1, 1, 1});
  }

 protected:
  int cross(const ShapeTable&, const QuadricRecord& q, const DoubleRay& ray,
            Crossings& found) const override {
    const double bottom = q.radius, top = q.top_radius, middle = (bottom + top) / 2,
                 slope = (top - bottom) / 2;
    const double cosine = std::cos(static_cast<double>(q.phi_max)),
                 sine = std::sin(static_cast<double>(q.phi_max));
    const auto in_sector = [&](Double x, Double y) {
      if (q.phi_max >= 2 * kPi || !q.partial) return x == x;
      const DoubleMask from_start = y >= 0.0, before_end = x * sine - y * cosine >= 0.0;
      return q.phi_max <= kPi ? from_start & before_end : from_start | before_end;
    };
    // x^2 + y^2 = (middle + slope z)^2 along the ray: a s^2 + 2 b s + c = 0, by the root that does not
    // cancel.
    const Double radius = ray.o[2] * slope + middle, grows = ray.d[2] * slope;
    const Double a = ray.d[0] * ray.d[0] + ray.d[1] * ray.d[1] - grows * grows;
    const Double b = ray.o[0] * ray.d[0] + ray.o[1] * ray.d[1] - radius * grows;
    const Double c = ray.o[0] * ray.o[0] + ray.o[1] * ray.o[1] - radius * radius;
    const Double discriminant = b * b - a * c;
    const Double root = square_root(upper(discriminant, splat(0.0)));
    const Double sum = b < 0.0 ? root - b : -(root + b);
    found.s[0] = sum / a;
    found.s[1] = c / sum;
    for (int k = 0; k < 2; ++k) {
      const Double s = found.s[k], z = ray.at(2, s);
      const DoubleMask on =
          (discriminant >= 0.0) & (z >= -1.0) & (z <= 1.0) & in_sector(ray.at(0, s), ray.at(1, s));
      found.s[k] = on ? s : splat(kNoRoot);
    }
    if (!q.capped) return 2;
    for (int k = 0; k < 2; ++k) {
      const double height = k == 0 ? -1 : 1, rim = k == 0 ? bottom : top;
      const Double s = (height - ray.o[2]) / ray.d[2], x = ray.at(0, s), y = ray.at(1, s);
      const DoubleMask on = (ray.d[2] != 0.0) & (x * x + y * y <= rim * rim) & in_sector(x, y);
      found.s[2 + k] = on ? s : splat(kNoRoot);
    }
    return 4;
  }
  ObjectPoint point_in_object(const ShapeTable&, const QuadricRecord& q, Vec3 p) const override {
    const float middle = (q.radius + q.top_radius) / 2, slope = (q.top_radius - q.radius) / 2;
    const Float rho = max(sqrt(sqr(p.x) + sqr(p.y)), 1e-30f), inverse = 1.0f / rho;
    const Float x = p.x * inverse, y = p.y * inverse, z = clamp(p.z, -1.0f, 1.0f), zero(0.0f);
    const Float radius = fma(z, Float(slope), Float(middle));
    const Float phi = azimuth(p), side = copysign(Float(1.0f), p.z);
    ObjectPoint o;
    o.p = {x * radius, y * radius, z};
    o.n = {x, y, Float(-slope)};
    o.uv = {phi * (1 / q.phi_max), fma(z, Float(0.5f), Float(0.5f))};
    o.dpdu = {o.p.y * -q.phi_max, o.p.x * q.phi_max, zero};
    o.dpdv = {x * (2 * slope), y * (2 * slope), Float(2.0f)};
    // At the apex there is no way around; any will do.
    o.dpdu = select(radius > 0.0f, o.dpdu, Vec3{-y, x, zero});
    o.extent = Float(1.0f);
    if (q.capped) {
      // The caps where they are nearer than the wall.
      const float off_wall = 1 / std::sqrt(1 + slope * slope);
      const Mask cap = 1.0f - abs(p.z) < abs(rho - radius) * off_wall;
      const Float rim = select(p.z < 0.0f, Float(q.radius), Float(q.top_radius));
      o.p = select(cap, Vec3{p.x, p.y, side}, o.p);
      o.n = select(cap, Vec3{zero, zero, side}, o.n);
      o.uv.y = select(cap, (rim - rho) / max(rim, 1e-30f), o.uv.y);
      o.dpdu = select(cap, Vec3{p.y * -q.phi_max, p.x * q.phi_max, zero}, o.dpdu);
      o.dpdv = select(cap, Vec3{-x * rim, -y * rim, zero}, o.dpdv);
    }
    return o;
  }
};

}  // namespace

const ModelOf<FrustumShape> frustum(ShapeKind::kFrustum);

}  // namespace tessera::render::TESSERA_ISA
