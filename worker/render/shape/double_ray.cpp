#include "render/shape/double_ray.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// value + rest, of lanes from `first` on.
Double lanes_of(Float value, Float rest, int first) {
  alignas(64) float a[kWidth], b[kWidth];
  value.store(a);
  rest.store(b);
  Double sum;
  for (int i = 0; i < kDoubleWidth; ++i)
    sum[i] = static_cast<double>(a[first + i]) + static_cast<double>(b[first + i]);
  return sum;
}

}  // namespace

DoubleRay::DoubleRay(const ObjectRays& rays, int first)
    : o{lanes_of(rays.o.x, rays.o_rest.x, first), lanes_of(rays.o.y, rays.o_rest.y, first),
        lanes_of(rays.o.z, rays.o_rest.z, first)},
      d{lanes_of(rays.d.x, rays.d_rest.x, first), lanes_of(rays.d.y, rays.d_rest.y, first),
        lanes_of(rays.d.z, rays.d_rest.z, first)},
      t{} {
  begin_nearest_to_origin();
}

DoubleRay::DoubleRay(const double (&map)[12], const DoubleRay& ray) : o{}, d{}, t{} {
  for (int i = 0; i < 3; ++i) {
    const double* const row = map + 4 * i;
    o[i] = ray.o[0] * row[0] + ray.o[1] * row[1] + ray.o[2] * row[2] + row[3];
    d[i] = ray.d[0] * row[0] + ray.d[1] * row[1] + ray.d[2] * row[2];
  }
  begin_nearest_to_origin();
}

void DoubleRay::begin_nearest_to_origin() {
  const Double od = o[0] * d[0] + o[1] * d[1] + o[2] * d[2], dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  t = -od / dd;
  for (int i = 0; i < 3; ++i) o[i] = at(i, t);
}

DoubleRay::DoubleRay(const ExactObjectRay& ray)
    : o{splat(ray.o[0]), splat(ray.o[1]), splat(ray.o[2])},
      d{splat(ray.d[0]), splat(ray.d[1]), splat(ray.d[2])},
      t(splat(ray.shift)) {}

void CrossedShape::crossings(const ShapeTable& table, const ShapeRecord& shape, std::int32_t,
                             const ExactRay& ray, std::vector<double>& found) const {
  const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(shape.quadric)];
  const DoubleRay in_object(ExactObjectRay(q.object_from_render, ray));
  Crossings all;
  const int count = cross(table, q, in_object, all);
  for (int k = 0; k < count; ++k) {
    const double s = all.s[k][0];
    if (s > -kNoRoot && s < kNoRoot) found.push_back(in_object.t[0] + s);
  }
}

Float CrossedShape::nearest_in_object(const ShapeTable& table, const QuadricRecord& q,
                                      const ObjectRays& rays) const {
  alignas(64) float roots[kMostCrossings][kWidth];
  const std::uint32_t wanted = rays.active.bits();
  int count = 0;
  for (int first = 0; first < kWidth; first += kDoubleWidth) {
    constexpr std::uint32_t kLanes = (1u << kDoubleWidth) - 1;
    if ((wanted >> first & kLanes) == 0 && first + kDoubleWidth < kWidth) continue;
    const DoubleRay ray(rays, first);
    Crossings found;
    count = cross(table, q, ray, found);
    for (int k = 0; k < count; ++k) {
      for (int i = 0; i < kDoubleWidth; ++i)
        roots[k][first + i] = static_cast<float>(ray.t[i] + found.s[k][i]);
    }
  }
  Float nearest(__builtin_inff());
  for (int k = 0; k < count; ++k) {
    const Float root = Float::load(roots[k]);
    nearest = select((root > rays.t_near) & (root < nearest), root, nearest);
  }
  return select(rays.active & (nearest < rays.t_far), nearest, -1.0f);
}

int CrossedShape::spans(const ShapeTable& table, const ShapeRecord& shape, const DoubleRay& ray,
                        SolidSpans& found) const {
  Crossings crossings;
  const int count = cross(table, table.quadrics[static_cast<std::size_t>(shape.quadric)], ray, crossings);
  Double enter = splat(kNoRoot), leave = splat(-kNoRoot);
  for (int k = 0; k < count; ++k) {
    const Double s = crossings.s[k];
    const DoubleMask there = s < kNoRoot;
    enter = there ? lower(s, enter) : enter;
    leave = there ? upper(s, leave) : leave;
  }
  found.enter[0] = enter, found.leave[0] = leave;
  return 1;
}

void set_box_parameters(Vec3 n, ObjectPoint& point) {
  const Float n_axis[3] = {n.x, n.y, n.z}, p_axis[3] = {point.p.x, point.p.y, point.p.z};
  const Float size[3] = {abs(n.x), abs(n.y), abs(n.z)};
  const Mask x = (size[0] >= size[1]) & (size[0] >= size[2]);
  const Mask y = and_not(size[1] >= size[2], x);
  const auto of_axis = [&](const Float(&a)[3], int shift) {
    return select(x, a[shift % 3], select(y, a[(1 + shift) % 3], a[(2 + shift) % 3]));
  };
  const Float along = of_axis(n_axis, 0), a = of_axis(p_axis, 1), b = of_axis(p_axis, 2);
  const Float turn = copysign(Float(1.0f), along);
  point.uv = {fma(a * turn, 0.5f, 0.5f), fma(b, Float(0.5f), Float(0.5f))};
  // The point stays in the face while a or b changes: its third coordinate follows.
  const Float inverse = -1.0f / along, by_a = of_axis(n_axis, 1) * inverse,
              by_b = of_axis(n_axis, 2) * inverse;
  const auto tangent = [&](Float da, Float db, Float follows) {
    // Coordinates in the order along, a, b, back into x, y, z.
    return Vec3{select(x, follows, select(y, db, da)), select(x, da, select(y, follows, db)),
                select(x, db, select(y, da, follows))};
  };
  const Float zero(0.0f);
  point.dpdu = tangent(Float(2.0f), zero, by_a * 2.0f) * turn;
  point.dpdv = tangent(zero, Float(2.0f), by_b * 2.0f);
}

}  // namespace tessera::render::TESSERA_ISA
