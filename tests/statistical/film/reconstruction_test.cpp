// Samples that go into one pixel and samples that go into all pixels around have the same mean, pixel by
// pixel, and the latter less noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "support/long_form.h"
#include "support/picture/scene_file.h"

namespace tessera::test::reconstruction_test {
namespace {

constexpr std::uint32_t kSide = 16;
constexpr std::size_t kPixels = kSide * kSide;

/// Small squares of very different brightness, lit by lamps, before a sky: edges within nearly all pixels,
/// and some at the film's borders.
constexpr const char* kScene = R"(
  camera { perspective { fov_degrees: 40 }
    world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } }
  textures { name: 'tiles' checkerboard { mapping { scale_u: 9 scale_v: 7 } } }
  materials { name: 'm' diffuse { reflectance { texture: 'tiles' } } }
  lights { infinite { radiance { constant: 0.3 } } }
  lights { point { position { x: 3 y: 2 z: -3 } intensity { constant: 20 } } }
  shapes { sphere { radius: 1 } material: 'm' }
  shapes { disk { radius: 4 height: 1.5 } material: 'm' }
)";

struct Filter {
  const char* text;
  double least_gain;  // ratio of variances over the whole picture
};
// Half of what noise that knows nothing of the place gains: the square of the integral of |f|, which samples
// drawn from the filter have, over the integral of f^2 (tent of radius r: 2.25 r^2, Gaussian: 4 pi sigma^2).
// Here much of the noise is of edges.
constexpr Filter kFilters[] = {{"kind: TRIANGLE radius_x: 1 radius_y: 1", 1.12},
                               {"kind: TRIANGLE", 4.5},
                               {"kind: GAUSSIAN", 1.57},
                               {"kind: MITCHELL", 1.12},
                               {"kind: LANCZOS", 1.12}};

/// Means over renders of other seeds, of R and A of each pixel, and the variances of single renders.
struct Pixels {
  std::vector<double> mean = std::vector<double>(2 * kPixels), variance = mean;

  double noise() const {
    double sum = 0;
    for (std::size_t i = 0; i < kPixels; ++i) sum += variance[i];
    return sum / kPixels;
  }
};

Pixels measure(const std::string& filter, v1::Reconstruction reconstruction, const char* integrator,
               std::uint32_t samples, int renders) {
  SceneJob job;
  job.settings.set_integrator(integrator);
  job.settings.set_reconstruction(reconstruction);
  job.settings.set_spp(samples);
  job.settings.set_max_depth(2);
  const auto file = load_scene_text(
      absl::StrCat(kScene, "film { width: ", kSide, " height: ", kSide, " filter { ", filter, " } }"), job,
      render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  Pixels result;
  if (!file.ok()) return result;
  for (int i = 0; i < renders; ++i) {
    render::RenderStats stats;
    // Neither shares a seed with the other.
    const std::uint64_t seed = 2 * static_cast<std::uint64_t>(i) + reconstruction % 2;
    const auto tile = file->scene->render_tile({0, 0, kSide, kSide, 0, samples, seed}, {}, stats);
    EXPECT_TRUE(tile.ok()) << tile.status();
    if (!tile.ok()) break;
    for (std::size_t v = 0; v < 2 * kPixels; ++v) {
      const std::size_t channel = v < kPixels ? 0 : 3;
      const double value = tile->values[channel * kPixels + v % kPixels] / samples;
      const double step = value - result.mean[v];  // [Welford 1962]
      result.mean[v] += step / (i + 1);
      result.variance[v] += step * (value - result.mean[v]);
    }
  }
  for (double& variance : result.variance) variance /= renders - 1;
  return result;
}

void expect_same_means(const Pixels& a, const Pixels& b, int renders, std::uint32_t samples) {
  // Light that few samples find is not distributed normally. It is at most about 1, so that ten samples of it
  // are worth:
  const double rare = 10.0 / (renders * double{samples});
  double chi2 = 0;
  int tested = 0;
  for (std::size_t v = 0; v < 2 * kPixels; ++v) {
    const double error = std::sqrt((a.variance[v] + b.variance[v]) / renders);
    // One of 512 values is off by 5.5 standard errors once in 50,000 runs, whatever they have in common.
    EXPECT_NEAR(a.mean[v], b.mean[v], 5.5 * error + rare) << "value " << v;
    if (error < 1e-4 || std::min(a.mean[v], b.mean[v]) < rare) continue;
    chi2 += (a.mean[v] - b.mean[v]) * (a.mean[v] - b.mean[v]) / (error * error), ++tested;
  }
  // Neighbours have much in common: as many as the widest filter reaches are one at worst.
  EXPECT_NEAR(chi2 / tested, 1, 5 * std::sqrt(2.0 * 25 / tested));
}

TEST(Reconstruction, HasTheSameMeansEitherWayAndLessNoiseScattered) {
  const int renders = long_form() ? 8192 : 512;
  for (const Filter& filter : kFilters) {
    for (const std::uint32_t samples : {1u, 4u}) {
      SCOPED_TRACE(absl::StrCat(filter.text, ", samples: ", samples));
      const Pixels one = measure(filter.text, v1::RECONSTRUCTION_SAMPLE, "path", samples, renders);
      const Pixels all = measure(filter.text, v1::RECONSTRUCTION_SCATTER, "path", samples, renders);
      expect_same_means(one, all, renders, samples);
      RecordProperty(absl::StrCat("gain_", filter.text, "_", samples),
                     std::to_string(one.noise() / all.noise()));
      EXPECT_GT(one.noise() / all.noise(), filter.least_gain);
    }
  }
}

TEST(Reconstruction, IsTheSameForAllAlgorithmsThatLookThroughPixels) {
  const int renders = long_form() ? 4096 : 512;
  for (const char* integrator : {"volpath", "direct", "whitted", "raycast", "ao"}) {
    SCOPED_TRACE(integrator);
    const char* const filter = kFilters[2].text;
    expect_same_means(measure(filter, v1::RECONSTRUCTION_SAMPLE, integrator, 2, renders),
                      measure(filter, v1::RECONSTRUCTION_SCATTER, integrator, 2, renders), renders, 2);
  }
}

/// Where the filter reaches no other pixel there is nothing to scatter.
TEST(Reconstruction, BoxesKeepTheirBits) {
  SceneJob job;
  job.settings.set_spp(4);
  job.settings.set_max_depth(2);
  const auto scene = [&](v1::Reconstruction reconstruction) {
    job.settings.set_reconstruction(reconstruction);
    const auto file = load_scene_text(absl::StrCat(kScene, "film { width: ", kSide, " height: ", kSide, " }"),
                                      job, render::supported_isas().front());
    render::RenderStats stats;
    return file->scene->render_tile({0, 0, kSide, kSide, 0, 4}, {}, stats)->values;
  };
  EXPECT_EQ(scene(v1::RECONSTRUCTION_SAMPLE), scene(v1::RECONSTRUCTION_SCATTER));
}

TEST(Reconstruction, FiltersOfTooWideARadiusAreRefused) {
  SceneJob job;
  job.settings.set_reconstruction(v1::RECONSTRUCTION_SCATTER);
  const auto file = load_scene_text(
      absl::StrCat(kScene, "film { width: 16 height: 16 filter { kind: TRIANGLE radius_x: 17 } }"), job,
      render::supported_isas().front());
  EXPECT_EQ(file.status().message(),
            "film: the pixel filter's radius is 17; with reconstruction 'scatter' at most 16 was expected");
}

}  // namespace
}  // namespace tessera::test::reconstruction_test
