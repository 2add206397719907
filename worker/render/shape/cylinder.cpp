#include "render/shape/quadric.h"
#include "render/shape/round_form.h"

#include <cmath>

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr RoundForm kForm{.is_solid = [](const QuadricRecord&) { return false; },
                          .contains = nullptr,
                          .support =
                              [](const QuadricRecord& q, const double (&a)[3]) {
                                return double{q.radius} * std::hypot(a[0], a[1]) +
                                       std::fmax(double{q.z_min} * a[2], double{q.z_max} * a[2]);
                              },
                          .profile = [](const QuadricRecord& q) -> std::vector<ProfilePiece> {
                            return {{.ax = q.radius, .az = q.z_min, .bx = q.radius, .bz = q.z_max}};
                          }};

/// The wall of a cylinder about the z axis, perhaps cut by an azimuth: met like a sphere, in the plane across
/// the axis.
class CylinderShape final : public QuadricShape {
 public:
  const RoundForm* round_form() const override { return &kForm; }
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(shape.quadric)];
    return placed_bounds(q.render_from_object, {0, 0, (q.z_min + q.z_max) / 2},
                         {q.radius, q.radius, (q.z_max - q.z_min) / 2});
  }
  void crossings(const ShapeTable& table, const ShapeRecord& shape, std::int32_t, const ExactRay& ray,
                 std::vector<double>& found) const override {
    const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(shape.quadric)];
    const ExactObjectRay r(q.object_from_render, ray);
    const double a = r.d[0] * r.d[0] + r.d[1] * r.d[1], middle = -(r.o[0] * r.d[0] + r.o[1] * r.d[1]) / a;
    const double x = r.at(0, middle), y = r.at(1, middle);
    const double discriminant = double{q.radius} * q.radius - (x * x + y * y);
    if (!(a > 0 && discriminant >= 0)) return;
    const double half_chord = std::sqrt(discriminant / a);
    for (const double s : {middle - half_chord, middle + half_chord}) {
      const double z = r.at(2, s);
      if (z >= double{q.z_min} && z <= double{q.z_max} &&
          (!q.partial || azimuth(r.at(0, s), r.at(1, s)) <= double{q.phi_max}))
        found.push_back(r.shift + s);
    }
  }

 protected:
  Float nearest_in_object(const ShapeTable&, const QuadricRecord& q, const ObjectRays& r) const override {
    const Float a = sqr(r.d.x) + sqr(r.d.y);
    const Mask slanted = r.active & (a > 0.0f);
    const Float inv_a = 1.0f / select(slanted, a, 1.0f);
    const Float t = -(r.o.x * r.d.x + r.o.y * r.d.y) * inv_a;
    const Vec3 near_it = r.at(t);
    const Float rest = -(near_it.x * r.d.x + near_it.y * r.d.y) * inv_a;
    const Vec3 nearest = near_it + r.d * rest;
    const Float discriminant = Float(sqr(Float(q.radius))) - (sqr(nearest.x) + sqr(nearest.y));
    const Mask meets = slanted & (discriminant >= 0.0f);
    if (none(meets)) return Float(-1.0f);
    return nearest_root(r, meets, t, rest, safe_sqrt(discriminant * inv_a), nearest, [&](Vec3 p) {
      return (p.z >= q.z_min) & (p.z <= q.z_max) & (q.partial ? azimuth(p) <= q.phi_max : Mask::all());
    });
  }
  ObjectPoint point_in_object(const ShapeTable&, const QuadricRecord& q, Vec3 p) const override {
    ObjectPoint o;
    const Float scale = q.radius / sqrt(sqr(p.x) + sqr(p.y));
    o.p = {p.x * scale, p.y * scale, p.z};
    const Float phi = azimuth(p);
    o.uv = {phi * (1 / q.phi_max), (p.z - q.z_min) * (1 / (q.z_max - q.z_min))};
    o.dpdu = {o.p.y * -q.phi_max, o.p.x * q.phi_max, Float(0.0f)};
    o.dpdv = {Float(0.0f), Float(0.0f), Float(q.z_max - q.z_min)};
    o.n = {o.p.x * (1 / q.radius), o.p.y * (1 / q.radius), Float(0.0f)};
    o.extent = Float(q.radius + std::fmax(std::fabs(q.z_min), std::fabs(q.z_max)));
    return o;
  }
};

}  // namespace

const ModelOf<CylinderShape> cylinder(ShapeKind::kCylinder);

}  // namespace tessera::render::TESSERA_ISA
