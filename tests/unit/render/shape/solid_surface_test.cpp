// Surfaces of half-spaces, boxes, frusta, tori, polygons and polyhedra: parameters, tangents and normals.
#include <gtest/gtest.h>

#include <cmath>

#include "stress/geometry/unit_solid.h"

namespace tessera::render::TESSERA_ISA {
namespace solid_surface {

Point lane(Vec3 v, int i) { return {v.x.lane(i), v.y.lane(i), v.z.lane(i)}; }

/// Stretched, sheared and moved, mirrored or not.
Affine placement(bool mirrored) {
  Affine a;
  const double m[12] = {1.5, 0.2, 0, 1, 0.1, mirrored ? -0.7 : 0.7, 0.3, -2, 0, 0.25, 1.1, 3};
  for (int i = 0; i < 12; ++i) a.m[i] = static_cast<float>(m[i]);
  return a;
}
Point apply(const Affine& a, Point p) {
  const auto row = [&](int i) { return a.m[i] * p.x + a.m[i + 1] * p.y + a.m[i + 2] * p.z + a.m[i + 3]; };
  return {row(0), row(4), row(8)};
}
Affine inverse_of(const Affine& a) {
  const Point r0{a.m[0], a.m[1], a.m[2]}, r1{a.m[4], a.m[5], a.m[6]}, r2{a.m[8], a.m[9], a.m[10]};
  const Point c0 = cross(r1, r2), c1 = cross(r2, r0), c2 = cross(r0, r1);
  const double det = dot(r0, c0);
  const Point shift{a.m[3], a.m[7], a.m[11]};
  Affine b;
  const Point rows[3] = {{c0.x / det, c1.x / det, c2.x / det},
                         {c0.y / det, c1.y / det, c2.y / det},
                         {c0.z / det, c1.z / det, c2.z / det}};
  for (int i = 0; i < 3; ++i) {
    const Point r = rows[i];
    b.m[4 * i] = static_cast<float>(r.x), b.m[4 * i + 1] = static_cast<float>(r.y),
            b.m[4 * i + 2] = static_cast<float>(r.z), b.m[4 * i + 3] = static_cast<float>(-dot(r, shift));
  }
  return b;
}

/// Parameters by the words of shape.proto, in object space; `n` is the normal there.
struct Parameters {
  double u, v;
};
Parameters parameters_of(const UnitSolid& solid, Point p, Point n) {
  const double turn = 1 / (2 * M_PI), phi = std::atan2(p.y, p.x) + (p.y < 0 ? 2 * M_PI : 0);
  const QuadricRecord& q = solid.record;
  switch (solid.kind) {
    case ShapeKind::kHalfSpace:
    case ShapeKind::kPolygon:
      return {p.x, p.y};
    case ShapeKind::kTorus: {
      const double around = std::atan2(p.z, std::hypot(p.x, p.y) - 1);
      return {phi * turn, (around < 0 ? around + 2 * M_PI : around) * turn};
    }
    case ShapeKind::kFrustum: {
      const double rim = p.z < 0 ? q.radius : q.top_radius;
      const bool cap = q.capped && std::abs(n.z) > 0.999;
      return {phi / q.phi_max, cap ? 1 - std::hypot(p.x, p.y) / rim : (p.z + 1) / 2};
    }
    default: {
      const double c[3] = {p.x, p.y, p.z}, m[3] = {n.x, n.y, n.z};
      int axis = 0;
      for (int i = 1; i < 3; ++i) {
        if (std::abs(m[i]) > std::abs(m[axis])) axis = i;
      }
      const double a = c[(axis + 1) % 3], b = c[(axis + 2) % 3];
      return {(m[axis] < 0 ? 1 - a : 1 + a) / 2, (1 + b) / 2};
    }
  }
}

class SolidSurface : public testing::TestWithParam<UnitSolid> {};

TEST_P(SolidSurface, HasTheParametersTangentsAndNormalsOfItsFormula) {
  const UnitSolid& solid = GetParam();
  for (const bool mirrored : {false, true}) {
    const Affine to = placement(mirrored), from = inverse_of(to);
    ShapeTable table = table_of(solid, to, from);
    if (mirrored)
      table.shapes[0].flags |= kFlipNormal;  // the outside is kept by the mirror, and turned by this
    const TracedTable traced(table, false);
    Numbers random(41);
    RayBatch batch;
    int hits = 0;
    for (int k = 0; k < 40; ++k) {
      for (int i = 0; i < RayBatch::kSize; ++i)
        batch.aim(i, apply(to, random.direction() * 5), apply(to, random.direction() * 1.1));
      traced.nearest(batch);
      for (int i = 0; i < RayBatch::kSize; ++i) {
        if (batch.shape[i] < 0) continue;
        const Surface s = traced.surface(batch, i / kWidth * kWidth);
        const int at = i % kWidth;
        const Point p = apply(from, lane(s.p, at)), n_world = lane(s.ng, at);
        // Covectors go back by the transpose of the map there.
        const Point n = unit({to.m[0] * n_world.x + to.m[4] * n_world.y + to.m[8] * n_world.z,
                              to.m[1] * n_world.x + to.m[5] * n_world.y + to.m[9] * n_world.z,
                              to.m[2] * n_world.x + to.m[6] * n_world.y + to.m[10] * n_world.z}) *
                        (mirrored ? -1 : 1);
        if (std::hypot(p.x, p.y) < 0.02) continue;  // next to an axis or an apex
        ++hits;
        // On the ray where it was met, and on the surface.
        const Point on_ray = batch.origin(i) + batch.direction(i) * batch.t[i];
        ASSERT_LT(length(lane(s.p, at) - on_ray), 4e-6 * (4 + batch.t[i]));
        const Parameters expected = parameters_of(solid, p, n);
        const double du = std::abs(s.uv.x.lane(at) - expected.u);
        const bool angle = solid.kind == ShapeKind::kTorus || solid.kind == ShapeKind::kFrustum;
        ASSERT_LT(angle ? std::min(du, std::abs(1 - du)) : du, 5e-5 * (1 + length(p)))
            << p.x << ' ' << p.y << ' ' << p.z;
        const double dv = std::abs(s.uv.y.lane(at) - expected.v);
        ASSERT_LT(solid.kind == ShapeKind::kTorus ? std::min(dv, 1 - dv) : dv,
                  2e-6 / (solid.kind == ShapeKind::kTorus ? double{solid.record.inner_radius} : 1) +
                      2e-5 * (1 + length(p)));
        // Tangents lie in the surface, and a step along them changes only their own parameter.
        const Point dpdu = lane(s.dpdu, at), dpdv = lane(s.dpdv, at);
        ASSERT_LT(std::abs(dot(dpdu, n_world)), 1e-5 * length(dpdu));
        ASSERT_LT(std::abs(dot(dpdv, n_world)), 1e-5 * length(dpdv));
        constexpr double kStep = 1e-4;
        const auto stepped = [&](Point tangent) {
          return parameters_of(solid, apply(from, lane(s.p, at) + tangent * kStep), n);
        };
        const Parameters along_u = stepped(dpdu), along_v = stepped(dpdv);
        if (angle && (expected.u < 0.01 || expected.u > 0.99)) continue;
        if (solid.kind == ShapeKind::kTorus && (expected.v < 0.01 || expected.v > 0.99)) continue;
        // Float positions are off by 1e-6, and a tangent leaves a round surface by the square of the step.
        const double tube = solid.kind == ShapeKind::kTorus ? solid.record.inner_radius : 1;
        const double off = (0.1 + 2 * M_PI * kStep / tube) * kStep;
        ASSERT_NEAR(along_u.u - expected.u, kStep, off);
        ASSERT_NEAR(along_u.v - expected.v, 0, off);
        ASSERT_NEAR(along_v.u - expected.u, 0, off);
        ASSERT_NEAR(along_v.v - expected.v, kStep, off);
        // Closed solids are seen from outside.
        const bool closed =
            solid.kind != ShapeKind::kPolygon && solid.kind != ShapeKind::kHalfSpace && !solid.record.partial;
        if (closed) {
          ASSERT_LT(dot(n_world, batch.direction(i)) * (mirrored ? -1 : 1), 1e-3);
        }
      }
    }
    EXPECT_GT(hits, solid.kind == ShapeKind::kTorus && solid.record.inner_radius < 0.1 ? 10 : 500);
  }
}

std::string title_of(const testing::TestParamInfo<UnitSolid>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(All, SolidSurface, testing::ValuesIn(unit_solids()), title_of);

/// Half of the surface is there: of two crossings of a box, each is.
TEST(AlphaOfSolids, LetsThroughWhatItShould) {
  for (const UnitSolid& solid : unit_solids()) {
    if (solid.kind != ShapeKind::kBox && solid.kind != ShapeKind::kPolyhedron) continue;
    ShapeTable table = table_of(solid, Affine{}, Affine{});
    table.shapes[0].flags |= kHasAlpha;
    table.shapes[0].alpha = 0.5f;
    const TracedTable traced(table, false);
    Numbers random(42);
    RayBatch batch;
    double met = 0, front = 0, blocked = 0, rays = 0;
    for (int k = 0; k < 400; ++k) {
      for (int i = 0; i < RayBatch::kSize; ++i) {
        batch.aim(i, random.direction() * 5, random.direction() * 0.3);
        batch.distance[i] = 20;
      }
      traced.nearest(batch);
      for (int i = 0; i < RayBatch::kSize; ++i) {
        met += batch.shape[i] >= 0;
        front += batch.shape[i] >= 0 && batch.t[i] < 4.9;
      }
      traced.shadow(batch);
      for (int i = 0; i < RayBatch::kSize; ++i) blocked += batch.distance[i] < 0;
      rays += RayBatch::kSize;
    }
    // Four standard deviations of a share of 10^5 rays.
    const double off = 4 * std::sqrt(0.25 / rays);
    EXPECT_NEAR(front / rays, 0.5, off);
    EXPECT_NEAR(met / rays, 0.75, off);
    EXPECT_NEAR(blocked / rays, 0.75, off);
  }
}

}  // namespace solid_surface
}  // namespace tessera::render::TESSERA_ISA
