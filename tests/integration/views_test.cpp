// One job, one scene, several cameras.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// first-light with a second and a third camera, below and above its own.
std::string with_views(const std::string& second, const std::string& third) {
  std::ifstream file("scenes/first-light/scene.textproto");
  std::string scene{std::istreambuf_iterator<char>(file), {}};
  const auto add = [&](const std::string& camera, const char* height) {
    scene += "views { " + camera + " world_from_camera { elements: [1, 0, 0, 0.2, 0, 1, 0, " + height +
             ", 0, 0, 1, -4, 0, 0, 0, 1] } }\n";
  };
  add(second, "0.5");
  add(third, "1.1");
  return scene;
}
constexpr const char* kPerspective = "perspective { fov_degrees: 50 lens_radius: 0.02 focal_distance: 4 }";
constexpr const char* kOrthographic = "orthographic {} screen_window: [-2, 2, -1.5, 1.5]";
constexpr const char* kSpherical = "spherical {}";

class Views : public testing::Test {
 protected:
  std::string write_scene(const std::string& text) const {
    const fs::path file = folder_.path() / "scene.textproto";
    std::ofstream{file} << text;
    return file.string();
  }
  std::string image(const char* name) const { return (folder_.path() / name).string(); }

  /// The pixels of each view of a job that has written `picture.exr`.
  std::vector<std::string> hashes_of_views() const {
    std::vector<std::string> hashes;
    for (const char* name : {"picture.exr", "picture.v1.exr", "picture.v2.exr"}) {
      hashes.push_back(pixel_sha256(image(name)));
      fs::remove(image(name));
    }
    return hashes;
  }
  /// The same, of three jobs of one view each.
  std::vector<std::string> hashes_one_by_one(const Arguments& job) const {
    std::vector<std::string> hashes;
    for (const char* view : {"0", "1", "2"}) {
      const support::Finished done =
          tessera(Arguments{"render"} + job + Arguments{"--view", view, "-o", image("one.exr")});
      EXPECT_EQ(done.status.code, 0) << done.err;
      hashes.push_back(pixel_sha256(image("one.exr")));
    }
    return hashes;
  }

  const support::TempDir folder_;
};

/// Tiles that share light among pixels, passes over a whole film, and samples that merge.
TEST_F(Views, AreThePicturesOfTheirCameras) {
  for (const char* integrator : {"path", "light", "vcm"}) {
    const std::string scene = write_scene(with_views(kPerspective, kSpherical));
    const Arguments job{scene, "--integrator", integrator, "--resolution", "40x30", "--spp", "4", "--quiet"};
    const std::vector<std::string> expected = hashes_one_by_one(job);
    EXPECT_EQ(std::set<std::string>(expected.begin(), expected.end()).size(), 3u);
    const support::Finished done =
        tessera(Arguments{"render"} + job + Arguments{"--threads", "3", "-o", image("picture.exr")});
    ASSERT_EQ(done.status.code, 0) << done.err;
    EXPECT_EQ(hashes_of_views(), expected) << integrator;
  }
}

TEST_F(Views, HaveTheSameBitsOnAFarmThatLosesAWorker) {
  const std::string scene = write_scene(with_views(kPerspective, kOrthographic));
  const Arguments job{scene, "--path-sharing", "off", "--resolution", "64x48", "--spp",
                      "256", "--tile",         "16",  "--quiet"};
  const std::vector<std::string> expected = hashes_one_by_one(job);
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(1);
  const std::string id = farm.submit_detached(job);
  farm.watch_until(id, &a_quarter_is_done);
  farm.kill_worker(0);
  EXPECT_EQ(farm.watch_to_the_end(id).state(), v1::DONE);
  const support::Finished done = tessera(farm.on_farm({"fetch", id, "--quiet", "-o", image("picture.exr")}));
  ASSERT_EQ(done.status.code, 0) << done.err;
  EXPECT_EQ(hashes_of_views(), expected);
}

TEST_F(Views, AreOneFileWhereThatIsWanted) {
  std::string scene = with_views(kPerspective, kOrthographic);
  scene += "views { view_name: 'top' perspective { fov_degrees: 50 } }\n";
  const Arguments job{"render", write_scene(scene), "--resolution", "40x30", "--spp", "4", "--quiet", "-o"};
  ASSERT_EQ(tessera(job + Arguments{image("apart.exr")}).status.code, 0);
  const support::Finished done = tessera(job + Arguments{image("all.exr"), "--multiview"});
  ASSERT_EQ(done.status.code, 0) << done.err;
  EXPECT_FALSE(fs::exists(image("all.v1.exr")));
  for (const auto& [name, file] :
       {std::pair{"v0", "apart.exr"}, {"v1", "apart.v1.exr"}, {"top", "apart.v3.exr"}}) {
    const support::Finished one =
        tessera({"convert", image("all.exr"), image("one.exr"), "--view-name", name});
    ASSERT_EQ(one.status.code, 0) << one.err;
    EXPECT_EQ(pixel_sha256(image("one.exr")), pixel_sha256(image(file))) << name;
  }
  const support::Finished missing =
      tessera({"compare", image("all.exr"), image("all.exr"), "--view-name", "left"});
  EXPECT_EQ(missing.status.code, 2);
  EXPECT_THAT(missing.err, HasSubstr("its views are v0, v1, v2, top"));
  const support::Finished png = tessera(job + Arguments{image("all.png"), "--multiview"});
  EXPECT_EQ(png.status.code, 2);
  EXPECT_THAT(png.err, HasSubstr("--multiview writes an .exr"));
}

TEST_F(Views, ThatCannotBeRenderedAreNamedBeforeAnythingIs) {
  std::string scene = write_scene(with_views(kPerspective, "fisheye { fov_degrees: 400 }"));
  const auto refused = [&](const Arguments& options) {
    return tessera(Arguments{"render", scene, "-o", image("picture.exr")} + options);
  };
  const support::Finished too_wide = refused({});
  EXPECT_EQ(too_wide.status.code, 3);
  EXPECT_THAT(too_wide.err, HasSubstr("scene.textproto:"));
  EXPECT_THAT(too_wide.err, HasSubstr("view 2: camera: a fisheye of mapping EQUIDISTANT cannot see"));
  scene = write_scene(with_views(kPerspective, kSpherical));
  const support::Finished missing = refused({"--view", "3"});
  EXPECT_EQ(missing.status.code, 2);
  EXPECT_THAT(missing.err, HasSubstr("there is no view 3: the scene has 3, and the first is view 0"));
  const support::Finished noise = refused({"--noise", "0.1"});
  EXPECT_EQ(noise.status.code, 2);
  EXPECT_THAT(noise.err, HasSubstr("the job has several"));
  EXPECT_EQ(refused({"--noise", "0.1", "--view", "1", "--resolution", "8x8", "--quiet"}).status.code, 0);
}

}  // namespace
}  // namespace tessera::integration
