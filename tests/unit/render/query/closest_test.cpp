// Closest points: against closed forms, and against the nearest of many samples.
#include <gtest/gtest.h>

#include <random>

#include "render/query/nearest_point.h"
#include "unit/render/query/queried_scene.h"

namespace tessera::test::query {
namespace {

TEST(QueryClosest, KnowsSpheresAndBoxesInClosedForm) {
  const auto ball = load("shapes { sphere { radius: 2 } }"),
             box = load("shapes { box { low: [-1,-2,-3] high: [1,2,3] } }");
  ASSERT_TRUE(ball.ok() && box.ok());
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const V3d p = V3d(normal(random), normal(random), normal(random)) * 3;
    const render::ClosestReport on_ball = (*ball)->closest(p), on_box = (*box)->closest(p);
    ASSERT_TRUE(on_ball.hit && on_box.hit);
    EXPECT_NEAR(on_ball.hit->t, std::abs(p.length() - 2), 1e-12);
    EXPECT_EQ(on_ball.hit->from_front, p.length() > 2);
    const V3d q(std::abs(p.x) - 1, std::abs(p.y) - 2, std::abs(p.z) - 3);
    const V3d beyond(std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0));
    const double least = std::max({q.x, q.y, q.z});
    EXPECT_NEAR(on_box.hit->t, least > 0 ? beyond.length() : -least, 1e-12);
    EXPECT_EQ(on_ball.error, 0);
    EXPECT_EQ(on_box.error, 0);
  }
}

/// A shape, how it is placed, and a mesh of points on it to hold the answer against.
struct Sampled {
  const char* name;
  const char* shape;
  const char* place;
};
void PrintTo(const Sampled& s, std::ostream* out) { *out << s.name; }

class QueryClosestOf : public testing::TestWithParam<Sampled> {};

/// No point of the surface, found by rays that cross it, is closer than the answer; the answer is on the
/// surface; and the way to it is along the normal, or to an edge: some crossing is nearly as close.
TEST_P(QueryClosestOf, NoCrossingIsCloser) {
  const auto scene = load(absl::StrCat("shapes { ", GetParam().shape, " world_from_object { elements: [",
                                       GetParam().place, ", 0,0,0,1] } }"));
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE((*scene)->without_closest().empty());
  std::mt19937 random(17);
  std::normal_distribution<double> normal;
  const render::BoundsReport box = (*scene)->bounds()[0];
  const V3d middle = (box.low + box.high) / 2;
  const double size = (box.high - box.low).length();
  std::vector<V3d> surface;
  for (int i = 0; i < 40000; ++i) {
    const V3d d = V3d(normal(random), normal(random), normal(random)).normalized();
    const V3d o =
        middle + V3d(normal(random), normal(random), normal(random)) * (0.3 * size) - d * (3 * size);
    for (const render::SurfaceHit& hit : (*scene)->hits(o, d)) surface.push_back(hit.p);
  }
  ASSERT_GT(surface.size(), 1000u);
  for (const V3d& p : surface) {
    for (int k = 0; k < 3; ++k) {
      ASSERT_GE(p[k], box.low[k] - 1e-6 * size);
      ASSERT_LE(p[k], box.high[k] + 1e-6 * size);
    }
  }
  // Samples this dense leave no cap of the surface of this radius empty, but for one in e^20 or so.
  const double apart = size * std::sqrt(20 * 8.0 / static_cast<double>(surface.size()));
  for (int i = 0; i < 60; ++i) {
    const V3d p = middle + V3d(normal(random), normal(random), normal(random)) * (0.5 * size);
    const render::ClosestReport answer = (*scene)->closest(p);
    ASSERT_TRUE(answer.hit.has_value());
    EXPECT_EQ(answer.error, 0);
    double least = HUGE_VAL;
    for (const V3d& q : surface) least = std::min(least, (q - p).length());
    EXPECT_LE(answer.hit->t, least * (1 + 1e-6) + 1e-6 * size);
    EXPECT_LE(least, answer.hit->t + apart);
    EXPECT_NEAR((answer.hit->p - p).length(), answer.hit->t, 1e-9 * size);
  }
}

constexpr const char* kTurned = "0.8,0,0.6,0.3, 0,1,0,0.01, -0.6,0,0.8,-1";
constexpr const char* kStretched = "0.8,0.3,0.6,0.3, 0.1,1.9,0,0.01, -0.6,0,0.4,-1";

