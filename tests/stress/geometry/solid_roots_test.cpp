// Roots of half-spaces, boxes, frusta, tori, polygons and polyhedra against arithmetic of 113 bits.
#include <string>
#include <vector>

#include "stress/geometry/quad_arithmetic.h"
#include "stress/geometry/unit_solid.h"

namespace tessera::render::TESSERA_ISA {
namespace solid_roots {

/// Rays are held to 48 bits in object space, and roots are found with 53: what those take off places there.
/// Object space is of size 1.
constexpr double kPlaceError = 0x1p-44;

/// The parameter of a crossing, and how far off it may be before it is rounded to a float.
struct Crossing {
  Quad t;
  double slack;
};

/// A ray in object space, with the error of places along it.
struct Line {
  QuadPoint o, d;
  double off;

  Line(const QuadricRecord& q, Point origin, Point direction)
      : o(placed(q.object_from_render, origin, 1)), d(placed(q.object_from_render, direction, 0)) {
    off = kPlaceError * (1 + magnitude(o.x) + magnitude(o.y) + magnitude(o.z));
  }
  double speed() const { return static_cast<double>(root(d.x * d.x + d.y * d.y + d.z * d.z)); }
  /// A crossing at which a function with this slope along the ray, in units of object space, is zero. The
  /// direction's own error grows with the way.
  Crossing crossing(Quad t, Quad slope) const {
    const double place = off + kPlaceError * magnitude(t) * speed();
    return {t, 4 * place / std::max(magnitude(slope), 1e-300)};
  }
};

/// Clears `certain` where x is next to a limit.
bool at_least(Quad x, Quad limit, double off, bool& certain) {
  certain = certain && magnitude(x - limit) > off;
  return x >= limit;
}

/// The first of some crossings in order, the place after which the ray begins.
Expected first_of(std::vector<Crossing> found, bool certain) {
  std::sort(found.begin(), found.end(), [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
  Expected e;
  e.certain = certain;
  for (const Crossing& c : found) {
    const double off = 2 * kUnit * magnitude(c.t) + c.slack;
    e.certain = e.certain && magnitude(c.t) > off;
    if (c.t <= 0) continue;
    e.hit = true, e.t = static_cast<double>(c.t), e.tolerance = off;
    break;
  }
  return e;
}

/// Between the planes that a ray enters by and those that it leaves by.
Expected convex(const Line& line, const std::vector<Facet>& planes) {
  const Quad far = 1e30;
  Quad enter = -far, leave = far;
  double enter_slack = 0, leave_slack = 0;
  Expected e;
  // Bounds of the bounds, which each may move within.
  Quad enter_low = -far, enter_high = -far, leave_low = far, leave_high = far;
  for (const Facet& f : planes) {
    const Quad x = f.normal[0], y = f.normal[1], z = f.normal[2];
    const Quad above = x * line.o.x + y * line.o.y + z * line.o.z - Quad(f.offset),
               slope = x * line.d.x + y * line.d.y + z * line.d.z;
    if (slope == 0) {
      e.certain = e.certain && magnitude(above) > line.off;
      if (above > 0) leave = leave_low = leave_high = -far;
      continue;
    }
    const Crossing c = line.crossing(-above / slope, slope);
    const Quad low = c.t - Quad(c.slack), high = c.t + Quad(c.slack);
    if (slope < 0) {
      if (c.t > enter) enter = c.t, enter_slack = c.slack;
      enter_low = std::max(enter_low, low), enter_high = std::max(enter_high, high);
    } else {
      if (c.t < leave) leave = c.t, leave_slack = c.slack;
      leave_low = std::min(leave_low, low), leave_high = std::min(leave_high, high);
    }
  }
  const bool surely_in = enter_high<leave_low, surely_out = enter_low> leave_high;
  const bool certain = e.certain && (surely_in || surely_out);
  if (enter > leave) {
    e.certain = certain;
    return e;
  }
  return first_of({{enter, enter_slack}, {leave, leave_slack}}, certain);
}

Expected half_space(const Line& line, const QuadricRecord& q) {
  if (line.d.z == 0) return {};
  const Crossing c = line.crossing(-line.o.z / line.d.z, line.d.z);
  const QuadPoint p = along(line.o, line.d, c.t);
  const double off = line.off + c.slack * line.speed();
  bool certain = true;
  const bool on =
      at_least(q.radius, magnitude(p.x), off, certain) & at_least(q.radius, magnitude(p.y), off, certain);
  return first_of(on ? std::vector<Crossing>{c} : std::vector<Crossing>{}, certain);
}

Expected polygon(const Line& line, const std::vector<Facet>& corners) {
  if (line.d.z == 0) return {};
  const Crossing c = line.crossing(-line.o.z / line.d.z, line.d.z);
  const QuadPoint p = along(line.o, line.d, c.t);
  const double off = line.off + c.slack * line.speed();
  bool certain = true;
  int winding = 0;  // crossings of the line along +y: the kernel's goes along +x
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    const Quad ax = corners[j].normal[0], ay = corners[j].normal[1], bx = corners[i].normal[0],
               by = corners[i].normal[1];
    const Quad ex = bx - ax, ey = by - ay, length = root(ex * ex + ey * ey);
    const Quad side = (ex * (p.y - ay) - ey * (p.x - ax)) / length,
               at = (ex * (p.x - ax) + ey * (p.y - ay)) / length;
    // Next to the edge itself, and not to the line that it lies on.
    if (magnitude(side) <= off && at > -Quad(off) && at < length + Quad(off)) certain = false;
    if ((ax > p.x) != (bx > p.x)) winding += (ay + (p.x - ax) / ex * ey) > p.y;
  }
  if (winding % 2 == 0) {
    Expected e;
    e.certain = certain;
    return e;
  }
  return first_of({c}, certain);
}

Expected frustum(const Line& line, const QuadricRecord& q) {
  const Quad bottom = q.radius, top = q.top_radius, middle = (bottom + top) / 2, slope = (top - bottom) / 2;
  const QuadPoint &o = line.o, &d = line.d;
  bool certain = true;
  std::vector<Crossing> found;
  const auto in_sector = [&](const QuadPoint& p, double off) {
    if (!q.partial) return true;
    double phi = std::atan2(static_cast<double>(p.y), static_cast<double>(p.x));
    if (phi < 0) phi += 2 * M_PI;
    const double tell = 1e-14 + off / std::max(std::hypot(magnitude(p.x), magnitude(p.y)), 1e-30);
    const double cut = q.phi_max;
    certain = certain && std::abs(phi - cut) > tell && phi > tell && phi < 2 * M_PI - tell;
    return phi <= cut;
  };
  const Quad radius = middle + slope * o.z, grows = slope * d.z;
  const Quad a = d.x * d.x + d.y * d.y - grows * grows, b = o.x * d.x + o.y * d.y - radius * grows,
             c = o.x * o.x + o.y * o.y - radius * radius;
  const Quad discriminant = b * b - a * c;
  // The value of the quadric where the ray is closest to the axis, in squares of object space.
  if (a != 0) certain = magnitude(discriminant / a) > 16 * line.off;
  if (discriminant >= 0 && a != 0) {
    const Quad half = root(discriminant);
    for (const Quad t : {(-b - half) / a, (-b + half) / a}) {
      const QuadPoint p = along(o, d, t);
      const Crossing wall = line.crossing(t, half);
      const double off = line.off + wall.slack * line.speed();
      if (at_least(p.z, -1, off, certain) && at_least(1, p.z, off, certain) && in_sector(p, off))
        found.push_back(wall);
    }
  }
  if (q.capped && d.z != 0) {
    for (const int height : {-1, 1}) {
      const Crossing cap = line.crossing((height - o.z) / d.z, d.z);
      const QuadPoint p = along(o, d, cap.t);
      const double off = line.off + cap.slack * line.speed();
      const Quad rim = height < 0 ? bottom : top;
      if (at_least(rim, root(p.x * p.x + p.y * p.y), off, certain) && in_sector(p, off)) found.push_back(cap);
    }
  }
  return first_of(found, certain);
}

/// Coefficients from the constant on.
using Polynomial = std::vector<Quad>;
Quad value(const Polynomial& f, Quad s) {
  Quad sum = 0;
  for (std::size_t i = f.size(); i-- > 0;) sum = sum * s + f[i];
  return sum;
}
Polynomial derivative(const Polynomial& f) {
  Polynomial result;
  for (std::size_t i = 1; i < f.size(); ++i) result.push_back(f[i] * static_cast<double>(i));
  return result;
}

/// All roots in (low, high) by halving between those of the derivative, which go to `extrema`.
std::vector<Quad> roots_between(const Polynomial& f, Quad low, Quad high, std::vector<Quad>* extrema) {
  if (f.size() == 2) return f[1] == 0 ? std::vector<Quad>{} : std::vector<Quad>{-f[0] / f[1]};
  std::vector<Quad> ends = roots_between(derivative(f), low, high, nullptr);
  std::erase_if(ends, [&](Quad s) { return s <= low || s >= high; });
  if (extrema != nullptr) *extrema = ends;
  ends.insert(ends.begin(), low);
  ends.push_back(high);
  std::vector<Quad> roots;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    Quad a = ends[i], b = ends[i + 1];
    const bool below = value(f, a) < 0;
    if (below == (value(f, b) < 0)) continue;
    for (int k = 0; k < 90; ++k) {
      const Quad s = (a + b) / 2;
      ((value(f, s) < 0) == below ? a : b) = s;
    }
    roots.push_back((a + b) / 2);
  }
  return roots;
}

Expected torus(const Line& line, const QuadricRecord& q) {
  const Quad tube = q.inner_radius;
  // About the nearest point to the centre, in units of length.
  const QuadPoint& v = line.d;
  const Quad speed = root(v.x * v.x + v.y * v.y + v.z * v.z);
  const Quad t0 = -(line.o.x * v.x + line.o.y * v.y + line.o.z * v.z) / (speed * speed);
  const QuadPoint o = along(line.o, v, t0), d{v.x / speed, v.y / speed, v.z / speed};
  const Quad m = o.x * o.x + o.y * o.y + o.z * o.z, n = o.x * d.x + o.y * d.y + o.z * d.z,
             g = m + 1 - tube * tube;
  const Polynomial f = {g * g - 4 * (o.x * o.x + o.y * o.y), 4 * n * g - 8 * (o.x * d.x + o.y * d.y),
                        4 * n * n + 2 * g - 4 * (d.x * d.x + d.y * d.y), 4 * n, 1};
  Expected e;
  const Quad reach = 1 + tube;
  if (m > reach * reach) {
    e.certain = static_cast<double>(m - reach * reach) > 16 * line.off;
    return e;
  }
  std::vector<Quad> extrema;
  std::vector<Crossing> found;
  const Quad end = root(reach * reach - m) + Quad(1e-3);
  for (const Quad s : roots_between(f, -end, end, &extrema)) {
    const Quad slope = value(derivative(f), s) * speed;
    found.push_back({t0 + s / speed, 64 * line.off / std::max(magnitude(slope), 1e-300)});
  }
  bool certain = true;
  // Where two roots come or go.
  for (const Quad s : extrema) certain = certain && magnitude(value(f, s)) > 64 * line.off;
  return first_of(found, certain);
}

Expected expected(const UnitSolid& solid, const QuadricRecord& q, Point origin, Point direction) {
  const Line line(q, origin, direction);
  switch (solid.kind) {
    case ShapeKind::kHalfSpace:
      return half_space(line, q);
    case ShapeKind::kPolygon:
      return polygon(line, solid.facets);
    case ShapeKind::kFrustum:
      return frustum(line, q);
    case ShapeKind::kTorus:
      return torus(line, q);
    case ShapeKind::kPolyhedron:
      return convex(line, solid.facets);
    default: {
      std::vector<Facet> sides;
      for (int i = 0; i < 6; ++i) {
        Facet side{{0, 0, 0}, 1};
        side.normal[i / 2] = i % 2 ? 1 : -1;
        sides.push_back(side);
      }
      return convex(line, sides);
    }
  }
}

/// A point of the surface with its normal, in object space.
struct SurfacePoint {
  Point p, n;
};
SurfacePoint point_on(const UnitSolid& solid, Numbers& random) {
  const double phi = 2 * M_PI * random(), theta = 2 * M_PI * random();
  const Point out{std::cos(phi), std::sin(phi), 0}, up{0, 0, 1};
  switch (solid.kind) {
    case ShapeKind::kHalfSpace:
    case ShapeKind::kPolygon:
      return {out * std::sqrt(random()), up};
    case ShapeKind::kFrustum: {
      const double z = 2 * random() - 1, slope = (double{solid.record.top_radius} - solid.record.radius) / 2,
                   middle = (double{solid.record.top_radius} + solid.record.radius) / 2;
      return {out * (middle + slope * z) + up * z, unit(out - up * slope)};
    }
    case ShapeKind::kTorus: {
      const Point n = out * std::cos(theta) + up * std::sin(theta);
      return {out + n * solid.record.inner_radius, n};
    }
    default: {
      const Point d = random.direction();
      double least = 1e30;
      Point n = up;
      const auto consider = [&](Point normal, double offset) {
        const double s = offset / dot(normal, d);
        if (s > 0 && s < least) least = s, n = normal;
      };
      for (const Facet& f : solid.facets) consider({f.normal[0], f.normal[1], f.normal[2]}, f.offset);
      for (int i = 0; solid.facets.empty() && i < 6; ++i) consider(along_axis(i), 1);
      return {d * least, n};
    }
  }
}

/// Turned, of `size`, at `at`.
struct Placement {
  Point axes[3], at;
  double size;

