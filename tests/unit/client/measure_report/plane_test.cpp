#include <gtest/gtest.h>
#include <png.h>

#include <cmath>

#include "image/exr.h"
#include "measure/report/plane_maps.h"
#include "measure/report/plane_summary.h"
#include "unit/client/files.h"
#include "unit/client/measure_report/samples.h"

namespace tessera::client {
namespace {

TEST(Plane, HasItsFirstRowBelow) {
  const MeasuredMeter floor = floor_of(3, 2);
  const auto grid = grid_of(floor, floor.planes[0]);
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(grid->at(0, 1), 1);
  EXPECT_EQ(grid->at(2, 1), 3);
  EXPECT_EQ(grid->at(0, 0), 4);
}

TEST(Plane, IsRefusedWhereItsMeterLacksReadings) {
  MeasuredMeter floor = floor_of(3, 2);
  floor.planes[0].first_reading = 1;
  const auto grid = grid_of(floor, floor.planes[0]);
  ASSERT_FALSE(grid.ok());
  EXPECT_NE(grid.status().message().find("meter 'floor'"), std::string::npos);
  EXPECT_FALSE(plane_image(floor, floor.planes[0], {}).ok());
  EXPECT_EQ(summary_of(floor, floor.planes[0]).cells, 0u);
  floor.planes[0].first_reading = ~std::size_t{0};
  EXPECT_FALSE(grid_of(floor, floor.planes[0]).ok());
  EXPECT_FALSE(is_of_map(floor, 0));
}

TEST(Plane, IsSummarised) {
  const MeasuredMeter floor = floor_of(3, 2);
  const PlaneSummary summary = summary_of(floor, floor.planes[0]);
  EXPECT_EQ(summary.cells, 6u);
  EXPECT_DOUBLE_EQ(summary.mean.value, 3.5);
  EXPECT_DOUBLE_EQ(summary.mean.standard_error, 0.125 / std::sqrt(6));
  // Equal errors of 63 degrees of freedom each: (6 e^2)^2 / (6 e^4 / 63).
  EXPECT_DOUBLE_EQ(summary.mean.degrees_of_freedom, 6 * 63);
  EXPECT_EQ(summary.mean.samples, 6 * 4096u);
  EXPECT_EQ(summary.least, 1);
  EXPECT_EQ(summary.most, 6);
  EXPECT_DOUBLE_EQ(summary.uniformity_mean, 1 / 3.5);
  EXPECT_DOUBLE_EQ(summary.uniformity_most, 1.0 / 6);
  EXPECT_DOUBLE_EQ(summary.worst_error, 0.125);
}

TEST(Plane, LeavesOutCellsWithoutAValue) {
  MeasuredMeter floor = floor_of(2, 2);
  floor.readings[0].figure.value = std::numeric_limits<double>::quiet_NaN();
  const PlaneSummary summary = summary_of(floor, floor.planes[0]);
  EXPECT_EQ(summary.cells, 3u);
  EXPECT_EQ(summary.missing, 1u);
  EXPECT_DOUBLE_EQ(summary.mean.value, 3);
  for (Reading& reading : floor.readings) reading.figure.value = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isnan(summary_of(floor, floor.planes[0]).mean.value));
}

TEST(Plane, IsWrittenAsFloats) {
  const support::TempDir directory;
  const MeasuredMeter floor = floor_of(3, 2);
  const std::string path = directory / "floor.exr";
  ASSERT_TRUE(write_plane_map(room_of({floor}), floor, floor.planes[0], {.exr_pixels = 4}, path).ok());
  const auto image = read_exr(path);
  ASSERT_TRUE(image.ok()) << image.status();
  EXPECT_EQ(image->data.width(), 12);
  EXPECT_EQ(image->data.height(), 8);
  const Channel* const values = image->find("Y");
  ASSERT_NE(values, nullptr);
  EXPECT_EQ(values->values[0], 4.f) << "upper left: the first of the second row";
  EXPECT_EQ(values->values[7 * 12 + 11], 3.f);
  ASSERT_NE(image->find("error.Y"), nullptr);
  EXPECT_EQ(image->find("error.Y")->values[5], 0.125f);
  EXPECT_EQ(std::get<std::string>(image->metadata.at("tessera.unit")), "lx");
}

TEST(Plane, BetweenMiddlesOfCellsValuesAreLinear) {
  const MeasuredMeter floor = floor_of(3, 2);
  const auto image = plane_image(floor, floor.planes[0], {.smooth = true, .exr_pixels = 4});
  ASSERT_TRUE(image.ok());
  // Values are 1 + column + 3 row: linear, but for the outer half of the outermost cells.
  for (int y = 2; y < 6; ++y) {
    for (int x = 2; x < 10; ++x) {
      const double column = (x + 0.5) / 4 - 0.5, row = (8 - y - 0.5) / 4 - 0.5;
      EXPECT_FLOAT_EQ(image->channels[0].values[y * 12 + x], static_cast<float>(1 + column + 3 * row));
    }
  }
}

struct PngFile {
  std::uint32_t width = 0, height = 0;
  std::vector<unsigned char> bytes;
  PageColor at(double x, double y) const {
    const unsigned char* const p =
        &bytes[3 * (static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x))];
    return {p[0], p[1], p[2]};
  }
};

