// Lights to test, each with an exact intersector of its own in double precision.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/light/environment.h"
#include "render/light/light.h"
#include "render/light/light_build.h"
#include "render/light/moving_lights.h"
#include "support/kernel/double_point.h"

namespace tessera::render::TESSERA_ISA {

using test::Point;
using test::unit;

inline Vec3 wide(Point p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}
/// A point a lane.
inline Vec3 wide_lanes(const std::array<Point, kWidth>& points) {
  alignas(64) float x[kWidth], y[kWidth], z[kWidth];
  for (std::size_t i = 0; i < kWidth; ++i) {
    x[i] = static_cast<float>(points[i].x);
    y[i] = static_cast<float>(points[i].y);
    z[i] = static_cast<float>(points[i].z);
  }
  return {Float::load(x), Float::load(y), Float::load(z)};
}
inline Point lane(Vec3 v, int i) { return {v.x.lane(i), v.y.lane(i), v.z.lane(i)}; }

/// Where a ray meets an emitter.
struct LampHit {
  double t;
  Point p, n;  // n is the front
};

/// One light, or a mesh's worth of them, in a table of its own.
struct Lamp {
  std::string name;
  std::unique_ptr<ShapeTable> shapes = std::make_unique<ShapeTable>();
  LightTable table;
  /// All hits in front of the origin; empty for environments.
  std::function<std::vector<LampHit>(Point origin, Point direction)> hits;
  Point centre;
  bool environment = false;
  float time = 0;  // when it is looked at

  Lamp() {
    table.shapes = shapes.get();
    table.sources = light_sources();
  }
};

inline constexpr std::array<float, 3> kLampRadiance = {2.0f, 3.0f, 4.0f};

/// A triangle mesh with the front where cross(p1 - p0, p2 - p0) points.
inline Lamp mesh_lamp(std::string name, const std::vector<Point>& vertices,
                      const std::vector<std::uint32_t>& indices, bool two_sided) {
  Lamp lamp;
  lamp.name = std::move(name);
  // A shape before it, so that first_vertex and first_triangle are not zero.
  lamp.shapes->vertices = {{{9, 9, 9}}, {{8, 8, 8}}, {{7, 9, 7}}};
  lamp.shapes->triangles = {0, 1, 2};
  ShapeRecord shape;
  shape.first_vertex = 3;
  shape.first_triangle = 1;
  shape.vertex_count = static_cast<std::int32_t>(vertices.size());
  shape.triangle_count = static_cast<std::int32_t>(indices.size() / 3);
  lamp.shapes->shapes = {ShapeRecord{}, shape};
  for (const Point& v : vertices) {
    lamp.shapes->vertices.push_back(
        {{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}});
    lamp.centre = lamp.centre + v * (1.0 / static_cast<double>(vertices.size()));
  }
  lamp.shapes->triangles.insert(lamp.shapes->triangles.end(), indices.begin(), indices.end());
  append_area_lights(*lamp.shapes, 1, kLampRadiance, two_sided, -1, lamp.table);
  lamp.hits = [vertices, indices](Point o, Point d) {
    std::vector<LampHit> hits;
    for (std::size_t i = 0; i < indices.size(); i += 3) {
      const Point p0 = vertices[indices[i]], e1 = vertices[indices[i + 1]] - p0,
                  e2 = vertices[indices[i + 2]] - p0;
      const Point n = cross(e1, e2);
      const double t = dot(p0 - o, n) / dot(d, n);
      const Point q = o + d * t - p0;
      const double b1 = dot(cross(q, e2), n) / dot(n, n), b2 = dot(cross(e1, q), n) / dot(n, n);
      if (t > 0 && b1 >= 0 && b2 >= 0 && b1 + b2 <= 1) hits.push_back({t, o + d * t, unit(n)});
    }
    return hits;
  };
  return lamp;
}

/// A 3x4 map and its inverse in double.
struct Map {
  std::array<double, 12> m;

  Point vector(Point v) const {
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
            m[8] * v.x + m[9] * v.y + m[10] * v.z};
  }
  Point point(Point p) const { return vector(p) + Point{m[3], m[7], m[11]}; }
  /// The transpose of the linear part.
  Point transposed(Point v) const {
    return {m[0] * v.x + m[4] * v.y + m[8] * v.z, m[1] * v.x + m[5] * v.y + m[9] * v.z,
            m[2] * v.x + m[6] * v.y + m[10] * v.z};
  }
  Map inverse() const {
    const Point a{m[0], m[4], m[8]}, b{m[1], m[5], m[9]}, c{m[2], m[6], m[10]}, t{m[3], m[7], m[11]};
    const double det = dot(a, cross(b, c));
    const Point r0 = cross(b, c) * (1 / det), r1 = cross(c, a) * (1 / det), r2 = cross(a, b) * (1 / det);
    return {{r0.x, r0.y, r0.z, -dot(r0, t), r1.x, r1.y, r1.z, -dot(r1, t), r2.x, r2.y, r2.z, -dot(r2, t)}};
  }
  Affine affine() const {
    Affine a;
    for (std::size_t i = 0; i < 12; ++i) a.m[i] = static_cast<float>(m[i]);
    return a;
  }
};

