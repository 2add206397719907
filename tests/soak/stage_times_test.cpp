// Where the time of rendering goes.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "base/cpu_time.h"
#include "support/picture/scene_file.h"

namespace tessera::test {
namespace {

constexpr const char* kCornellBox = "scenes/cornell-box/scene.pbrt";

absl::StatusOr<LoadedFile> load(std::uint64_t seed, const std::string& integrator = "path") {
  test::SceneJob job;
  job.width = 64, job.height = 64;
  job.settings.set_seed(seed);
  job.settings.set_integrator(integrator);
  return load_scene_file(kCornellBox, job, render::supported_isas().front(), 1);
}

TEST(StageTimes, AddUpToTheCpuTime) {
  for (const char* integrator : {"path", "volpath", "light"}) {
    const auto file = load(1, integrator);
    ASSERT_TRUE(file.ok()) << file.status();
    // The counter goes on while the thread waits for a processor: one long wait between two stages looks like
    // time that no stage has. It will not be there every time.
    double best = 0;
    for (int attempt = 0; attempt < 6 && best < 0.9; ++attempt) {
      render::RenderStats stats;
      const auto start = base::thread_cpu_time();
      ASSERT_TRUE(file->scene->render_tile({0, 0, 64, 64, 0, 64}, {}, stats).ok());
      const auto spent = static_cast<double>((base::thread_cpu_time() - start).count());
      const auto sum = static_cast<double>(
          std::accumulate(stats.times.stages.begin(), stats.times.stages.end(), std::uint64_t{0}));
      EXPECT_LE(sum, 1.001 * spent) << integrator;
      best = std::max(best, sum / spent);
    }
    EXPECT_GE(best, 0.9) << integrator;
  }
}

TEST(StageTimes, PartsOfShadingNameMaterials) {
  const auto file = load(1);
  ASSERT_TRUE(file.ok()) << file.status();
  render::RenderStats stats;
  ASSERT_TRUE(file->scene->render_tile({0, 0, 64, 64, 0, 64}, {}, stats).ok());  // 256 batches
  const auto& parts = stats.times.shading_parts;
  const auto looked_into = std::accumulate(parts.begin(), parts.end(), std::uint64_t{0});
  EXPECT_GT(looked_into, 0u);
  EXPECT_LT(looked_into, stats.times.stages[static_cast<std::size_t>(render::Stage::kShading)] / 4)
      << "one batch in 17";
  const std::uint64_t materials =
      std::accumulate(stats.times.materials.begin(), stats.times.materials.end(), std::uint64_t{0});
  const std::uint64_t part = parts[static_cast<std::size_t>(render::ShadingPart::kMaterials)];
  EXPECT_LE(materials, part);
  EXPECT_GE(materials, part / 2);
  EXPECT_EQ(file->scene->material_names().size(), stats.times.materials.size());
}

}  // namespace
}  // namespace tessera::test