PngFile read_png(const std::string& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&png, path.c_str()));
  png.format = PNG_FORMAT_RGB;
  PngFile file{png.width, png.height, std::vector<unsigned char>(PNG_IMAGE_SIZE(png))};
  EXPECT_TRUE(png_image_finish_read(&png, nullptr, file.bytes.data(), 0, nullptr));
  return file;
}

TEST(Plane, MapsHaveTheColoursOfTheirValues) {
  const support::TempDir directory;
  MeasuredMeter floor = floor_of(3, 2);
  floor.readings[5].figure.value = std::numeric_limits<double>::quiet_NaN();
  const Measured room = room_of({floor});
  const PlaneMapOptions options{.range = ValueRange{0, 5}, .isolines = false};
  const std::string path = directory / "floor.png";
  ASSERT_TRUE(write_plane_map(room, floor, floor.planes[0], options, path).ok());
  const PngFile png = read_png(path);
  const auto grid = grid_of(floor, floor.planes[0]);
  const FalseColorLayout layout =
      false_color_layout(*grid, false_color_of(room, floor, floor.planes[0], options));
  // A file has two pixels a point.
  EXPECT_EQ(png.width, 2 * std::ceil(layout.page_width));
  EXPECT_NEAR(layout.map.height / layout.map.width, 2.0 / 3, 1e-9) << "3 m x 2 m";
  for (std::size_t row = 0; row < 2; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      const double x = layout.map.x + (static_cast<double>(column) + 0.3) / 3 * layout.map.width,
                   y = layout.map.y + (static_cast<double>(row) + 0.3) / 2 * layout.map.height;
      const double value = grid->at(column, row);
      const PageColor expected = std::isnan(value) ? kMissingColor : map_color(ColorMap::kCividis, value / 5);
      EXPECT_EQ(png.at(2 * x, 2 * y), expected) << column << ", " << row;
    }
  }
}

TEST(Plane, SectionsHaveTheCellsOfTheirLine) {
  const MeasuredMeter floor = floor_of(3, 2);
  const AxesPlot plot = plane_section(room_of({floor}), floor, floor.planes[0], {0, 0.75, 1, 0.75});
  ASSERT_EQ(plot.points.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(plot.points[i].x, static_cast<double>(i) + 0.5) << "cells are 1 m wide";
    EXPECT_EQ(plot.points[i].y, static_cast<double>(i) + 4);
    EXPECT_NEAR(plot.points[i].high - plot.points[i].y, 0.125 * 1.9983, 0.125 * 1e-4);
  }
  const AxesPlot across = plane_section(room_of({floor}), floor, floor.planes[0], {0, 0, 1, 1});
  EXPECT_EQ(across.points.front().y, 1);
  EXPECT_EQ(across.points.back().y, 6);
}

TEST(Plane, HistogramsCountEveryCell) {
  const MeasuredMeter floor = floor_of(30, 20);
  const auto grid = grid_of(floor, floor.planes[0]);
  const AxesPlot plot = plane_histogram(floor, *grid, {});
  double cells = 0;
  for (const AxesPlot::Bar& bar : plot.bars) cells += bar.height;
  EXPECT_EQ(cells, 600);
  // Values are 1 to 600 over 0 to 600: bars of equal width have equally many, but for one at their ends.
  for (const AxesPlot::Bar& bar : plot.bars) EXPECT_NEAR(bar.height, bar.to - bar.from, 1 + 1e-9);
}

TEST(Plane, IsDrawnWhateverItsSizeAndValues) {
  const support::TempDir directory;
  int number = 0;
  for (const auto& [columns, rows] : {std::pair{1u, 1u}, {1u, 40u}, {300u, 1u}, {2u, 2u}}) {
    for (const double factor : {0.0, 1.0, -1.0, 1e-30, 1e30}) {
      MeasuredMeter floor = floor_of(columns, rows, 0);
      for (Reading& reading : floor.readings) reading.figure.value *= factor;
      for (const ScaleKind scale : {ScaleKind::kLinear, ScaleKind::kLogarithmic}) {
        const PlaneMapOptions options{.scale = scale, .smooth = scale == ScaleKind::kLinear};
        const std::string name = directory / ("map" + std::to_string(number++) + ".svg");
        EXPECT_TRUE(write_plane_map(room_of({floor}), floor, floor.planes[0], options, name).ok()) << name;
        const auto grid = grid_of(floor, floor.planes[0]);
        EXPECT_TRUE(write_axes_plot(plane_histogram(floor, *grid, options), directory / "h.svg").ok());
      }
    }
  }
  const MeasuredMeter floor = floor_of(2, 2);
  EXPECT_FALSE(write_plane_map(room_of({floor}), floor, floor.planes[0], {}, directory / "map.pdf").ok());
}

}  // namespace
}  // namespace tessera::client
