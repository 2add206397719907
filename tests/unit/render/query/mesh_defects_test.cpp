// Defects of meshes, planted one by one.
#include <gtest/gtest.h>

#include "unit/render/query/queried_scene.h"

namespace tessera::test::query {
namespace {

using render::MeshDefect;

render::MeshReport inspect(const std::vector<float>& positions, const std::vector<std::uint32_t>& triangles) {
  const Blobs blobs{{"mesh", mesh_blob(positions, triangles)}};
  const auto scene = load(mesh_shape("mesh", "mesh"), blobs);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? (*scene)->inspect().at(0).mesh : render::MeshReport{};
}

int count(const render::MeshReport& report, MeshDefect defect) {
  int n = 0;
  for (const render::DefectPlace& place : report.defects) n += place.defect == defect;
  return n;
}

TEST(MeshDefects, ACubeHasNone) {
  const render::MeshReport report = inspect(cube_corners(), cube_triangles());
  EXPECT_TRUE(report.watertight());
  EXPECT_TRUE(report.closed);
  EXPECT_EQ(report.triangles, 12);
  EXPECT_EQ(report.vertices, 8);
  EXPECT_EQ(report.edges, 18);
}

TEST(MeshDefects, CornersInOnePlaceAreOneVertex) {
  // Each triangle with corners of its own, as in an STL file.
  std::vector<float> positions;
  std::vector<std::uint32_t> triangles;
  for (const std::uint32_t v : cube_triangles()) {
    for (std::uint32_t k = 0; k < 3; ++k) positions.push_back(cube_corners()[3 * v + k]);
    triangles.push_back(static_cast<std::uint32_t>(triangles.size()));
  }
  const render::MeshReport report = inspect(positions, triangles);
  EXPECT_TRUE(report.watertight());
  EXPECT_EQ(report.vertices, 8);
}

TEST(MeshDefects, AMissingFaceIsFourOpenEdges) {
  std::vector<std::uint32_t> triangles = cube_triangles();
  triangles.resize(30);
  const render::MeshReport report = inspect(cube_corners(), triangles);
  EXPECT_FALSE(report.closed);
  EXPECT_EQ(count(report, MeshDefect::kOpenEdge), 4);
  EXPECT_EQ(report.defects.size(), 4u);
  for (const render::DefectPlace& place : report.defects) {
    EXPECT_EQ(place.from.z, 1);
    EXPECT_EQ(place.to.z, 1);
    EXPECT_NEAR((place.to - place.from).length(), 2, 1e-12);
  }
}

TEST(MeshDefects, ATriangleTheOtherWayRoundIsInconsistentAtItsThreeEdges) {
  std::vector<std::uint32_t> triangles = cube_triangles();
  std::swap(triangles[0], triangles[1]);
  const render::MeshReport report = inspect(cube_corners(), triangles);
  EXPECT_TRUE(report.closed);
  EXPECT_FALSE(report.watertight());
  EXPECT_EQ(count(report, MeshDefect::kInconsistentEdge), 3);
}

TEST(MeshDefects, ADuplicateCrowdsItsEdges) {
  std::vector<std::uint32_t> triangles = cube_triangles();
  triangles.insert(triangles.end(), {triangles[1], triangles[2], triangles[0]});
  const render::MeshReport report = inspect(cube_corners(), triangles);
  ASSERT_EQ(count(report, MeshDefect::kDuplicate), 1);
  EXPECT_EQ(count(report, MeshDefect::kCrowdedEdge), 3);
  EXPECT_EQ(report.defects[0].primitive, 12);
  EXPECT_FALSE(report.closed);
}

TEST(MeshDefects, TrianglesWithoutAreaAreNamed) {
  std::vector<float> positions = cube_corners();
  positions.insert(positions.end(), {0, 0, 7, 1, 1, 8, 3, 3, 10});
  std::vector<std::uint32_t> triangles = cube_triangles();
  triangles.insert(triangles.end(), {8, 9, 10, 0, 0, 1});  // collinear; two corners in one point
  const render::MeshReport report = inspect(positions, triangles);
  EXPECT_EQ(count(report, MeshDefect::kDegenerate), 2);
  EXPECT_EQ(count(report, MeshDefect::kOpenEdge), 3);  // the edges of the first
}

TEST(MeshDefects, AMoebiusStripTurnsItsBackOnce) {
  std::vector<float> positions;
  std::vector<std::uint32_t> triangles;
  constexpr std::uint32_t kSteps = 24;
  const double pi = std::acos(-1.0);
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const double phi = 2 * pi * i / kSteps;
    for (const double side : {-0.3, 0.3}) {
      const double r = 1 + side * std::cos(phi / 2);
      positions.insert(positions.end(),
                       {float(r * std::cos(phi)), float(r * std::sin(phi)), float(side * std::sin(phi / 2))});
    }
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const bool last = i + 1 == kSteps;  // where the ends are joined, the other way up
    const std::uint32_t a = 2 * i, b = 2 * i + 1, c = last ? 1 : 2 * i + 2, d = last ? 0 : 2 * i + 3;
    triangles.insert(triangles.end(), {a, c, b, b, c, d});
  }
  const render::MeshReport report = inspect(positions, triangles);
  EXPECT_EQ(count(report, MeshDefect::kInconsistentEdge), 1);
  EXPECT_EQ(count(report, MeshDefect::kOpenEdge), 2 * static_cast<int>(kSteps));  // one rim, twice around
  EXPECT_EQ(report.defects.size(), 2 * kSteps + 1);
}

TEST(QueryBounds, AreTightForRoundShapesInAnyPosition) {
  // A torus turned about x by 45 degrees: its support along y and z is (R + sqrt(2) r) / sqrt(2).
  const double h = std::sqrt(0.5);
  const auto scene = load(
      absl::StrCat("shapes { name: 'ring' torus { major_radius: 2 minor_radius: 0.5 } world_from_object { "
                   "elements: [1,0,0,5, 0,",
                   h, ",", -h, ",0, 0,", h, ",", h, ",0, 0,0,0,1] } } shapes { half_space { height: -9 } }"));
  ASSERT_TRUE(scene.ok()) << scene.status();
  const std::vector<render::BoundsReport> rows = (*scene)->bounds();
  ASSERT_EQ(rows.size(), 3u);
  const V3d low(2.5, -(2 * h + 0.5), -(2 * h + 0.5)), high(7.5, 2 * h + 0.5, 2 * h + 0.5);
  for (int row = 0; row < 2; ++row) {  // the half-space does not count
    EXPECT_TRUE(rows[static_cast<std::size_t>(row)].tight);
    EXPECT_NEAR((rows[static_cast<std::size_t>(row)].low - low).length(), 0, 1e-6);
    EXPECT_NEAR((rows[static_cast<std::size_t>(row)].high - high).length(), 0, 1e-6);
  }
  EXPECT_TRUE(rows[2].unbounded);
}

}  // namespace
}  // namespace tessera::test::query
