// Measured surfaces: summaries, pictures, and meshes that others read.
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "image/exr.h"
#include "import/ply/ply_reader.h"
#include "measure/report/measured_html.h"
#include "measure/report/measured_table.h"
#include "measure/report/mesh_maps.h"
#include "measure/report/plane_summary.h"
#include "unit/client/files.h"
#include "unit/client/measure_report/samples.h"

namespace tessera::client {
namespace {

using Imath::V3d;

/// A tent over the square from 0 to 4 with its top at (2, 2, 1), and a triangle without area; values 1 to 4.
MeasuredMeter tent() {
  MeasuredMeter meter = meter_of("tent", "illuminance", "lx", "path");
  MeasuredMesh mesh{.shape = "roof",
                    .vertices = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {2, 2, 1}},
                    .triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {0, 0, 1}}};
  for (int t = 0; t < 4; ++t) meter.readings.push_back(reading_at({2, 2, 0.5}, t + 1, 0.125));
  meter.readings.push_back(reading_at({2, 0, 0}, std::numeric_limits<double>::quiet_NaN(), 0, 0));
  meter.meshes.push_back(std::move(mesh));
  return meter;
}

TEST(MeshMap, MeansAreWeighedByArea) {
  MeasuredMeter meter = tent();
  // The first two triangles: 2 and 6 in area.
  meter.meshes[0].vertices = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {6, 0, 0}, {0, 0, 0}};
  meter.meshes[0].triangles = {{0, 1, 2}, {0, 3, 2}};
  const PlaneSummary summary = summary_of(meter, meter.meshes[0]);
  EXPECT_DOUBLE_EQ(summary.mean.value, (2 * 1.0 + 6 * 2.0) / 8);
  EXPECT_DOUBLE_EQ(summary.mean.standard_error, 0.125 * std::hypot(2, 6) / 8);
  EXPECT_EQ(summary.most, 2);
  EXPECT_EQ(summary_of(tent(), tent().meshes[0]).missing, 1u);
}

TEST(MeshMap, IsSeenFromWhereMostOfItShows) {
  const MeasuredMeter meter = tent();
  const auto view = view_of(meter, meter.meshes[0], {.pixels = 200});
  ASSERT_TRUE(view.ok()) << view.status();
  EXPECT_EQ(std::max(view->values.columns, view->values.rows), 200u);
  const std::set<std::int32_t> seen(view->triangles.begin(), view->triangles.end());
  EXPECT_EQ(seen, (std::set<std::int32_t>{-1, 0, 1, 2, 3})) << "a flat tent shows all of its sides";
  for (std::size_t i = 0; i < view->triangles.size(); ++i) {
    const std::int32_t triangle = view->triangles[i];
    EXPECT_EQ(std::isnan(view->values.values[i]), triangle < 0);
    if (triangle < 0) continue;
    ASSERT_EQ(view->values.values[i], triangle + 1);
  }
  // From below the same surface, measured on its other side, is seen as large.
  MeasuredMeter below = tent();
  below.meshes[0].turned = true;
  const auto from_below = view_of(below, below.meshes[0], {.pixels = 200});
  ASSERT_TRUE(from_below.ok());
  const auto shown = [](const MeshView& one) {
    return std::ranges::count_if(one.triangles, [](std::int32_t t) { return t >= 0; });
  };
  EXPECT_NEAR(static_cast<double>(shown(*from_below)) / static_cast<double>(shown(*view)), 1, 0.02);
}

TEST(MeshMap, NearTrianglesHideFarOnes) {
  MeasuredMeter meter = tent();
  // Two equal squares above each other, seen from above: the lower one is hidden but for its edge.
  meter.meshes[0].vertices = {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 0.01}, {9, 0, 0.01}, {0, 9, 0.01}};
  meter.meshes[0].triangles = {{3, 4, 5}, {0, 1, 2}};
  const auto view = view_of(meter, meter.meshes[0], {.pixels = 100});
  ASSERT_TRUE(view.ok());
  const auto shown = [&](std::int32_t triangle) { return std::ranges::count(view->triangles, triangle); };
  EXPECT_GT(shown(0), 1000);
  EXPECT_LT(shown(1), 100);
}

