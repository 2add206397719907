#include <cmath>

#include "render/shape/quadric.h"
#include "render/shape/round_form.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr RoundForm kForm{.is_solid = [](const QuadricRecord&) { return false; },
                          .contains = nullptr,
                          .support =
                              [](const QuadricRecord& q, const double (&a)[3]) {
                                return double{q.radius} * std::hypot(a[0], a[1]) + double{q.height} * a[2];
                              },
                          .profile = [](const QuadricRecord& q) -> std::vector<ProfilePiece> {
                            return {{.ax = q.inner_radius, .az = q.height, .bx = q.radius, .bz = q.height}};
                          }};

/// A disk or ring in z = height, perhaps a sector of it.
class DiskShape final : public QuadricShape {
 public:
  const RoundForm* round_form() const override { return &kForm; }
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(shape.quadric)];
    return placed_bounds(q.render_from_object, {0, 0, q.height}, {q.radius, q.radius, 0.0f});
  }
  void crossings(const ShapeTable& table, const ShapeRecord& shape, std::int32_t, const ExactRay& ray,
                 std::vector<double>& found) const override {
    const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(shape.quadric)];
    const ExactObjectRay r(q.object_from_render, ray);
    if (r.d[2] == 0) return;
    const double s = (double{q.height} - r.o[2]) / r.d[2], x = r.at(0, s), y = r.at(1, s);
    const double r2 = x * x + y * y;
    if (r2 <= double{q.radius} * q.radius && r2 >= double{q.inner_radius} * q.inner_radius &&
        (!q.partial || azimuth(x, y) <= double{q.phi_max}))
      found.push_back(r.shift + s);
  }

 protected:
  Float nearest_in_object(const ShapeTable&, const QuadricRecord& q, const ObjectRays& r) const override {
    const Mask slanted = r.active & (r.d.z != 0.0f);
    const Float inv_z = 1.0f / select(slanted, r.d.z, 1.0f);
    const Float t = (q.height - r.o.z) * inv_z;
    const Vec3 near_it = r.at(t);
    const Float rest = (q.height - near_it.z) * inv_z;
    const Vec3 p = near_it + r.d * rest;
    const Float root = t + rest, r2 = sqr(p.x) + sqr(p.y);
    const Mask hit = slanted & (root > r.t_near) & (root < r.t_far) & (r2 <= q.radius * q.radius) &
                     (r2 >= q.inner_radius * q.inner_radius) &
                     (q.partial ? azimuth(p) <= q.phi_max : Mask::all());
    return select(hit, root, -1.0f);
  }
  ObjectPoint point_in_object(const ShapeTable&, const QuadricRecord& q, Vec3 p) const override {
    ObjectPoint o;
    o.p = {p.x, p.y, Float(q.height)};
    const Float phi = azimuth(p);
    const Float r = sqrt(sqr(p.x) + sqr(p.y));
    o.uv = {phi * (1 / q.phi_max), (q.radius - r) * (1 / (q.radius - q.inner_radius))};
    const Float inv = 1.0f / max(r, 1e-30f);
    o.dpdu = {p.y * -q.phi_max, p.x * q.phi_max, Float(0.0f)};
    o.dpdv = Vec3{p.x * inv, p.y * inv, Float(0.0f)} * Float(q.inner_radius - q.radius);
    o.n = {Float(0.0f), Float(0.0f), Float(1.0f)};
    o.extent = q.radius;
    return o;
  }
};

}  // namespace

const ModelOf<DiskShape> disk(ShapeKind::kDisk);

}  // namespace tessera::render::TESSERA_ISA
