// Surfaces of moving instances: where they are at a ray's time, at what Embree says of rays that meet them.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "render/accel/embree/accelerator.h"
#include "render/accel/embree/trace.h"
#include "render/color/texture_table.h"
#include "render/core/motion.h"
#include "render/shape/surface.h"

#define TESSERA_STRING2(x) #x
#define TESSERA_STRING(x) TESSERA_STRING2(x)

namespace tessera::render::TESSERA_ISA {
namespace {

enum class Kind { kFloor, kSphere };

/// One shape in an object of its own: a square of side 2 `size`, or a sphere of radius `size`.
ShapeTable table_of(Kind kind, float size) {
  ShapeTable table;
  ShapeRecord& shape = table.shapes.emplace_back();
  if (kind == Kind::kFloor) {
    shape.triangle_count = 2, shape.vertex_count = 4;
    for (const auto& [x, y] : {std::pair{-size, -size}, {size, -size}, {size, size}, {-size, size}}) {
      Vertex& v = table.vertices.emplace_back();
      v.position[0] = x, v.position[1] = y;
    }
    table.triangles = {0, 1, 2, 0, 2, 3};
  } else {
    shape.kind = ShapeKind::kSphere;
    QuadricRecord& q = table.quadrics.emplace_back();
    q.radius = size, q.z_min = -size, q.z_max = size;
  }
  table.objects.push_back({0, 1});
  return table;
}

/// Stretched along x, tilted about x, turned about z by `angle`, and shifted.
Affine placed(double angle, double stretch, double x, double y, double z, double tilt = 0) {
  const double c = std::cos(angle), s = std::sin(angle), ct = std::cos(tilt), st = std::sin(tilt);
  Affine a;
  const double m[12] = {c * stretch, -s * ct, s * st, x, s * stretch, c * ct, -c * st, y, 0, st, ct, z};
  for (int i = 0; i < 12; ++i) a.m[i] = static_cast<float>(m[i]);
  return a;
}

Affine inverse_of(const Affine& a) {
  const WideAffine wide = inverse(broadcast(a));
  Affine r;
  for (int i = 0; i < 12; ++i) r.m[i] = wide.m[i].lane(0);
  return r;
}

void add_moving(ShapeTable& table, const std::vector<Affine>& steps) {
  table.instances.push_back(
      {steps.front(), inverse_of(steps.front()), 0, 0, static_cast<std::int32_t>(steps.size()) - 1});
  table.motion_steps = steps;
}

/// The instance of `moving` where it is at `time`, standing still.
ShapeTable frozen(const ShapeTable& moving, float time) {
  ShapeTable table = moving;
  const InstanceRecord& instance = moving.instances[0];
  const WideAffine at =
      affine_at(moving.motion_steps.data(), Int(0), Int(instance.segments), Float(time), Mask::all()).map;
  Affine a;
  for (int i = 0; i < 12; ++i) a.m[i] = at.m[i].lane(0);
  table.instances[0] = {a, inverse_of(a)};
  table.motion_steps.clear();
  return table;
}

struct TracedRay {
  alignas(64) float o[3][kWidth], d[3][kWidth], time[kWidth];
  alignas(64) float t[kWidth], u[kWidth], v[kWidth];
  alignas(64) std::int32_t primitive[kWidth], shape[kWidth], instance[kWidth];