TEST(MeshMap, IsAMeshThatOthersRead) {
  const MeasuredMeter meter = tent();
  const auto bytes = mesh_ply(meter, meter.meshes[0], {});
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  const auto read = read_ply(*bytes);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->mesh.indices.size(), 15u);
  for (std::size_t t = 0; t < 5; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const float* const p = read->mesh.positions.data() + std::size_t{3} * read->mesh.indices[3 * t + k];
      const V3d& expected = meter.meshes[0].vertices[meter.meshes[0].triangles[t][k]];
      EXPECT_EQ(V3d(p[0], p[1], p[2]), expected);
    }
  }
  // Faces end the file: a count, three numbers, three colours and two floats each.
  constexpr std::size_t kFace = 1 + 3 * 4 + 3 + 2 * 4;
  for (std::size_t t = 0; t < 5; ++t) {
    float figure[2];
    std::memcpy(figure, bytes->data() + bytes->size() - (5 - t) * kFace + kFace - 8, 8);
    if (t == 4) {
      EXPECT_TRUE(std::isnan(figure[0]));
      continue;
    }
    EXPECT_EQ(figure[0], static_cast<float>(t + 1));
    EXPECT_EQ(figure[1], 0.125f);
  }
  EXPECT_NE(bytes->find("comment tent: illuminance in lx\n"), std::string::npos);
}

TEST(MeshMap, NamesCannotEndTheHeader) {
  MeasuredMeter meter = tent();
  meter.name = "x\nend_header\n";
  const auto bytes = mesh_ply(meter, meter.meshes[0], {});
  ASSERT_TRUE(bytes.ok());
  EXPECT_TRUE(read_ply(*bytes).ok());
}

TEST(MeshMap, IsWrittenAsPixels) {
  const support::TempDir directory;
  const MeasuredMeter meter = tent();
  ASSERT_TRUE(write_mesh_map(meter, meter.meshes[0], {.pixels = 64}, directory / "a.exr").ok());
  const auto image = read_exr(directory / "a.exr");
  ASSERT_TRUE(image.ok()) << image.status();
  for (const char* const channel : {"Y", "error.Y", "triangle"}) EXPECT_NE(image->find(channel), nullptr);
  EXPECT_TRUE(write_mesh_map(meter, meter.meshes[0], {.pixels = 64}, directory / "a.png").ok());
  EXPECT_FALSE(write_mesh_map(meter, meter.meshes[0], {}, directory / "a.gif").ok());
  MeasuredMeter lacking = tent();
  lacking.readings.pop_back();
  EXPECT_FALSE(write_mesh_map(lacking, lacking.meshes[0], {}, directory / "b.ply").ok());
}

TEST(MeshMap, IsPartOfTablesAndPages) {
  MeasuredMeter meter = tent();
  for (std::size_t t = 0; t < 5; ++t) meter.readings[t].label = std::to_string(t);
  const Measured room = room_of({meter});
  EXPECT_THAT(
      measured_text(room),
      testing::HasSubstr("mean of 5 triangles of roof: min 1.00, max 4.0, U0 0.400, U1 0.250, 1 without"));
  EXPECT_THAT(measured_csv(room), testing::HasSubstr("tent,illuminance,lx,3,"));
  const nlohmann::json read = nlohmann::json::parse(measured_json(room))["meters"][0]["meshes"][0];
  EXPECT_EQ(read["shape"], "roof");
  EXPECT_EQ(read["triangles"][2], (std::vector<int>{2, 3, 4}));
  EXPECT_EQ(read["vertices"][4][2], 1.0);
  EXPECT_EQ(read["mean"]["value"], 2.5);
  const std::string page = measured_html(room);
  EXPECT_THAT(page, testing::HasSubstr("5 triangles of roof"));
  EXPECT_THAT(page, testing::HasSubstr("False-colour map of illuminance, tent"));
  EXPECT_THAT(page, testing::Not(testing::HasSubstr(">none<"))) << "pixels beside it lack no values";
}

}  // namespace
}  // namespace tessera::client
