// Images of other seeds on one scene.
#include <gtest/gtest.h>

#include "support/picture/scene_file.h"

namespace tessera::test {
namespace {

absl::StatusOr<LoadedFile> cornell_box(std::uint64_t seed) {
  SceneJob job;
  job.width = 64, job.height = 64;
  job.settings.set_seed(seed);
  return load_scene_file("scenes/cornell-box/scene.pbrt", job, render::supported_isas().front(), 1);
}

TEST(SeedOffset, GivesTheImageOfThatSeed) {
  const auto file = cornell_box(5), other = cornell_box(12);
  ASSERT_TRUE(file.ok() && other.ok());
  render::RenderStats stats;
  const auto shifted = file->scene->render_tile({0, 0, 64, 64, 0, 4, 7}, {}, stats);
  const auto direct = other->scene->render_tile({0, 0, 64, 64, 0, 4}, {}, stats);
  const auto own = file->scene->render_tile({0, 0, 64, 64, 0, 4}, {}, stats);
  ASSERT_TRUE(shifted.ok() && direct.ok() && own.ok());
  EXPECT_EQ(shifted->values, direct->values);
  EXPECT_NE(shifted->values, own->values);
}

}  // namespace
}  // namespace tessera::test
