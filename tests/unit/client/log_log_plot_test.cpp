#include "plot/log_log_plot.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>

#include "unit/client/files.h"

namespace tessera::client {
namespace {

LogLogPlot plot_of(std::vector<PlotPoint> points) {
  return {.title = "Error over time",
          .subtitle = "4 to 64",
          .x_label = "seconds",
          .y_label = "error",
          .series = {{"room", std::move(points)}}};
}

TEST(Plot, WritesPngAndSvg) {
  const support::TempDir directory;
  const LogLogPlot plot = plot_of({{1, 0.1, 0.08, 0.12}, {10, 0.01, 0, 0}});
  ASSERT_TRUE(write_plot(plot, directory / "a.png").ok());
  ASSERT_TRUE(write_plot(plot, directory / "a.svg").ok());
  EXPECT_EQ(read_bytes(directory / "a.png").substr(1, 3), "PNG");
  const std::string svg = read_bytes(directory / "a.svg");
  EXPECT_NE(svg.find("<svg"), std::string::npos);
  EXPECT_NE(svg.find("</svg>"), std::string::npos) << "the file is whole";
  EXPECT_EQ(file_count(directory), 2u) << "no temporary file is left";
}

TEST(Plot, DrawsEverySeriesInAColourOfItsOwn) {
  const support::TempDir directory;
  LogLogPlot plot = plot_of({{1, 1, 0, 0}, {100, 0.001, 0, 0}});
  plot.series.push_back({"hall", {{1, 0.5, 0, 0}, {100, 0.0005, 0, 0}}});
  ASSERT_TRUE(write_plot(plot, directory / "a.png").ok());
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&png, (directory / "a.png").c_str()));
  EXPECT_EQ(png.width, 2400u);
  EXPECT_EQ(png.height, 1500u);
  png.format = PNG_FORMAT_RGB;
  std::vector<unsigned char> bytes(PNG_IMAGE_SIZE(png));
  ASSERT_TRUE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr));
  int blue = 0, orange = 0;
  for (std::size_t i = 0; i + 2 < bytes.size(); i += 3) {
    if (bytes[i] < 20 && bytes[i + 2] > 160 && bytes[i + 2] < 190) ++blue;
    if (bytes[i] > 200 && bytes[i + 2] < 20) ++orange;
  }
  EXPECT_GT(blue, 1000);
  EXPECT_GT(orange, 1000);
}

TEST(Plot, LeavesOutPointsThatNoLogarithmHas) {
  const support::TempDir directory;
  EXPECT_TRUE(
      write_plot(plot_of({{0, 1, 0, 0}, {1, -1, 0, 0}, {NAN, 1, 0, 0}, {2, 3, 0, 0}}), directory / "a.svg")
          .ok());
  EXPECT_FALSE(write_plot(plot_of({{0, 1, 0, 0}}), directory / "b.svg").ok()) << "nothing to plot";
  EXPECT_EQ(file_count(directory), 1u);
}

TEST(Plot, RefusesOtherKindsOfFiles) {
  EXPECT_FALSE(check_plot_path("a.pdf").ok());
  EXPECT_TRUE(check_plot_path("a.PNG").ok());
  EXPECT_FALSE(write_plot(plot_of({{1, 1, 0, 0}}), "/no/such/directory/a.png").ok());
}

}  // namespace
}  // namespace tessera::client
