// All crossings of a ray, against closed forms.
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "unit/render/query/queried_scene.h"

namespace tessera::test::query {
namespace {

std::vector<double> distances(const QueryScene& scene, const V3d& o, const V3d& d) {
  std::vector<double> t;
  for (const render::SurfaceHit& hit : scene.hits(o, d)) t.push_back(hit.t);
  return t;
}

TEST(QueryRays, CrossASphereAtBothRoots) {
  const auto scene = load("shapes { name: 'ball' sphere { radius: 2 } }");
  ASSERT_TRUE(scene.ok()) << scene.status();
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  int crossed = 0;
  for (int i = 0; i < 10000; ++i) {
    const V3d o(4 * normal(random), 4 * normal(random), 4 * normal(random));
    const V3d d(normal(random), normal(random), normal(random));
    const double a = d.length2(), b = o.dot(d), c = o.length2() - 4, discriminant = b * b - a * c;
    if (std::abs(discriminant) < 1e-9 * b * b) continue;  // touched: rounding decides
    std::vector<double> expected;
    if (discriminant > 0) {
      for (const double sign : {-1.0, 1.0}) {
        const double t = (-b + sign * std::sqrt(discriminant)) / a;
        if (t > 0) expected.push_back(t);
      }
    }
    const std::vector<render::SurfaceHit> hits = (*scene)->hits(o, d);
    ASSERT_EQ(hits.size(), expected.size());
    crossed += !hits.empty();
    for (std::size_t k = 0; k < hits.size(); ++k) {
      // The roots lose what the discriminant cancels.
      EXPECT_NEAR(hits[k].t, expected[k], 1e-12 * (1 + b * b / discriminant) * (1 + expected[k]));
      EXPECT_NEAR((hits[k].normal - hits[k].p.normalized()).length(), 0, 1e-6);
      EXPECT_EQ(hits[k].from_front, expected.size() == 2 && k == 0);
    }
  }
  EXPECT_GT(crossed, 300);
}

TEST(QueryRays, KnowAllCrossingsOfATorus) {
  const auto scene = load("shapes { torus { major_radius: 2 minor_radius: 0.5 } }");
  ASSERT_TRUE(scene.ok()) << scene.status();
  const std::vector<double> t = distances(**scene, {-5, 0, 0}, {1, 0, 0});
  ASSERT_EQ(t.size(), 4u);
  const double expected[] = {2.5, 3.5, 6.5, 7.5};
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(t[static_cast<std::size_t>(k)], expected[k], 1e-12);
}

/// Many rays at once have the same bits as one by one, whatever they are described with.
TEST(QueryRays, AreTheSameTogether) {
  const auto scene = load(R"(
      shapes { torus { major_radius: 2 minor_radius: 0.5 } }
      shapes { box { low: [-3,-3,-3] high: [-1,-1,-1] } }
      shapes { implicit { expression: 'sin(3*x) + cos(2*y) - z' ball { radius: 2.5 } } }
      shapes { implicit { expression: 'x^4 + y^4 + z^4 - 5*x^2 - 5*y^2 - 5*z^2 + 11.8' ball { radius: 4 } } }
      shapes { csg { operation: DIFFERENCE parts { solid { sphere { radius: 1.5 } } }
                     parts { solid { implicit { expression: 'x^2 + y^2 - 0.2' ball { radius: 2 } } } } } }
      objects { name: 'o' shapes { sphere { radius: 1 } } }
      instances { object: 'o' world_from_instance { elements: [2,0,0,1, 0,1,0,2, 0,0,1,0, 0,0,0,1] } })");
  ASSERT_TRUE(scene.ok()) << scene.status();
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  std::vector<QueryScene::Line> lines;
  for (int i = 0; i < 1000; ++i) {
    const V3d o(4 * normal(random), 4 * normal(random), 4 * normal(random));
    const V3d target(normal(random), normal(random), normal(random));
    lines.push_back({o, target - o});
  }
  const std::vector<std::vector<render::SurfaceHit>> together = (*scene)->hits(lines);
  ASSERT_EQ(together.size(), lines.size());
  std::size_t all = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::vector<render::SurfaceHit> alone = (*scene)->hits(lines[i].origin, lines[i].direction);
    ASSERT_EQ(together[i].size(), alone.size());
    all += alone.size();
    for (std::size_t k = 0; k < alone.size(); ++k) {
      const render::SurfaceHit &a = together[i][k], &b = alone[k];
      EXPECT_TRUE(a.t == b.t && a.p == b.p && a.normal == b.normal && a.u == b.u && a.v == b.v)
          << i << ' ' << k;
      EXPECT_TRUE(a.from_front == b.from_front && a.shape == b.shape && a.instance == b.instance);
    }
  }
  EXPECT_GT(all, 4000u);
}

TEST(QueryRays, TellTAlongDirectionsOfAnyLength) {
  const auto scene = load("shapes { box { low: [-1,-1,-1] high: [1,1,1] } }");
  ASSERT_TRUE(scene.ok()) << scene.status();
  for (const double length : {1e-15, 1e-3, 1.0, 1e15}) {
    const std::vector<render::SurfaceHit> hits = (*scene)->hits({-3, 0.25, 0.5}, {length, 0, 0});
    ASSERT_EQ(hits.size(), 2u) << length;
    EXPECT_NEAR(hits[0].t * length, 2, 1e-12);
    EXPECT_NEAR(hits[1].t * length, 4, 1e-12);
    EXPECT_NEAR((hits[0].p - V3d(-1, 0.25, 0.5)).length(), 0, 1e-12);
  }
}

/// Every kind of closed shape, small and large: a line crosses it an even number of times, in and out by
/// turns.
class QueryRaysOfSolids : public testing::TestWithParam<const char*> {};

TEST_P(QueryRaysOfSolids, GoInAndOutByTurns) {
  const auto scene = load(absl::StrCat("shapes { ", GetParam(),
                                       " world_from_object { elements: [0.8,0,0.6,0.3, 0.1,1.4,0,0.01, "
                                       "-0.6,0,0.8,-1, 0,0,0,1] } }"));
  ASSERT_TRUE(scene.ok()) << scene.status();
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  int crossings = 0;
  for (int i = 0; i < 2000; ++i) {
    const V3d d = V3d(normal(random), normal(random), normal(random)).normalized();
    const V3d o = V3d(0.5 * normal(random), 0.5 * normal(random), 0.5 * normal(random)) - d * 20;
    const std::vector<render::SurfaceHit> hits = (*scene)->hits(o, d);
    EXPECT_EQ(hits.size() % 2, 0u);
    for (std::size_t k = 0; k < hits.size(); ++k) EXPECT_EQ(hits[k].from_front, k % 2 == 0) << hits[k].t;
    crossings += static_cast<int>(hits.size());
  }
  EXPECT_GT(crossings, 300);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, QueryRaysOfSolids,
    testing::Values(
        "sphere { radius: 1 }", "ellipsoid { radii: [1, 0.5, 2] }", "box { low: [-1,-1,-1] high: [1,1,1] }",
        "polyhedron { vertices: [0,0,0, 2,0,0, 0,2,0, 0,0,2, 1,1,1] }",
        "torus { major_radius: 1 minor_radius: 0.4 }", "cone { radius: 1 height: 2 capped: true }",
        "cylinder { radius: 1 z_min: -1 z_max: 1 capped: true }",
        "implicit { expression: 'x^4 + y^4 + z^4 - 1' ball { radius: 2 } }",
        "implicit { expression: 'sqrt(x^2 + y^2 + z^2) - 1 + 0.1*sin(8*x)' ball { radius: 2 } }"));

TEST(QueryRays, GiveBothOfTwoSheetsThatCoincide) {
  const Blobs blobs{{"sheet", mesh_blob({-1, -1, 0, 1, -1, 0, 0, 1, 0}, {0, 1, 2})}};
  const auto scene = load(mesh_shape("one", "sheet") + mesh_shape("two", "sheet"), blobs);
  ASSERT_TRUE(scene.ok()) << scene.status();
  const std::vector<render::SurfaceHit> hits = (*scene)->hits({0, 0, -3}, {0, 0, 1});
  ASSERT_EQ(hits.size(), 2u);
  EXPECT_EQ(hits[0].t, 3);
  EXPECT_EQ(hits[1].t, 3);
  EXPECT_EQ((*scene)->names(hits[0].shape).name, "one");
  EXPECT_EQ((*scene)->names(hits[1].shape).name, "two");
}

/// Rays through vertices and along edges of a closed mesh, to the last bit: parity is that of the place.
TEST(QueryRays, CrossEdgesAndVerticesOfAMeshOnce) {
  const Blobs blobs{{"cube", mesh_blob(cube_corners(), cube_triangles())}};
  const auto scene = load(mesh_shape("cube", "cube"), blobs);
  ASSERT_TRUE(scene.ok()) << scene.status();
  int aimed = 0;
  // From a lattice outside and inside to all lattice points of the surface: corners, edges, diagonals.
  for (int from = 0; from < 343; ++from) {
    const V3d o(from % 7 - 3, from / 7 % 7 - 3, from / 49 - 3);
    const double size = std::max({std::abs(o.x), std::abs(o.y), std::abs(o.z)});
    if (size == 1) continue;  // it lies on the cube
    for (int to = 0; to < 27; ++to) {
      const V3d target(to % 3 - 1, to / 3 % 3 - 1, to / 9 - 1);
      if (target == o) continue;
      const std::size_t crossings = (*scene)->hits(o, target - o).size();
      EXPECT_EQ(crossings % 2, size < 1 ? 1u : 0u) << o << " to " << target;
      ++aimed;
    }
  }
  EXPECT_GT(aimed, 3000);
}

TEST(QueryRays, CrossAFineSphereTwiceWhereverTheyAreAimed) {
  const Blobs blobs{{"sphere", sphere_mesh(24, 36)}};
  const auto scene = load(mesh_shape("sphere", "sphere"), blobs);
  ASSERT_TRUE(scene.ok()) << scene.status();
  const double pi = std::acos(-1.0);
  for (int i = 0; i <= 24; ++i) {
    for (int j = 0; j < 36; ++j) {
      const double theta = pi * i / 24, phi = 2 * pi * j / 36;
      const V3d vertex(float(std::sin(theta) * std::cos(phi)), float(std::sin(theta) * std::sin(phi)),
                       float(std::cos(theta)));
      EXPECT_EQ((*scene)->hits({0, 0, 0}, vertex).size(), 1u) << i << ' ' << j;
      EXPECT_EQ((*scene)->hits({0.125, 0.25, -0.0625}, vertex - V3d(0.125, 0.25, -0.0625)).size(), 1u);
      EXPECT_EQ((*scene)->hits({3, 0.5, 0.25}, vertex - V3d(3, 0.5, 0.25)).size() % 2, 0u);
    }
  }
}

/// A soup of large and small triangles: what each is met at by itself [Moller & Trumbore 1997], in long
/// double.
TEST(QueryRays, FindWhatBruteForceFinds) {
  constexpr int kTriangles = 600;
  std::mt19937 random(41);
  std::normal_distribution<float> normal;
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
  for (int t = 0; t < kTriangles; ++t) {
    const float size = std::exp(2 * normal(random) - 1),
                at[3] = {normal(random), normal(random), normal(random)};
    for (std::uint32_t c = 0; c < 3; ++c) {
      for (const float x : at) positions.push_back(x + size * normal(random));
      indices.push_back(3 * static_cast<std::uint32_t>(t) + c);
    }
  }
  const auto scene = load(mesh_shape("soup", "soup"), {{"soup", mesh_blob(positions, indices)}});
  ASSERT_TRUE(scene.ok()) << scene.status();
  using Exact = Imath::Vec3<long double>;
  const auto corner = [&](int t, int c) {
    const float* const p = positions.data() + 9 * t + 3 * c;
    return Exact(p[0], p[1], p[2]);
  };
  int met = 0, close = 0;
  for (int i = 0; i < 1000; ++i) {
    const V3d o(3 * normal(random), 3 * normal(random), 3 * normal(random)),
        d(normal(random), normal(random), normal(random));
    const Exact eo(o.x, o.y, o.z), ed(d.x, d.y, d.z);
    std::map<int, double> found;
    for (const render::SurfaceHit& hit : (*scene)->hits(o, d)) found[hit.primitive] = hit.t;
    for (int t = 0; t < kTriangles; ++t) {
      const Exact e1 = corner(t, 1) - corner(t, 0), e2 = corner(t, 2) - corner(t, 0), q = ed.cross(e2);
      const Exact from = eo - corner(t, 0), r = from.cross(e1);
      const long double det = e1.dot(q), u = from.dot(q) / det, v = ed.dot(r) / det, at = e2.dot(r) / det;
      // How far inside of the edges, and in front of the origin, it is; the sign of this says it all, but for
      // doubles' roundings of coordinates about 100 times the triangle's height.
      const long double depth = std::min({u, v, 1 - u - v, at});
      if (std::abs(depth) < 1e-9) {
        ++close;
        continue;
      }
      ASSERT_EQ(found.contains(t), depth > 0) << i << ' ' << t << ' ' << static_cast<double>(depth);
      if (depth < 0) continue;
      ++met;
      EXPECT_NEAR(found[t], static_cast<double>(at), 1e-10 * (1 + static_cast<double>(at)));
    }
  }
  EXPECT_GT(met, 5000);
  EXPECT_LT(close, 10);
}

TEST(QueryRays, FollowInstancesAndWhatMoves) {
  const std::string text = R"(
    objects { name: 'pair' shapes { name: 'ball' sphere { radius: 1 } } }
    instances { object: 'pair' world_from_instance { elements: [1,0,0,10, 0,1,0,0, 0,0,1,0, 0,0,0,1] } }
    instances { object: 'pair' world_from_instance { elements: [-2,0,0,20, 0,1,0,0, 0,0,1,0, 0,0,0,1] } }
    shapes { name: 'mover' sphere { radius: 1 }
      world_from_object_end { elements: [1,0,0,0, 0,1,0,0, 0,0,1,8, 0,0,0,1] } })";
  const auto scene = load(text);
  ASSERT_TRUE(scene.ok()) << scene.status();
  const std::vector<render::SurfaceHit> hits = (*scene)->hits({5, 0, 0}, {1, 0, 0});
  ASSERT_EQ(hits.size(), 4u);
  const double x[] = {9, 11, 18, 22};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(hits[k].p.x, x[k], 1e-12);
    EXPECT_EQ(hits[k].from_front, k % 2 == 0);
    EXPECT_EQ((*scene)->instance_number(hits[k].instance), k < 2 ? 1 : 2);
  }
  const auto later = load(text, {}, 0.5f);
  ASSERT_TRUE(later.ok()) << later.status();
  EXPECT_EQ(distances(**scene, {0, 0, -5}, {0, 0, 1}), (std::vector<double>{4, 6}));
  EXPECT_EQ(distances(**later, {0, 0, -5}, {0, 0, 1}), (std::vector<double>{8, 10}));
}

