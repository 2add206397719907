// Parity and winding number: where they agree, and where an open mesh tells them apart.
#include <gtest/gtest.h>

#include <random>

#include "render/query/winding.h"
#include "unit/render/query/queried_scene.h"
#include "wire/volume_blob.h"

namespace tessera::test::query {
namespace {

using render::Inside;

std::string triangle_shapes(const char* name) { return mesh_shape(name, name); }

TEST(QueryInside, KnowsSolidsInClosedForm) {
  struct Case {
    const char* shape;
    bool (*within)(const V3d& p);
  };
  const Case cases[] = {
      {"sphere { radius: 1 }", [](const V3d& p) { return p.length() < 1; }},
      {"box { low: [-1,-0.5,-1] high: [1,0.5,1] }",
       [](const V3d& p) { return std::abs(p.x) < 1 && std::abs(p.y) < 0.5 && std::abs(p.z) < 1; }},
      {"torus { major_radius: 1 minor_radius: 0.5 }",
       [](const V3d& p) { return std::hypot(std::hypot(p.x, p.y) - 1, p.z) < 0.5; }},
      {"ellipsoid { radii: [1, 0.5, 1.5] }",
       [](const V3d& p) { return p.x * p.x + 4 * p.y * p.y + p.z * p.z / 2.25 < 1; }},
      {"half_space { height: 0.25 }", [](const V3d& p) { return p.z < 0.25; }},
      {"cone { radius: 1 height: 1 capped: true }",
       [](const V3d& p) { return p.z > 0 && std::hypot(p.x, p.y) < 1 - p.z; }},
      {"polyhedron { planes: [1,0,0,1, -1,0,0,1, 0,1,0,1, 0,-1,0,1, 0,0,1,0.5, 0,0,-1,0.5] }",
       [](const V3d& p) { return std::abs(p.x) < 1 && std::abs(p.y) < 1 && std::abs(p.z) < 0.5; }},
      {"implicit { expression: 'x^4 + y^4 + z^4 - 1' ball { radius: 2 } }",
       [](const V3d& p) { return std::pow(p.x, 4) + std::pow(p.y, 4) + std::pow(p.z, 4) < 1; }}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-1.6, 1.6);
  for (const Case& c : cases) {
    const auto scene = load(absl::StrCat("shapes { ", c.shape, " }"));
    ASSERT_TRUE(scene.ok()) << scene.status();
    for (int i = 0; i < 400; ++i) {
      const V3d p(coordinate(random), coordinate(random), coordinate(random));
      const render::PointReport report = (*scene)->at(p);
      EXPECT_EQ(report.inside(), c.within(p) ? Inside::kInside : Inside::kOutside) << c.shape << ' ' << p;
      for (const render::Containment& shape : report.shapes) EXPECT_TRUE(shape.closed);
    }
  }
}

/// A grid of distances to a sphere of radius 0.35 in the unit cube: crossings of voxel after voxel against
/// the sign between samples.
TEST(QueryInside, GridsOfDistancesAreSolids) {
  constexpr std::uint32_t kSize = 16;
  std::vector<float> samples;
  for (std::uint32_t i = 0; i < kSize * kSize * kSize; ++i) {
    const V3d p(i % kSize, i / kSize % kSize, i / kSize / kSize);
    samples.push_back(static_cast<float>((p / (kSize - 1) - V3d(0.5, 0.5, 0.5)).length() - 0.35));
  }
  const Blobs blobs{
      {"grid",
       wire::encode_volume({.nx = kSize, .ny = kSize, .nz = kSize, .channels = 1, .samples = samples})}};
  const auto scene = load("shapes { sdf_grid { blob { digest: 'grid' } } }", blobs);
  ASSERT_TRUE(scene.ok()) << scene.status();
  std::mt19937 random(19);
  std::uniform_real_distribution<double> coordinate(-0.2, 1.2);
  int within = 0;
  for (int i = 0; i < 1000; ++i) {
    const V3d p(coordinate(random), coordinate(random), coordinate(random));
    const double distance = (p - V3d(0.5, 0.5, 0.5)).length() - 0.35;
    if (std::abs(distance) < 0.01) continue;  // between the sphere and what the samples make of it
    within += distance < 0;
    EXPECT_EQ((*scene)->at(p).inside(), distance < 0 ? Inside::kInside : Inside::kOutside) << p;
  }
  EXPECT_GT(within, 30);
}

TEST(QueryInside, ACubeWithoutAFaceIsUnsureAboutItsHoleAlone) {
  std::vector<std::uint32_t> open = cube_triangles();
  open.resize(30);  // without z = 1
  const Blobs blobs{{"open", mesh_blob(cube_corners(), open)},
                    {"closed", mesh_blob(cube_corners(), cube_triangles())}};
  const auto whole = load(triangle_shapes("closed"), blobs), holed = load(triangle_shapes("open"), blobs);
  ASSERT_TRUE(whole.ok() && holed.ok());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  int unsure = 0;
  for (int i = 0; i < 2000; ++i) {
    const V3d p(coordinate(random), coordinate(random), coordinate(random));
    const bool within = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < 1;
    EXPECT_EQ((*whole)->at(p).inside(), within ? Inside::kInside : Inside::kOutside);
    // The winding number of the holed one lacks the solid angle of the face that is not there.
    const auto corner = [&](double x, double y) { return V3d(x, y, 1) - p; };
    const double face = (render::solid_angle(corner(-1, -1), corner(1, -1), corner(-1, 1)) +
                         render::solid_angle(corner(1, -1), corner(1, 1), corner(-1, 1))) /
                        (4 * std::acos(-1.0));
    const render::PointReport report = (*holed)->at(p);
    for (const render::Containment& c : report.shapes) {
      EXPECT_FALSE(c.closed);
      EXPECT_NEAR(c.winding, (within ? 1 : 0) - face, render::WindingTree::kError);
    }
    unsure += report.inside() == Inside::kUnsure;
  }
  EXPECT_GT(unsure, 20);
  // Parity alone is wrong here: the first direction leaves by the hole. The winding number says 5/6.
  const render::PointReport centre = (*holed)->at({0, 0, 0});
  EXPECT_EQ(centre.inside(), Inside::kUnsure);
  ASSERT_EQ(centre.shapes.size(), 1u);
  EXPECT_FALSE(centre.shapes[0].by_parity);
  EXPECT_NEAR(centre.shapes[0].winding, 5.0 / 6, 1e-12);
}

TEST(QueryInside, ASheetThatALineCrossesIsNoReasonForDoubt) {
  const auto scene = load(mesh_shape("sheet", "sheet") + "shapes { disk { radius: 9 height: 3 } }",
                          {{"sheet", mesh_blob({-9, -9, 2, 9, -9, 2, 0, 9, 2}, {0, 1, 2})}});
  ASSERT_TRUE(scene.ok()) << scene.status();
  const render::PointReport above_ground = (*scene)->at({0, 0, -20});
  EXPECT_EQ(above_ground.inside(), Inside::kOutside);
  // Next to the triangle, it covers half of all directions.
  EXPECT_EQ((*scene)->at({0, 0, 1.99}).inside(), Inside::kUnsure);
}

/// Winding numbers of a sphere, and of one cut open, where they are no whole numbers.
TEST(QueryInside, WindingTreesAreAsGoodAsSumsOverAllTriangles) {
  for (const double share : {1.0, 0.6}) {
    const std::string blob = sphere_mesh(60, 90);
    const auto whole = wire::decode_mesh(blob);
    ASSERT_TRUE(whole.ok());
    const std::vector<float> positions(whole->positions.begin(), whole->positions.end());
    std::vector<std::uint32_t> indices(whole->indices.begin(), whole->indices.end());
    indices.resize(static_cast<std::size_t>(share * static_cast<double>(indices.size() / 3)) * 3);
    const auto scene = load(mesh_shape("sphere", "sphere"), {{"sphere", mesh_blob(positions, indices)}});
    ASSERT_TRUE(scene.ok()) << scene.status();
    std::mt19937 random(9);
    std::normal_distribution<double> normal;
    int within = 0;
    double worst = 0;
    for (int i = 0; i < 400; ++i) {
      const V3d p = V3d(normal(random), normal(random), normal(random)) * 0.7;
      const auto corner = [&](std::size_t k) {
        const float* const v = positions.data() + 3 * std::size_t{indices[k]};
        return V3d(v[0], v[1], v[2]) - p;
      };
      double sum = 0;
      for (std::size_t t = 0; t < indices.size(); t += 3)
        sum += render::solid_angle(corner(t), corner(t + 1), corner(t + 2));
      const double winding = sum / (4 * std::acos(-1.0));
      for (const render::Containment& c : (*scene)->at(p).shapes) {
        worst = std::max(worst, std::abs(c.winding - winding));
        ++within;
      }
      if (share == 1 && std::abs(p.length() - 1) > 0.01) {  // not between the sphere and its facets
        EXPECT_EQ((*scene)->at(p).inside(), p.length() < 1 ? Inside::kInside : Inside::kOutside);
      }
    }
    EXPECT_LT(worst, render::WindingTree::kError);
    RecordProperty("worst", absl::StrCat(worst));
    EXPECT_GT(within, 50);
  }
}

TEST(QueryInside, NestedShapesStandInnermostFirstWithTheirMedia) {
  const auto scene = load(R"(
    media { name: 'milk' extinction { constant { constant: 1 } } albedo { constant { constant: 0.5 } } }
    media { name: 'haze' extinction { constant { constant: 0.1 } } albedo { constant { constant: 0.5 } } }
    materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
    shapes { name: 'outer' material: 'glass' sphere { radius: 3 } interior_medium: 'haze' }
    shapes { name: 'inner' sphere { radius: 1 } interior_medium: 'milk' exterior_medium: 'haze' })");
  ASSERT_TRUE(scene.ok()) << scene.status();
  const render::PointReport in_both = (*scene)->at({0.1, 0.2, 0}), between = (*scene)->at({2, 0, 0}),
                            out = (*scene)->at({5, 0, 0});
  ASSERT_EQ(in_both.shapes.size(), 2u);
  EXPECT_EQ((*scene)->names(in_both.shapes[0].shape).name, "inner");
  EXPECT_EQ((*scene)->names(in_both.shapes[1].shape).name, "outer");
  EXPECT_EQ(in_both.medium, "milk");
  EXPECT_EQ(between.medium, "haze");
  ASSERT_EQ(between.shapes.size(), 1u);
  EXPECT_EQ((*scene)->names(between.shapes[0].shape).material, "glass");
  EXPECT_EQ(out.medium, "");
  EXPECT_TRUE(out.shapes.empty());
}

TEST(QueryInside, TheCamerasMediumIsWhereNoBorderIsMet) {
  const auto scene = load(R"(
    media { name: 'fog' extinction { constant { constant: 0.1 } } albedo { constant { constant: 0.5 } } }
    camera { medium: 'fog' world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-9, 0,0,0,1] } }
    shapes { name: 'hollow' sphere { radius: 1 } exterior_medium: 'fog' })");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ((*scene)->at({5, 0, 0}).medium, "fog");
  EXPECT_EQ((*scene)->at({0, 0, 0}).medium, "");
}

TEST(QueryInside, HoldsInMirroredAndStretchedInstances) {
  const Blobs blobs{{"cube", mesh_blob(cube_corners(), cube_triangles())}};
  const auto scene = load(absl::StrCat("objects { name: 'o' ", mesh_shape("cube", "cube"),
                                       R"(} instances { object: 'o' world_from_instance {
                                       elements: [-3,0,0,1, 0,0.5,0.25,0, 0,0,1,2, 0,0,0,1] } })"),
                          blobs);
  ASSERT_TRUE(scene.ok()) << scene.status();
  std::mt19937 random(13);
  std::uniform_real_distribution<double> coordinate(-5, 5);
  for (int i = 0; i < 1000; ++i) {
    const V3d p(coordinate(random), coordinate(random) / 3, coordinate(random));
    const double z = p.z - 2, y = (p.y - 0.25 * z) / 0.5, x = (p.x - 1) / -3;
    const bool within = std::max({std::abs(x), std::abs(y), std::abs(z)}) < 1;
    const render::PointReport report = (*scene)->at(p);
    EXPECT_EQ(report.inside(), within ? Inside::kInside : Inside::kOutside) << p;
  }
}

}  // namespace
}  // namespace tessera::test::query
