// A shape that comes from outside, as CONTRIBUTING tells how to add one.
#include <gtest/gtest.h>

#include <cmath>

#include "render/core/affine.h"
#include "render/shape/analytic_shape.h"
#include "render/shape/error_bound.h"
#include "render/transport/path/wavefront.h"
#include "support/kernel/kernel_scene.h"

namespace tessera::render::TESSERA_ISA {
namespace {

const QuadricRecord& record_of(const ShapeTable& table, const ShapeRecord& shape) {
  return table.quadrics[static_cast<std::size_t>(shape.quadric)];
}

/// The cube about the origin of object space that reaches as far as the record's radius.
class CubeShape final : public AnalyticShape {
 public:
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    const QuadricRecord& q = record_of(table, shape);
    return placed_bounds(q.render_from_object, {0, 0, 0}, {q.radius, q.radius, q.radius});
  }
  Float nearest(const ShapeTable& table, const ShapeRecord& shape, std::int32_t,
                const ShapeRays& rays) const override {
    const QuadricRecord& q = record_of(table, shape);
    const Vec3 o = transform_point(q.object_from_render, rays.o),
               d = transform_vector(q.object_from_render, rays.d);
    Float enter(-INFINITY), leave(INFINITY);
    for (const auto& [from, along] : {std::pair(o.x, d.x), std::pair(o.y, d.y), std::pair(o.z, d.z)}) {
      const Float inverse = 1.0f / select(along == 0.0f, Float(1e-30f), along);
      const Float t0 = (-q.radius - from) * inverse, t1 = (q.radius - from) * inverse;
      enter = max(enter, min(t0, t1)), leave = min(leave, max(t0, t1));
    }
    const Float t = select(enter > rays.t_near, enter, leave);
    return select(rays.active & (enter <= leave) & (t > rays.t_near) & (t < rays.t_far), t, -1.0f);
  }
  void surface(const ShapeTable& table, const ShapeRecord& shape, const Hit& hit, Vec3 o, Vec3 d, Mask active,
               bool, Surface& s) const override {
    const QuadricRecord& q = record_of(table, shape);
    const Vec3 p = transform_point(q.object_from_render, fma(d, hit.t, o)), size = abs(p);
    const Mask x = (size.x >= size.y) & (size.x >= size.z), y = and_not(size.y >= size.z, x);
    const Float zero(0.0f), one(1.0f);
    Vec3 n = select(x, Vec3{copysign(one, p.x), zero, zero},
                    select(y, Vec3{zero, copysign(one, p.y), zero}, Vec3{zero, zero, copysign(one, p.z)}));
    const Vec3 at = transform_point(q.render_from_object, p * (q.radius / max(max(size.x, size.y), size.z)));
    n = normalize(transform_normal(q.object_from_render, n));
    s.p = select(active, at, s.p);
    s.ng = select(active, n, s.ng);
    s.ns = select(active, n, s.ns);
    s.error =
        select(active, along_normal(n, (largest_coordinate(at) + q.radius) * (4 * kPositionError)), s.error);
  }
};

TEST(ToyShape, ACubeInAnEvenSkyCoversItsSquare) {
  static const CubeShape model;
  const ShapeKind kind = add_analytic_shape(model);
  EXPECT_GE(kind, ShapeKind::kCount);
  const auto content = build_kernel_scene(R"(
      camera { orthographic {} world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } }
      film { width: 32 height: 32 }
      materials { name: 'paint' diffuse { reflectance { constant { rgb { r: 0.5 g: 0.5 b: 0.5 } } } } }
      shapes { sphere { radius: 0.25 } material: 'paint' }
      lights { infinite { radiance { rgb { r: 1 g: 1 b: 1 } } } })",
                                          32, [&](SceneArrays& arrays) {
                                            // A function of its own in shape/quadrics.cpp would set this. The
                                            // cube reaches further than the sphere: its own bounds count.
                                            arrays.shapes.shapes[0].kind = kind;
                                            arrays.shapes.quadrics[0].radius = 0.5f;
                                          });
  ASSERT_NE(content, nullptr);
  constexpr std::uint32_t kSamplesOfCube = 16;
  const wire::TileResult picture = render_tile<Wavefront>(*content, kSamplesOfCube);
  const MeanRadiance mean(picture, kSamplesOfCube);
  // The film is 2 x 2 and the cube covers its pixels 8 to 23; convex, it lights nothing of itself. Rays that
  // leave a face must not meet it again: each of its pixels is 0.5, and the others are the sky.
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    const std::size_t x = i % 32, y = i / 32;
    const bool covered = x >= 8 && x < 24 && y >= 8 && y < 24;
    ASSERT_NEAR(mean.of_pixel(0, i), covered ? 0.5 : 1.0, 1e-5) << x << " " << y;
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
