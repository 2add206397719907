#include "image/view/display_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "support/process/temp_dir.h"

namespace tessera::client {
namespace {

using spectra::Triple;
using testing::HasSubstr;

Triple shown(const DisplayView& view, Triple color) {
  view.show({&color, 1});
  return color;
}

std::unique_ptr<DisplayView> builtin(const std::string& name) {
  auto view = make_display_view({.name = name});
  EXPECT_TRUE(view.ok()) << view.status();
  return *std::move(view);
}

TEST(DisplayView, KeepsBlackAndOrder) {
  for (const std::string& name : builtin_views()) {
    const auto view = builtin(name);
    const Triple black = shown(*view, {0, 0, 0});
    double before = -1;
    for (double stops = -12; stops <= 20; stops += 0.25) {
      const double grey = std::exp2(stops);
      const Triple codes = shown(*view, {grey, grey, grey});
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(black[c], 0, 1e-6) << name;
        EXPECT_NEAR(codes[c], codes[0], 1e-3) << name << ": grey has no colour";
        EXPECT_LE(codes[c], 1) << name;
      }
      EXPECT_GE(codes[1], before) << name << " at " << stops << " stops";
      before = codes[1];
    }
    EXPECT_NEAR(before, 1, 2e-3) << name << ": what is bright enough is white";
  }
}

// By the formulas of the sources that display_view.h names, in double precision (NumPy).
TEST(DisplayView, CurvesHaveTheValuesOfTheirSources) {
  struct Sample {
    const char* view;
    Triple color, codes;  // codes of 255
  };
  const Sample samples[] = {{"aces", {0.18, 0.18, 0.18}, {91.407, 91.407, 91.406}},
                            {"aces", {1, 1, 1}, {206.283, 206.283, 206.282}},
                            {"aces", {8, 0.2, 0.05}, {255, 187.743, 118.578}},
                            {"agx", {0.18, 0.18, 0.18}, {128.471, 128.490, 128.491}},
                            {"agx", {1, 1, 1}, {202.068, 202.103, 202.105}},
                            {"agx", {8, 0.2, 0.05}, {255, 173.000, 158.702}},
                            {"srgb", {8, 0.5, -1}, {255, 187.516, 0}}};
  for (const Sample& sample : samples) {
    const Triple codes = shown(*builtin(sample.view), sample.color);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(255 * codes[c], sample.codes[c], 0.01) << sample.view << c;
  }
  // At one, the fit of Narkowicz is 2.54 / 3.16.
  EXPECT_NEAR(shown(*builtin("filmic"), {1, 1, 1})[0], srgb_encoded(2.54f / 3.16f), 1e-6);
}

TEST(DisplayView, TakesWhatIsNoColour) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinite = std::numeric_limits<double>::infinity();
  for (const std::string& name : builtin_views()) {
    for (const Triple& color : {Triple{nan, infinite, -infinite}, Triple{-1, -1, -1}}) {
      for (const double code : shown(*builtin(name), color)) {
        EXPECT_GE(code, 0) << name;
        EXPECT_LE(code, 1) << name;
      }
    }
  }
}

TEST(DisplayView, SaysWhichViewsThereAre) {
  EXPECT_THAT(std::string(make_display_view({.name = "agxx"}).status().message()),
              testing::AllOf(HasSubstr("there is no view \"agxx\" but srgb, filmic, aces, agx"),
                             HasSubstr("did you mean 'agx'?")));
}

class OcioView : public testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(path()) << R"(ocio_profile_version: 2
environment: {}
search_path: luts
roles:
  scene_linear: linear
  default: linear
displays:
  Screen:
    - !<View> {name: Plain, colorspace: screen}
    - !<View> {name: Raw, colorspace: linear}
  Projector:
    - !<View> {name: Plain, colorspace: linear}
active_displays: [Screen, Projector]
active_views: [Plain, Raw]
colorspaces:
  - !<ColorSpace>
    name: linear
  - !<ColorSpace>
    name: half
    to_scene_reference: !<MatrixTransform> {matrix: [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: screen
    from_scene_reference: !<ExponentTransform> {value: [0.5, 0.5, 0.5, 1]}
)";
  }

  std::string path() const { return (folder_.path() / "config.ocio").string(); }
  std::string fault(const ViewOptions& options) const {
    return std::string(make_display_view(options).status().message());
  }

  support::TempDir folder_;
};

TEST_F(OcioView, ShowsWhatTheConfigurationSays) {
  const auto view = make_display_view({.ocio_config = path()});
  ASSERT_TRUE(view.ok()) << view.status();
  EXPECT_FALSE((*view)->takes_rec709());
  std::vector<Triple> row = {{0.25, 0.04, 1}, {0.09, 0, 0.49}};
  (*view)->show(row);
  const Triple expected[] = {{0.5, 0.2, 1}, {0.3, 0, 0.7}};
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(row[i][c], expected[i][c], 1e-4);
  }
  const auto raw = make_display_view({.name = "Raw", .ocio_config = path(), .ocio_space = "half"});
  ASSERT_TRUE(raw.ok()) << raw.status();
  EXPECT_NEAR(shown(**raw, {0.25, 0.25, 0.25})[1], 0.5, 1e-6);
}

TEST_F(OcioView, SaysWhatIsNotThere) {
  EXPECT_THAT(fault({.name = "Film", .ocio_config = path()}),
              HasSubstr("display \"Screen\" has no view \"Film\": it has \"Plain\", \"Raw\""));
  EXPECT_THAT(fault({.ocio_config = path(), .ocio_display = "Tube"}),
              HasSubstr("there is no display \"Tube\": it has \"Screen\", \"Projector\""));
  EXPECT_THAT(fault({.ocio_config = path(), .ocio_space = "acescg"}),
              HasSubstr("there is no space or role \"acescg\": it has \"linear\", \"half\", \"screen\""));
  EXPECT_THAT(fault({.ocio_config = "/nowhere/config.ocio"}), HasSubstr("/nowhere/config.ocio"));
  std::ofstream(path()) << "ocio_profile_version: [";
  EXPECT_THAT(fault({.ocio_config = path()}), HasSubstr(path() + ": "));
}

}  // namespace
}  // namespace tessera::client