  Vec3 origin() const { return {Float::load(o[0]), Float::load(o[1]), Float::load(o[2])}; }
  Vec3 direction() const { return {Float::load(d[0]), Float::load(d[1]), Float::load(d[2])}; }
  Hit hit() const {
    return {Float::load(t),   Float::load(u),      Float::load(v),   Int::load(primitive),
            Int::load(shape), Int::load(instance), Float::load(time)};
  }
  RayArrays rays() const { return {o[0], o[1], o[2], d[0], d[1], d[2], time}; }
  void aim(Vec3 from, Vec3 along) {
    from.x.store(o[0]), from.y.store(o[1]), from.z.store(o[2]);
    along.x.store(d[0]), along.y.store(d[1]), along.z.store(d[2]);
  }
};

std::unique_ptr<Accelerator> accelerate(const ShapeTable& table) {
  static const TextureTable textures;
  auto built =
      Accelerator::build(table, textures, embree_kernel().callbacks, {1, TESSERA_STRING(TESSERA_ISA), false});
  EXPECT_TRUE(built.ok()) << built.status();
  return built.ok() ? *std::move(built) : nullptr;
}

std::mt19937 engine(7);
Float uniform(float low, float high) {
  alignas(64) float lanes[kWidth];
  for (float& x : lanes) x = std::uniform_real_distribution<float>(low, high)(engine);
  return Float::load(lanes);
}

float largest(Float a, Mask active) { return reduce_max(select(active, a, 0.0f)); }

std::vector<Affine> turning(int segments, double tilt = 0) {
  std::vector<Affine> steps;
  for (int k = 0; k <= segments; ++k) {
    const double t = static_cast<double>(k) / segments;
    steps.push_back(placed(1.2 * t, 1 + t, -30 + 60 * t, 5 * t, 2 - 3 * t, tilt));
  }
  return steps;
}

class MovingSurface : public testing::TestWithParam<std::pair<Kind, int>> {};

TEST_P(MovingSurface, IsWhereItStandsAtThatTime) {
  ShapeTable moving = table_of(GetParam().first, 3);
  add_moving(moving, turning(GetParam().second));
  const auto accelerator = accelerate(moving);
  ASSERT_TRUE(accelerator);
  int met = 0;
  for (const float time : {0.0f, 0.1f, 0.5f, 0.77f, 1.0f}) {
    const ShapeTable still = frozen(moving, time);
    const auto still_accelerator = accelerate(still);
    for (int round = 0; round < 20; ++round) {
      TracedRay a;
      Float(time).store(a.time);
      const Affine& place = still.instances[0].render_from_instance;
      const Vec3 target{uniform(-3, 3) + place.m[3], uniform(-3, 3) + place.m[7], Float(place.m[11])};
      const Vec3 from{uniform(-40, 40), uniform(-40, 40), uniform(20, 40)};
      a.aim(from, normalize(target - from));
      TracedRay b = a;
      trace_nearest(accelerator->scene(), a.rays(), kWidth, Traversal::kIncoherent, 1,
                    {a.t, a.u, a.v, a.primitive, a.shape, a.instance});
      trace_nearest(still_accelerator->scene(), b.rays(), kWidth, Traversal::kIncoherent, 1,
                    {b.t, b.u, b.v, b.primitive, b.shape, b.instance});
      const Mask both = (Int::load(a.shape) >= 0) & (Int::load(b.shape) >= 0);
      // Rays that graze the rim may fall on either side of it.
      EXPECT_LE(count((Int::load(a.shape) >= 0) ^ (Int::load(b.shape) >= 0)), 1);
      met += count(both);
      const Surface s = surface_at(moving, a.hit(), a.origin(), a.direction(), both, true);
      const Surface r = surface_at(still, b.hit(), b.origin(), b.direction(), both, true);
      // Roundings of coordinates up to 70, over the cosine of the ray (above 0.3 for the floor).
      EXPECT_LT(largest(length(s.p - r.p), both), 1e-3f) << time;
      EXPECT_LT(largest(length(s.ng - r.ng), both), 1e-3f) << time;
      EXPECT_LT(largest(length(s.ns - r.ns), both), 1e-3f) << time;
      // At a sphere's poles dp/du is any direction.
      const Mask regular = GetParam().first == Kind::kSphere ? both & (abs(s.ng.z) < 0.999f) : both;
      EXPECT_LT(largest(length(s.dpdu - r.dpdu), regular), 0.02f) << time;
    }
  }
  EXPECT_GT(met, 500);
}

/// Rays that leave the surface must not meet it again. Times are in [early, late].
void expect_no_shadow_on_itself(const ShapeTable& table, float early, float late) {
  const auto accelerator = accelerate(table);
  ASSERT_TRUE(accelerator);
  int met = 0, blocked = 0;
  for (int round = 0; round < 2000; ++round) {
    TracedRay ray;
    uniform(early, late).store(ray.time);
    const Vec3 from{uniform(-40, 40), uniform(-40, 40), uniform(60, 90)};
    ray.aim(from, normalize(Vec3{uniform(-30, 30), uniform(-30, 30), Float(0.0f)} - from));
    trace_nearest(accelerator->scene(), ray.rays(), kWidth, Traversal::kIncoherent, 1,
                  {ray.t, ray.u, ray.v, ray.primitive, ray.shape, ray.instance});
    const Mask hit = Int::load(ray.shape) >= 0;
    const Surface s = surface_at(table, ray.hit(), ray.origin(), ray.direction(), hit, false);
    // Down to a grazing angle of a thousandth.
    const Frame frame = Frame::from_normal(face_forward(s.ng, -ray.direction()));
    const Float phi = uniform(0, 6.2831f), height = exp(uniform(-6.9f, 0.0f)),
                r = safe_sqrt(1.0f - sqr(height));
    const Vec3 w = frame.to_world({r * cos(phi), r * sin(phi), height});
    ray.aim(offset_origin(s, w), w);
    alignas(64) float distance[kWidth];
    Float(1e6f).store(distance);
    trace_shadow(accelerator->scene(), ray.rays(), kWidth, Traversal::kIncoherent, distance);
    met += count(hit);
    blocked += count(hit & (Float::load(distance) < 0.0f));
  }
  EXPECT_GT(met, 20000);
  EXPECT_EQ(blocked, 0);
}

TEST_P(MovingSurface, DoesNotShadowItself) {
  const auto [kind, segments] = GetParam();
  ShapeTable table = table_of(kind, 50);
  add_moving(table, turning(segments, 0.4));
  expect_no_shadow_on_itself(table, 0, 1);
}

TEST(MovingFloor, DoesNotShadowItselfWhileItPassesTheOrigin) {
  // Translations of thousands cancel: what they were rounded by does not.
  ShapeTable table = table_of(Kind::kFloor, 5000);
  add_moving(table, {placed(0.3, 1, 3000, -2000, 5000, 0.4), placed(0.4, 1.2, -3000, 2000, -5000, 0.4)});
  expect_no_shadow_on_itself(table, 0.498f, 0.502f);
}

std::string name_of(const testing::TestParamInfo<std::pair<Kind, int>>& instance) {
  const auto [kind, segments] = instance.param;
  return (kind == Kind::kFloor ? "floor_" : "sphere_") + std::to_string(segments);
}

INSTANTIATE_TEST_SUITE_P(Kinds, MovingSurface,
                         testing::Values(std::pair{Kind::kFloor, 1}, std::pair{Kind::kFloor, 100},
                                         std::pair{Kind::kSphere, 1}, std::pair{Kind::kSphere, 100}),
                         name_of);

TEST(Inverse, UndoesTheMap) {
  const Affine a = placed(0.7, 2, 3, -4, 5);
  const WideAffine to = broadcast(a), from = inverse(to);
  const Vec3 p{uniform(-10, 10), uniform(-10, 10), uniform(-10, 10)};
  // Roundings of coordinates up to 40.
  EXPECT_LT(reduce_max(length(transform_point(from, transform_point(to, p)) - p)), 4e-5f);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
