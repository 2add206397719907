// Scenes that other people made; skipped where they are absent.
#include <filesystem>

#include "support/needs.h"
#include "support/picture/unpacked_corpus.h"
#include "support/process/temp_dir.h"
#include "unit/import/mitsuba_fixture.h"

namespace tessera::client {
namespace {

TEST(MitsubaCorpus, TheSuitesScenesImportWithoutAWarning) {
  const auto suite = test::find_corpus("mitsuba-suite");
  if (!suite) GTEST_SKIP() << test::needs("../shared/scenes/mitsuba-suite.tar.xz");
  int scenes = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(suite->path() / "tests/scenes")) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("test_") || entry.path().extension() != ".xml") continue;
    ++scenes;
    const auto scene = import_scene(entry.path(), {.threads = 2, .defines = {{"spp", "8"}}});
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_TRUE(scene->warnings.empty()) << name << ": " << to_string(scene->warnings.front());
    EXPECT_EQ(scene->scene.settings().spp(), 8u) << name;
    EXPECT_GT(scene->scene.shapes_size() + scene->scene.instances_size(), 0) << name;
    EXPECT_GT(scene->blobs.size(), 0u) << name;
  }
  EXPECT_EQ(scenes, 21);
}

TEST(MitsubaCorpus, BothFormatsOfTheCornellBoxHaveTheSameWalls) {
  const std::filesystem::path folder = "../shared/scenes";
  if (!std::filesystem::exists(folder / "mitsuba/cornell-box/scene.xml"))
    GTEST_SKIP() << test::needs("../shared/scenes");
  const auto mitsuba = import_scene(folder / "mitsuba/cornell-box/scene.xml");
  const auto pbrt = import_scene(folder / "pbrt/cornell-box/scene.pbrt");
  ASSERT_TRUE(mitsuba.ok() && pbrt.ok()) << mitsuba.status() << pbrt.status();
  EXPECT_EQ(mitsuba->scene.shapes_size(), pbrt->scene.shapes_size());
  const auto colors = [](const v1::Scene& scene) {
    std::multiset<std::string> result;
    for (const v1::Material& m : scene.materials())
      result.insert(m.diffuse().reflectance().ShortDebugString());
    return result;
  };
  EXPECT_EQ(colors(mitsuba->scene), colors(pbrt->scene));
  EXPECT_EQ(mitsuba->scene.camera().perspective().fov_degrees(),
            pbrt->scene.camera().perspective().fov_degrees());
}

}  // namespace
}  // namespace tessera::client
