// How close the renderer comes to Embree tracing the same rays with no shading at all.
//
//   ceiling_bench [--spp N] [--isa NAME] [--repeat N] SCENE...
//
// Prints, for every scene, CPU seconds and million rays a second on one thread, of rendering and of replaying the
// recorded rays, and their ratio. Rendering and replaying alternate tile by tile, so that a machine whose speed
// drifts slows both alike; of the repetitions, the median ratio is printed.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "render/renderer.h"
#include "support/scene_file.h"

namespace {

struct Total {
  double render = 0, replay = 0;
  double rays = 0;
};

Total measure(const tessera::test::LoadedFile& file, std::uint32_t spp) {
  constexpr std::uint32_t kTile = 32;
  Total total;
  for (std::uint32_t y = 0; y < file.job.height(); y += kTile) {
    for (std::uint32_t x = 0; x < file.job.width(); x += kTile) {
      const auto ceiling = file.scene->measure_ceiling(
          {x, y, std::min(x + kTile, file.job.width()), std::min(y + kTile, file.job.height()), 0, spp});
      total.render += ceiling.render_cpu_seconds;
      total.replay += ceiling.replay_cpu_seconds;
      total.rays += static_cast<double>(ceiling.stats.camera_rays + ceiling.stats.bounce_rays + ceiling.stats.shadow_rays);
    }
  }
  return total;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint32_t spp = 4;
  int repeat = 3;
  std::string isa = tessera::render::supported_isas().front();
  std::vector<std::string> scenes;
  for (int i = 1; i < argc; ++i) {
    const std::string arg = argv[i];
    if (arg == "--spp" && i + 1 < argc) {
      spp = static_cast<std::uint32_t>(std::atoi(argv[++i]));
    } else if (arg == "--isa" && i + 1 < argc) {
      isa = argv[++i];
    } else if (arg == "--repeat" && i + 1 < argc) {
      repeat = std::atoi(argv[++i]);
    } else {
      scenes.push_back(arg);
    }
  }
  std::printf("%-40s %10s %10s %10s %10s %8s\n", "scene", "render s", "replay s", "Mray/s", "ceiling", "ratio");
  for (const std::string& path : scenes) {
    const auto file = tessera::test::load_scene_file(path, {}, isa, 2);
    if (!file.ok()) {
      std::fprintf(stderr, "%s\n", file.status().ToString().c_str());
      return 3;
    }
    std::vector<Total> runs;
    for (int i = 0; i < repeat; ++i) runs.push_back(measure(*file, spp));
    std::sort(runs.begin(), runs.end(), [](const Total& a, const Total& b) { return a.replay / a.render < b.replay / b.render; });
    const Total& t = runs[runs.size() / 2];
    std::printf("%-40s %10.3f %10.3f %10.3f %10.3f %7.1f%%\n", path.c_str(), t.render, t.replay, t.rays / t.render * 1e-6,
                t.rays / t.replay * 1e-6, 100 * t.replay / t.render);
    std::fflush(stdout);
  }
  return 0;
}