TEST(QueryRays, FollowObjectsWithinObjects) {
  const auto scene = load(R"(
    objects { name: 'ball' shapes { sphere { radius: 1 } } }
    objects { name: 'pair' instances { object: 'ball' }
      instances { object: 'ball' world_from_instance { elements: [1,0,0,4, 0,1,0,0, 0,0,1,0, 0,0,0,1] } } }
    instances { object: 'pair' }
    instances { object: 'pair' world_from_instance { elements: [-1,0,0,20, 0,1,0,0, 0,0,1,0, 0,0,0,1] } })");
  ASSERT_TRUE(scene.ok()) << scene.status();
  const std::vector<render::SurfaceHit> hits = (*scene)->hits({-5, 0, 0}, {1, 0, 0});
  const double x[] = {-1, 1, 3, 5, 15, 17, 19, 21};
  ASSERT_EQ(hits.size(), std::size(x));
  for (std::size_t k = 0; k < hits.size(); ++k) {
    EXPECT_NEAR(hits[k].p.x, x[k], 1e-12);
    EXPECT_EQ((*scene)->instance_number(hits[k].instance), k < 4 ? 1 : 2);
  }
}

TEST(QueryRays, CrossACombinationOfSolidsAsOneShape) {
  const auto scene = load(R"(
    shapes { name: 'shell' csg { operation: DIFFERENCE
      parts { solid { box { low: [-1, -1, -1] high: [1, 1, 1] } } }
      parts { solid { half_space { height: -0.5 } } }
      parts { solid { sphere { radius: 0.5 } } } } })");
  ASSERT_TRUE(scene.ok()) << scene.status();
  const std::vector<double> t = distances(**scene, {-3, 0, 0}, {1, 0, 0});
  const double expected[] = {2, 2.5, 3.5, 4};
  ASSERT_EQ(t.size(), std::size(expected));
  for (std::size_t k = 0; k < t.size(); ++k) EXPECT_NEAR(t[k], expected[k], 1e-6);
  EXPECT_EQ((*scene)->at({0.75, 0, 0}).inside(), render::Inside::kInside);
  EXPECT_EQ((*scene)->at({0, 0, 0.1}).inside(), render::Inside::kOutside);
  EXPECT_EQ((*scene)->at({0.75, 0.75, -0.75}).inside(), render::Inside::kOutside);
  EXPECT_EQ((*scene)->inspect().size(), 1u);
  const std::vector<render::BoundsReport> bounds = (*scene)->bounds();
  ASSERT_EQ(bounds.size(), 2u);  // the scene's and the shape's
  EXPECT_FALSE(bounds[1].unbounded);
}