/// A rotation with a translation, and a scale an axis.
inline Map placed(Point at, Point scale = {1, 1, 1}) {
  const Point x = unit({0.6, 0.7, -0.4}), y = unit(cross({0.2, -0.3, 0.9}, x)), z = cross(x, y);
  return {{x.x * scale.x, y.x * scale.y, z.x * scale.z, at.x, x.y * scale.x, y.y * scale.y, z.y * scale.z,
           at.y, x.z * scale.x, y.z * scale.y, z.z * scale.z, at.z}};
}

inline Lamp quadric_lamp(std::string name, ShapeKind kind, QuadricRecord quadric,
                         const Map& render_from_object, bool flipped, bool two_sided) {
  Lamp lamp;
  lamp.name = std::move(name);
  const Map object_from_render = render_from_object.inverse();
  quadric.render_from_object = render_from_object.affine();
  quadric.object_from_render = object_from_render.affine();
  lamp.shapes->quadrics = {QuadricRecord{}, quadric};
  ShapeRecord shape;
  shape.kind = kind;
  shape.quadric = 1;
  shape.flags = flipped ? kFlipNormal : 0;
  lamp.shapes->shapes = {shape};
  lamp.centre = render_from_object.point({0, 0, kind == ShapeKind::kDisk ? quadric.height : 0});
  append_area_lights(*lamp.shapes, 0, kLampRadiance, two_sided, -1, lamp.table);
  lamp.hits = [=](Point o, Point d) {
    const Point oo = object_from_render.point(o), od = object_from_render.vector(d);
    std::vector<double> roots;
    if (kind == ShapeKind::kDisk) {
      roots = {(quadric.height - oo.z) / od.z};
    } else {
      // A cylinder is a sphere of the plane across its axis.
      const double along = kind == ShapeKind::kCylinder ? 0 : 1;
      const Point co{oo.x, oo.y, oo.z * along}, cd{od.x, od.y, od.z * along};
      const double a = dot(cd, cd), b = dot(co, cd),
                   c = dot(co, co) - double{quadric.radius} * quadric.radius;
      const double root = b * b - a * c;
      if (root >= 0) roots = {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a};
    }
    std::vector<LampHit> hits;
    for (const double t : roots) {
      const Point p = oo + od * t;
      double phi = std::atan2(p.y, p.x);
      if (phi < 0) phi += 2 * std::numbers::pi;
      const double r = std::hypot(p.x, p.y);
      const bool inside = kind == ShapeKind::kDisk ? r <= quadric.radius && r >= quadric.inner_radius
                                                   : p.z >= quadric.z_min && p.z <= quadric.z_max;
      if (!(t > 0) || !inside || phi > quadric.phi_max) continue;
      const Point in_object = kind == ShapeKind::kDisk       ? Point{0, 0, 1}
                              : kind == ShapeKind::kCylinder ? Point{p.x, p.y, 0}
                                                             : p;
      const Point n = unit(object_from_render.transposed(in_object));
      hits.push_back({t, o + d * t, flipped ? n * -1 : n});
    }
    return hits;
  };
  return lamp;
}

/// A light of a point that is a sphere, seen as its two walls.
inline Lamp soft_lamp(std::string name, LightKind kind, Point centre, float radius) {
  Lamp lamp;
  lamp.name = std::move(name);
  lamp.centre = centre;
  LightRecord& record = lamp.table.lights.emplace_back();
  record.kind = kind;
  record.radius = radius;
  std::copy(kLampRadiance.begin(), kLampRadiance.end(), record.radiance);
  const double p[] = {centre.x, centre.y, centre.z};
  for (std::size_t c = 0; c < 3; ++c) record.position[c] = static_cast<float>(p[c]);
  lamp.hits = [=](Point o, Point d) {
    const double middle = dot(centre - o, d) / dot(d, d);
    const double off = length(o + d * middle - centre), r = radius;
    std::vector<LampHit> hits;
    if (off > r) return hits;
    const double half = std::sqrt((r - off) * (r + off) / dot(d, d));
    for (const double t : {middle - half, middle + half}) {
      const Point at = o + d * t;
      if (t > 0) hits.push_back({t, at, unit(at - centre)});
    }
    return hits;
  };
  return lamp;
}