  Placement(double wanted_size, Point place) : at(place), size(wanted_size) {
    axes[0] = unit({0.6, 0.64, 0.48}), axes[1] = unit(cross({0.1, -0.2, 1}, axes[0]));
    axes[2] = cross(axes[0], axes[1]);
  }
  Point vector(Point p) const { return (axes[0] * p.x + axes[1] * p.y + axes[2] * p.z) * size; }
  Affine map(bool back) const {
    Affine a;
    for (int k = 0; k < 3; ++k) {
      const double v[3] = {axes[k].x, axes[k].y, axes[k].z}, shift[3] = {at.x, at.y, at.z};
      for (int i = 0; i < 3; ++i) {
        if (back) a.m[4 * k + i] = static_cast<float>(v[i] / size);
        if (!back) a.m[4 * i + k] = static_cast<float>(v[i] * size);
      }
      a.m[4 * k + 3] = static_cast<float>(back ? -dot(axes[k], at) / size : shift[k]);
    }
    return a;
  }
};

struct Tally {
  std::int64_t rays = 0, hits = 0, uncertain = 0, wrong = 0, off = 0;
  double worst = 0;  // error over tolerance
};

/// Rays from `distance` away: through the solid for half of them; along its surface, off it by 10^-1 ..
/// 10^-7, for the others.
Tally compare(const UnitSolid& solid, double size, double distance, bool from_camera, std::int64_t rays) {
  const Placement place(size, from_camera ? unit({0.3, -0.7, 0.65}) * (distance * size) : Point{});
  const ShapeTable table = table_of(solid, place.map(false), place.map(true));
  const TracedTable traced(table, false);
  Numbers random(31);
  RayBatch batch;
  Tally tally;
  for (; tally.rays < rays; tally.rays += RayBatch::kSize) {
    for (int i = 0; i < RayBatch::kSize; ++i) {
      const SurfacePoint on = point_on(solid, random);
      const Point p = place.at + place.vector(i % 2 ? on.p : on.p * random());
      if (from_camera) {
        batch.aim(i, Point{}, p);
        continue;
      }
      const double lean = std::pow(10.0, -1 - 6 * random()) * (random() < 0.5 ? 1 : -1);
      const Point aside = random.direction(), flat = unit(aside - on.n * dot(aside, on.n)),
                  d = i % 2 ? flat + on.n * (lean * random()) : aside;
      const Point target = i % 2 ? p + place.vector(on.n) * lean : p;
      batch.aim(i, target - place.vector(d) * distance, target);
    }
    traced.nearest(batch);
    for (int i = 0; i < RayBatch::kSize; ++i) {
      const Expected e = expected(solid, table.quadrics[0], batch.origin(i), batch.direction(i));
      tally.hits += e.hit;
      tally.uncertain += !e.certain;
      if (!e.certain) continue;
      const bool hit = batch.shape[i] >= 0;
      tally.wrong += hit != e.hit;
      if (!hit || !e.hit) continue;
      const double error = std::abs(batch.t[i] - e.t) / e.tolerance;
      tally.off += error > 1;
      tally.worst = std::max(tally.worst, error);
    }
  }
  return tally;
}

class SolidRoots : public testing::TestWithParam<UnitSolid> {};

TEST_P(SolidRoots, AreThoseOfExactArithmetic) {
  for (const double size : {1e-6, 1.0, 1e9}) {
    for (const double distance : {0.3, 1.5, 1e3, 1e6}) {
      for (const bool from_camera : {true, false}) {
        // Halving in 113 bits takes its time.
        const bool slow = GetParam().kind == ShapeKind::kTorus;
        const std::int64_t rays = slow ? stress_count(1e3, 2e4) : stress_count(1e4, 1e5);
        const Tally tally = compare(GetParam(), size, distance, from_camera, rays);
        SCOPED_TRACE(testing::Message() << "size " << size << ", distance " << distance
                                        << (from_camera ? ", from the camera: " : ": ") << tally.wrong
                                        << " wrong of " << tally.rays << ", " << tally.off << " off, worst "
                                        << tally.worst << ", " << tally.uncertain << " uncertain");
        EXPECT_EQ(tally.wrong, 0);
        EXPECT_EQ(tally.off, 0);
        // A direction's own rounding takes rays from a million sizes away off a thin tube.
        EXPECT_GT(tally.hits, distance < 1e6 ? tally.rays / 20 : 0);
        EXPECT_LT(tally.uncertain, tally.rays / 10);
      }
    }
  }
}

std::string title_of(const testing::TestParamInfo<UnitSolid>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(All, SolidRoots, testing::ValuesIn(unit_solids()), title_of);

}  // namespace solid_roots
}  // namespace tessera::render::TESSERA_ISA