INSTANTIATE_TEST_SUITE_P(
    Kinds, QueryClosestOf,
    testing::Values(
        Sampled{"Ellipsoid", "ellipsoid { radii: [1, 0.5, 2] }", kStretched},
        Sampled{"FlatEllipsoid", "ellipsoid { radii: [1, 1, 0.01] }", kTurned},
        Sampled{"PartOfASphere", "sphere { radius: 1 z_min: -0.5 z_max: 0.7 phi_max_degrees: 200 }", kTurned},
        Sampled{"Torus", "torus { major_radius: 1 minor_radius: 0.3 }", kTurned},
        Sampled{"Ring", "disk { radius: 1 inner_radius: 0.5 phi_max_degrees: 100 }", kTurned},
        Sampled{"Cylinder", "cylinder { radius: 1 z_min: -1 z_max: 0.5 }", kTurned},
        Sampled{"Cone", "cone { radius: 1 height: 3 capped: true }", kTurned},
        Sampled{"CutCone", "cone { radius: 1 height: 1 top_radius: 0.4 phi_max_degrees: 250 }", kTurned},
        Sampled{"CappedCylinder", "cylinder { radius: 0.5 z_min: -1 z_max: 2 capped: true }", kTurned},
        Sampled{"Polyhedron", "polyhedron { vertices: [0,0,0, 2,0,0, 0,2,0, 0,0,2, 1,1,1] }", kStretched},
        Sampled{"Star", "polygon { corners: [0,0,0, 2,0,0, 2,2,0, 1,0.5,0, 0,2,0] }", kStretched}),
    [](const auto& of) { return of.param.name; });

TEST(QueryClosest, IsExactForTriangles) {
  std::mt19937 random(23);
  std::normal_distribution<double> normal;
  const auto any = [&] { return V3d(normal(random), normal(random), normal(random)); };
  for (int i = 0; i < 2000; ++i) {
    const V3d a = any(), b = any(), c = any(), p = any() * 2;
    const render::TrianglePoint q = render::nearest_on_triangle(p, a, b, c);
    EXPECT_NEAR((a * (1 - q.b1 - q.b2) + b * q.b1 + c * q.b2 - q.p).length(), 0, 1e-12);
    EXPECT_GE(std::min({q.b1, q.b2, 1 - q.b1 - q.b2}), -1e-12);
    // The plane through it across the way to p has the triangle on its far side: it is the closest.
    for (const V3d& corner : {a, b, c}) EXPECT_LE((corner - q.p).dot(p - q.p), 1e-10);
  }
}

TEST(QueryClosest, SearchesMeshesAndInstancesLikeBruteForce) {
  const Blobs blobs{{"sphere", sphere_mesh(10, 14)}};
  const auto scene = load(absl::StrCat("objects { name: 'o' ", mesh_shape("m", "sphere"), R"(}
    instances { object: 'o' world_from_instance { elements: [1,0,0,3, 0,2,0,0, 0,0,0.3,0, 0,0,0,1] } }
    instances { object: 'o' world_from_instance { elements: [0,0,1,-3, 0,-1,0,0, 1,0,0,1, 0,0,0,1] } })"),
                          blobs);
  ASSERT_TRUE(scene.ok()) << scene.status();
  const auto mesh = wire::decode_mesh(blobs.at("sphere"));
  ASSERT_TRUE(mesh.ok());
  const render::ExactAffine places[] = {{{1, 0, 0, 3, 0, 2, 0, 0, 0, 0, 0.3f, 0}},
                                        {{0, 0, 1, -3, 0, -1, 0, 0, 1, 0, 0, 1}}};
  std::mt19937 random(29);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    const V3d p = V3d(normal(random), normal(random), normal(random)) * 3;
    double least = HUGE_VAL;
    for (const render::ExactAffine& place : places) {
      const auto corner = [&](std::size_t k) {
        const float* const v = mesh->positions.data() + 3 * std::size_t{mesh->indices[k]};
        return render::apply(place, {v[0], v[1], v[2]});
      };
      for (std::size_t t = 0; t < mesh->indices.size(); t += 3)
        least = std::min(
            least, (render::nearest_on_triangle(p, corner(t), corner(t + 1), corner(t + 2)).p - p).length());
    }
    const render::ClosestReport answer = (*scene)->closest(p);
    ASSERT_TRUE(answer.hit.has_value());
    EXPECT_NEAR(answer.hit->t, least, 1e-12);
  }
}

TEST(QueryClosest, StatesTheErrorWhereThereIsNoFormula) {
  const auto scene = load(R"(
    shapes { name: 'ball' sphere { radius: 1 } }
    shapes { name: 'wave' implicit { expression: 'x^4 + y^4 + z^4 - 1' ball { radius: 2 } }
      world_from_object { elements: [1,0,0,6, 0,1,0,0, 0,0,1,0, 0,0,0,1] } })");
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ((*scene)->without_closest().size(), 1u);
  const render::ClosestReport far = (*scene)->closest({-3, 0, 0}), near = (*scene)->closest({3.5, 0, 0});
  ASSERT_TRUE(far.hit && near.hit);
  EXPECT_EQ(far.error, 0);  // the other's box is farther away than the answer
  EXPECT_NEAR(near.hit->t, 2.5, 1e-12);
  EXPECT_NEAR(near.error, 2, 1e-4);  // its box begins 0.5 away
}

}  // namespace
}  // namespace tessera::test::query