inline QuadricRecord sphere_record(float radius) {
  QuadricRecord q;
  q.radius = radius;
  q.z_min = -radius;
  q.z_max = radius;
  return q;
}

inline Lamp environment_lamp(std::string name, Environment environment) {
  Lamp lamp;
  lamp.name = std::move(name);
  lamp.environment = true;
  lamp.table.environments.push_back(std::move(environment));
  LightRecord record;
  record.kind = LightKind::kInfinite;
  record.environment = 0;
  std::copy(kLampRadiance.begin(), kLampRadiance.end(), record.radiance);
  lamp.table.lights = {record};
  lamp.table.infinite_lights = {0};
  return lamp;
}

/// Light through the parallelogram of `corner` and two sides only, to the side of their cross product.
inline Environment through_portal(Environment environment, Point corner, Point side_u, Point side_v) {
  std::size_t i = 0;
  for (const Point p : {corner, side_u, side_v}) {
    for (const double x : {p.x, p.y, p.z}) environment.portal[i++] = static_cast<float>(x);
  }
  environment.portal_area = static_cast<float>(length(cross(side_u, side_v)));
  return environment;
}

/// A lamp that moves from one place to another, in the spaces of which it stands as `lamp` does, as it is at
/// `time`.
inline Lamp moved(Lamp lamp, const Map& start, const Map& end, double time) {
  Map now;
  for (std::size_t i = 0; i < 12; ++i) now.m[i] = (1 - time) * start.m[i] + time * end.m[i];
  lamp.name += absl::StrCat(", moved, at ", time);
  lamp.time = static_cast<float>(time);
  lamp.centre = now.point(lamp.centre);
  const auto still_hits = lamp.hits;
  lamp.hits = [still_hits, now, back = now.inverse()](Point o, Point d) {
    std::vector<LampHit> hits = still_hits(back.point(o), back.vector(d));
    for (LampHit& hit : hits) hit.p = now.point(hit.p), hit.n = unit(back.transposed(hit.n));
    return hits;
  };
  lamp.shapes->motion_steps = {start.affine(), end.affine()};
  InstanceRecord& instance = lamp.shapes->instances.emplace_back();
  instance.render_from_instance = start.affine();
  instance.instance_from_render = start.inverse().affine();
  instance.segments = 1;
  auto moving = std::make_shared<MovingLights>();
  moving->steps = lamp.shapes->motion_steps;
  moving->motions = {LightMotion{.first_step = 0, .segments = 1, .instance = 0}};
  moving->motion_of_light.assign(lamp.table.lights.size(), 0);
  for (std::size_t i = 0; i < lamp.table.lights.size(); ++i) {
    LightRecord& light = lamp.table.lights[i];
    const LightTraits& traits = lamp.table.sources(light.kind).traits;
    moving->still.lights.push_back(light);
    light.profile = static_cast<std::int32_t>(i);
    light.environment = -1;
    light.kind = traits.at_infinity ? (traits.delta ? LightKind::kMovingDistant : LightKind::kMovingInfinite)
                 : !traits.delta    ? LightKind::kMovingSurface
                 : traits.extended  ? LightKind::kMovingSoft
                                    : LightKind::kMovingPoint;
  }
  moving->still.sources = lamp.table.sources;
  moving->still.shapes = lamp.table.shapes;
  moving->still.environments = std::move(lamp.table.environments);
  lamp.table.environments.clear();
  lamp.table.moving = moving;
  return lamp;
}

/// Random texels over four orders of magnitude, a quarter of them black.
inline TextureImage noise_image(std::int32_t width, std::int32_t height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  TextureImage image;
  image.width = width;
  image.height = height;
  for (std::int32_t i = 0; i < width * height; ++i) {
    const float brightness = uniform(random) < 0.25f ? 0.0f : std::pow(10.0f, 4 * uniform(random) - 2);
    for (int c = 0; c < 3; ++c) image.texels32.push_back(brightness * uniform(random));
    image.texels32.push_back(1);
  }
  return image;
}

/// Uniform numbers for 16 lanes.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  Vec2 next_2d() { return {next(), next()}; }
  Float next() {
    alignas(64) float lanes[kWidth];
    for (float& x : lanes) x = static_cast<float>(engine_() >> 8) * 0x1p-24f;
    return Float::load(lanes);
  }

 private:
  std::mt19937 engine_;
};

}  // namespace tessera::render::TESSERA_ISA
