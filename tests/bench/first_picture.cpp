// Time to the first picture of scenes: of `preview`, with its shadow maps made anew, and of `raycast`, both
// with one sample a pixel, after the scene is loaded. Run by hand (CONTRIBUTING: measuring).
//
//   first_picture THREADS [--png FOLDER] SCENE...
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "base/cpu_time.h"
#include "image/png.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"

namespace tessera::test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kTile = 64;
constexpr int kRuns = 3;

struct Times {
  double wall_ms = 0, cpu_ms = 0;
  render::RenderStats stats;
};

Times render_all(const LoadedFile& file, int threads) {
  const std::uint32_t width = file.job.view().width(), height = file.job.view().height();
  const std::uint32_t columns = (width + kTile - 1) / kTile, rows = (height + kTile - 1) / kTile;
  Times times;
  std::mutex mutex;
  std::atomic<std::uint32_t> next{0};
  const auto cpu_start = base::process_cpu_time();
  const auto start = Clock::now();
  {
    std::vector<std::jthread> workers;
    for (int t = 0; t < threads; ++t) {
      workers.emplace_back([&] {
        render::RenderStats own;
        for (std::uint32_t i; (i = next.fetch_add(1)) < columns * rows;) {
          const std::uint32_t x = i % columns * kTile, y = i / columns * kTile;
          const auto tile = file.scene->render_tile(
              {x, y, std::min(x + kTile, width), std::min(y + kTile, height), 0, 1}, {}, own);
          if (!tile.ok()) std::printf("%s\n", std::string(tile.status().message()).c_str());
        }
        const std::lock_guard lock(mutex);
        times.stats += own;
      });
    }
  }
  times.wall_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  times.cpu_ms = 1e3 * base::in_seconds(base::process_cpu_time() - cpu_start);
  return times;
}

void measure(const std::string& path, const std::string& integrator, v1::Shadows shadows, int threads,
             const std::string& png_folder) {
  SceneJob job;
  job.settings.set_integrator(integrator);
  job.settings.set_spp(1);
  job.settings.mutable_preview()->set_shadows(shadows);
  for (int run = 0; run < kRuns; ++run) {
    // A scene makes its shadow maps once, so each run loads it again.
    const auto file = load_scene_file(path, job, render::supported_isas().front(), threads);
    if (!file.ok()) {
      std::printf("%s: %s\n", path.c_str(), std::string(file.status().message()).c_str());
      return;
    }
    const Times times = render_all(*file, threads);
    std::printf("%s %s %s: %u x %u, %.1f ms, %.1f ms of CPU (", path.c_str(), integrator.c_str(),
                v1::Shadows_Name(shadows).c_str(), file->job.view().width(), file->job.view().height(),
                times.wall_ms, times.cpu_ms);
    for (std::size_t i = 0; i < times.stats.times.stages.size(); ++i)
      std::printf(" %s %.1f", render::kStageNames[i], 1e-6 * times.stats.times.stages[i]);
    std::printf(")\n");
    std::fflush(stdout);
    if (run > 0 || png_folder.empty()) continue;
    const std::string name = std::filesystem::absolute(path).parent_path().filename().string() + "-" +
                             std::filesystem::path(path).stem().string() + "-" + integrator + "-" +
                             v1::Shadows_Name(shadows) + ".png";
    if (const auto s = client::write_png(render_image(*file), png_folder + "/" + name); !s.ok())
      std::printf("%s\n", std::string(s.message()).c_str());
  }
}

}  // namespace
}  // namespace tessera::test

int main(int argc, char** argv) {
  using namespace tessera;
  if (argc < 3) return 2;
  int i = 2;
  std::string png_folder;
  if (std::string(argv[i]) == "--png") png_folder = argv[i + 1], i += 2;
  for (; i < argc; ++i) {
    const int threads = std::atoi(argv[1]);
    for (const v1::Shadows shadows : {v1::SHADOWS_NONE, v1::SHADOWS_HARD, v1::SHADOWS_PCF, v1::SHADOWS_PCSS})
      test::measure(argv[i], "preview", shadows, threads, png_folder);
    test::measure(argv[i], "raycast", v1::SHADOWS_UNSPECIFIED, threads, png_folder);
  }
  return 0;
}