/// However close borders are to one another: of lines that begin and end outside, none is left out.
TEST(QueryRays, CrossCombinationsAnEvenNumberOfTimes) {
  for (const char* csg :
       {"operation: DIFFERENCE parts { solid { sphere { radius: 1 } } }"
        " parts { solid { torus { major_radius: 0.8 minor_radius: 0.4 } } }"
        " parts { solid { box { low: [-2, -0.1, -2] high: [2, 0.1, 2] } } }",
        "operation: INTERSECTION parts { solid { box { low: [-0.9, -0.9, -0.9] high: [0.9, 0.9, 0.9] } } }"
        " parts { solid { implicit { expression: 'sin(7*x) + cos(6*y) + sin(5*z)' ball { radius: 1.1 } } } "
        "}"}) {
    const auto scene = load(absl::StrCat("shapes { csg { ", csg, " } }"));
    ASSERT_TRUE(scene.ok()) << scene.status();
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    int odd = 0, crossings = 0;
    constexpr int kRays = 65536;
    for (int i = 0; i < kRays; ++i) {
      const V3d d = V3d(normal(random), normal(random), normal(random)).normalized();
      const V3d o = V3d(0.5 * normal(random), 0.5 * normal(random), 0.5 * normal(random)) - d * 20;
      const std::size_t count = (*scene)->hits(o, d).size();
      odd += count % 2 != 0;
      crossings += static_cast<int>(count);
    }
    EXPECT_EQ(odd, 0);
    EXPECT_GT(crossings, kRays);
  }
}

TEST(QueryRays, OfASceneWithoutShapesMeetNothing) {
  const auto scene = load("");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE((*scene)->hits({0, 0, 0}, {0, 0, 1}).empty());
  EXPECT_EQ((*scene)->at({0, 0, 0}).inside(), render::Inside::kOutside);
  EXPECT_FALSE((*scene)->closest({0, 0, 0}).hit.has_value());
  EXPECT_EQ((*scene)->bounds().size(), 1u);
  EXPECT_TRUE((*scene)->inspect().empty());
}

}  // namespace
}  // namespace tessera::test::query
