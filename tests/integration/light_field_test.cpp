// `tessera lightfield` as users have it: capture, look up, damage, repair.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const std::string kBoxToCapture = "scenes/cornell-box/scene.pbrt";

class LightFieldCommand : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  support::Finished capture(const std::string& set, const Arguments& more = {}) const {
    return tessera(Arguments{"lightfield", "capture", kBoxToCapture, "-o", path(set), "--grid", "3x3",
                             "--size", "16x16", "--spp", "4", "--tile", "16", "--quiet"} +
                   more);
  }

  static std::string text_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  const support::TempDir folder_;
};

TEST_F(LightFieldCommand, CapturesASetAndLooksPicturesUp) {
  const support::Finished captured = capture("box.lf");
  ASSERT_EQ(captured.status.code, 0) << captured.err;
  EXPECT_EQ(capture("box.lf").status.code, 2) << "a set is not written over";
  const support::Finished info = tessera({"lightfield", "info", path("box.lf")});
  EXPECT_THAT(info.out, HasSubstr("9 views of 16x16 pixels"));
  EXPECT_THAT(info.out, HasSubstr("grid plane: 3x3 cameras"));
  EXPECT_EQ(tessera({"lightfield", "check", path("box.lf")}).status.code, 0);
  // The scene's camera is at (0, 1, 6.8), and the middle one of the grid.
  const support::Finished seen = tessera({"lightfield", "view", path("box.lf"), "--at", "0,1,6.8", "--toward",
                                          "0,1,0", "--fov", "19", "-o", path("new.exr")});
  EXPECT_EQ(seen.status.code, 0) << seen.err;
  EXPECT_THAT(seen.err, HasSubstr("looked up 256 rays"));
  EXPECT_EQ(seen.err.find("warning"), std::string::npos) << seen.err;
  for (const Arguments& more :
       {Arguments{"--focus", "6.8"}, Arguments{"--all-in-focus", "--depth-from-focus"}}) {
    const support::Finished sharp =
        tessera(Arguments{"lightfield", "refocus", path("box.lf"), "-o", path("sharp.exr")} + more);
    EXPECT_EQ(sharp.status.code, 0) << sharp.err;
  }
  EXPECT_EQ(tessera({"lightfield", "export", path("box.lf"), "--quilt", "4x2", "-o", path("quilt.png")})
                .status.code,
            0);
  EXPECT_EQ(
      tessera({"lightfield", "export", path("box.lf"), "--multiview", "-o", path("all.exr")}).status.code, 0);
}

TEST_F(LightFieldCommand, AViewIsThePictureOfItsCamera) {
  ASSERT_EQ(capture("box.lf", {"--float"}).status.code, 0);
  ASSERT_EQ(capture("again.lf", {"--float", "--threads", "3"}).status.code, 0);
  EXPECT_EQ(text_of(path("box.lf") + "/manifest.json"), text_of(path("again.lf") + "/manifest.json"))
      << "the same bits, by their hashes";
}

TEST_F(LightFieldCommand, IsRepairedToTheBitsThatWereLost) {
  ASSERT_EQ(capture("box.lf").status.code, 0);
  const std::string manifest = text_of(path("box.lf") + "/manifest.json");
  std::vector<fs::path> files(fs::directory_iterator(path("box.lf") + "/data"), {});
  ASSERT_EQ(files.size(), 9u);
  fs::remove(files[0]);
  std::string bytes = text_of(files[1]);
  bytes[bytes.size() - 20] = static_cast<char>(bytes[bytes.size() - 20] ^ 1);
  fs::remove(files[1]);
  std::ofstream(files[1], std::ios::binary) << bytes;
  const support::Finished check = tessera({"lightfield", "check", path("box.lf")});
  EXPECT_EQ(check.status.code, 6);
  EXPECT_THAT(check.out, HasSubstr("its file is not there"));
  EXPECT_THAT(check.out, HasSubstr("tile 0,0: its hash is"));
  const support::Finished repaired = tessera({"lightfield", "repair", path("box.lf"), "--quiet"});
  EXPECT_EQ(repaired.status.code, 0) << repaired.err;
  EXPECT_THAT(repaired.err, HasSubstr("2 views were rendered again\n"));
  EXPECT_EQ(tessera({"lightfield", "check", path("box.lf")}).status.code, 0);
  EXPECT_EQ(text_of(path("box.lf") + "/manifest.json"), manifest);
}

TEST_F(LightFieldCommand, SaysBeforeItStartsWhatCannotBe) {
  const support::Finished large = tessera({"lightfield", "capture", kBoxToCapture, "-o", path("large.lf"),
                                           "--grid", "65x65", "--size", "16384x16384", "--quiet"});
  EXPECT_EQ(large.status.code, 2) << large.err;
  EXPECT_THAT(large.err, HasSubstr("would fit"));
  EXPECT_FALSE(fs::exists(path("large.lf")));
  const support::Finished cut = tessera({"lightfield", "capture", kBoxToCapture, "-o", path("cut.lf"),
                                         "--box", "-0.5,0.1,-0.5,0.5,1.5,0.5", "--grid", "2x2", "--quiet"});
  EXPECT_EQ(cut.status.code, 2) << cut.err;
  EXPECT_THAT(cut.err, HasSubstr("cuts "));
  EXPECT_THAT(cut.err, HasSubstr("scene.pbrt:108"));
  EXPECT_THAT(tessera({"lightfield", "view", path("none.lf"), "--at", "0,0,0", "-o", path("x.exr")}).err,
              HasSubstr("there is no light field at"));
}

TEST_F(LightFieldCommand, OnAFarmHasTheSameViews) {
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(1);
  const support::Finished there =
      tessera(farm.on_farm({"lightfield", "capture", kBoxToCapture, "-o", path("farm.lf"), "--grid", "2x2",
                            "--size", "16x16", "--spp", "4", "--farm", "--quiet"}));
  ASSERT_EQ(there.status.code, 0) << there.err;
  const support::Finished here = tessera({"lightfield", "capture", kBoxToCapture, "-o", path("here.lf"),
                                          "--grid", "2x2", "--size", "16x16", "--spp", "4", "--quiet"});
  ASSERT_EQ(here.status.code, 0) << here.err;
  EXPECT_EQ(text_of(path("farm.lf") + "/manifest.json"), text_of(path("here.lf") + "/manifest.json"));
}

}  // namespace
}  // namespace tessera::integration
