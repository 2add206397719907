// The AOV `halves`: means over the first half of the samples, whatever the algorithm.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "image/image.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"
#include "wire/algorithm.h"

namespace tessera::test::halves {
namespace {

constexpr const char* kScene =
    "camera { perspective { fov_degrees: 60 } } film { width: 24 height: 24 filter { kind: TRIANGLE } }"
    "lights { infinite { radiance { constant: 1 } } }"
    "shapes { disk { radius: 9 } world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,5, 0,0,0,1] } }"
    "shapes { sphere { radius: 1 } world_from_object { elements: [1,0,0,0.3, 0,1,0,0, 0,0,1,4, 0,0,0,1] } }";

client::Image render(const wire::AlgorithmTraits& algorithm, v1::Reconstruction reconstruction,
                     std::uint32_t spp) {
  SceneJob job;
  job.settings.set_integrator(algorithm.name);
  job.settings.set_reconstruction(reconstruction);
  job.settings.set_spp(spp);
  job.aovs = {v1::AOV_HALVES};
  if (algorithm.first_hit_aovs) job.aovs = {v1::AOV_ALBEDO, v1::AOV_NORMAL, v1::AOV_DEPTH, v1::AOV_HALVES};
  const auto file = load_scene_text(kScene, job, render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? render_image(*file) : client::Image{};
}

/// With two samples, the first half is the first one: the picture of one sample, which is its own first half.
void expect_first_sample(const wire::AlgorithmTraits& algorithm, v1::Reconstruction reconstruction) {
  const client::Image one = render(algorithm, reconstruction, 1), two = render(algorithm, reconstruction, 2);
  bool differ = false;
  for (const client::Channel& half : two.channels) {
    if (!half.name.starts_with("half.")) continue;
    const std::string whole = half.name.substr(5);
    ASSERT_NE(one.find(whole), nullptr) << whole;
    EXPECT_EQ(half.values, one.find(whole)->values) << half.name;
    differ = differ || half.values != two.find(whole)->values;
  }
  ASSERT_NE(two.find("half.R"), nullptr);
  EXPECT_EQ(two.find("half.depth.Z") != nullptr, algorithm.first_hit_aovs);
  EXPECT_TRUE(differ) << "both halves are alike: the test says nothing";
}

TEST(HalvesAov, AreTheFirstSamplesOfEveryAlgorithm) {
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms()) {
    if (!algorithm.phases.empty()) continue;
    SCOPED_TRACE(algorithm.name);
    expect_first_sample(algorithm, v1::RECONSTRUCTION_SAMPLE);
    if (algorithm.scatters) expect_first_sample(algorithm, v1::RECONSTRUCTION_SCATTER);
  }
}

}  // namespace
}  // namespace tessera::test::halves
