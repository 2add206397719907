// Layers of a partition add up to the picture, on scenes that other people made.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "support/long_form.h"
#include "support/needs.h"
#include "support/picture/render_image.h"
#include "support/picture/unpacked_corpus.h"
#include "wire/algorithm.h"

namespace tessera::test::layers_of_the_corpus {
namespace {

struct CorpusScene {
  const char* folder;
  const char* file;
  bool small;  // rendered in the short form, too
};
const CorpusScene kScenes[] = {
    {"pbrt/cornell-box", "scene.pbrt", true},   {"mitsuba/cornell-box", "scene.xml", true},
    {"pbrt/veach-mis", "scene.pbrt", true},     {"pbrt/volumetric-caustic", "scene.pbrt", true},
    {"pbrt/classroom", "scene.pbrt", false},    {"pbrt/coffee", "scene.pbrt", false},
    {"pbrt/hair-curl", "scene.pbrt", false},    {"pbrt/staircase", "scene.pbrt", false},
    {"pbrt/water-caustic", "scene.pbrt", false}};

/// The number of events, the last of them, and the kind of light, one after the other.
const std::vector<std::vector<std::pair<const char*, const char*>>> kPartitions = {
    {{"bounce0", "LE"}, {"bounce1", "L.E"}, {"bounce2", "L.{2}E"}, {"more", "L.{3,}E"}},
    {{"seen", "LE"}, {"diffuse", "L.*DE"}, {"glossy", "L.*GE"}, {"specular", "L.*SE"}, {"volume", "L.*VE"}},
    {{"surfaces", "C.*O"}, {"sky", "C.*B"}, {"others", "C.*<[^OB].>"}}};

constexpr std::uint32_t kSide = 48, kSpp = 4;

/// Roundings of sums of light that is nowhere negative: of up to 12 events with some 8 lights that are found
/// at each (the lights of the sky, one that was sampled, media), of 4 samples, and of 5 layers.
constexpr double kRounding = 2 * (12 * 8 + 4 + 5) * 0x1p-24;
/// The same where a pixel has light of all vertices of a pass's light paths at most.
constexpr double kRoundingOfPasses = 2 * (kSide * kSide * 13 + 12 * 8 + 4 + 5) * 0x1p-24;

class CorpusLayers : public testing::TestWithParam<CorpusScene> {};

TEST_P(CorpusLayers, AddUpToThePicture) {
  const CorpusScene& scene = GetParam();
  if (!scene.small && !long_form()) GTEST_SKIP() << "long form only";
  const auto folder = find_corpus(scene.folder);
  if (!folder) GTEST_SKIP() << needs(absl::StrCat("../shared/scenes/", scene.folder));
  for (const char* integrator : {"volpath", "path", "whitted", "bdpt", "vcm", "photon"}) {
    // Whitted's algorithm asks all lights.
    if (!scene.small && std::string(integrator) == "whitted") continue;
    const bool passes = wire::find_algorithm(integrator)->work == wire::WorkKind::kPasses;
    const double rounding = passes ? kRoundingOfPasses : kRounding;
    SceneJob job;
    job.width = job.height = kSide;
    job.settings.set_integrator(integrator);
    job.settings.set_spp(kSpp);
    job.settings.set_max_depth(12);
    for (const auto& partition : kPartitions) {
      for (const auto& [name, expression] : partition) {
        v1::Layer& layer = *job.settings.add_layers();
        layer.set_name(name);
        layer.set_expression(expression);
      }
    }
    const auto file =
        load_scene_file((folder->path() / scene.file).string(), job, render::supported_isas().front(), 2);
    ASSERT_TRUE(file.ok()) << file.status();
    const client::Image image = render_image(*file);
    for (const char* band : {"R", "G", "B"}) {
      const std::vector<float>& whole = image.find(band)->values;
      for (const auto& partition : kPartitions) {
        std::vector<double> sum(whole.size());
        for (const auto& [name, expression] : partition) {
          const std::vector<float>& part = image.find(absl::StrCat(name, ".", band))->values;
          for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += part[i];
        }
        for (std::size_t i = 0; i < sum.size(); ++i) {
          ASSERT_NEAR(sum[i], whole[i], rounding * whole[i])
              << integrator << ", " << partition.back().second << ", " << band << " of pixel " << i;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, CorpusLayers, testing::ValuesIn(kScenes), [](const auto& scene) {
  std::string name = scene.param.folder;
  for (char& c : name) {
    if (c == '/' || c == '-') c = '_';
  }
  return name;
});

}  // namespace
}  // namespace tessera::test::layers_of_the_corpus
