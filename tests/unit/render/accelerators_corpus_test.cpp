// One picture, whatever rays search, of scenes that other people made.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "support/long_form.h"
#include "support/needs.h"
#include "support/picture/render_image.h"
#include "support/picture/unpacked_corpus.h"
#include "wire/enum_words.h"

namespace tessera::test::accelerators_of_the_corpus {
namespace {

struct CorpusScene {
  const char* folder;
  const char* file;
  bool small;  // rendered in the short form, too
  bool curves = false;
};
const CorpusScene kScenes[] = {
    {"pbrt/cornell-box", "scene.pbrt", true},     {"mitsuba/cornell-box", "scene.xml", true},
    {"pbrt/veach-mis", "scene.pbrt", true},       {"pbrt/volumetric-caustic", "scene.pbrt", true},
    {"pbrt/classroom", "scene.pbrt", false},      {"pbrt/coffee", "scene.pbrt", false},
    {"pbrt/staircase", "scene.pbrt", false},      {"pbrt/water-caustic", "scene.pbrt", false},
    {"pbrt/hair-curl", "scene.pbrt", false, true}};

/// Light of paths, what their first rays meet and where: another nearest hit, or another answer to a shadow
/// ray, and bits differ.
struct Picture {
  absl::Status status;
  std::string bits;
};
Picture picture(const CorpusFolder& folder, const CorpusScene& scene, v1::Accelerator accelerator,
                v1::Traversal traversal, std::uint32_t side, std::uint32_t spp) {
  SceneJob job;
  job.width = job.height = side;
  job.settings.set_integrator("volpath");
  job.settings.set_spp(spp);
  job.settings.set_max_depth(4);
  job.settings.set_accelerator(accelerator);
  job.settings.set_traversal(traversal);
  job.aovs = {v1::AOV_DEPTH, v1::AOV_ID};
  const auto file =
      load_scene_file((folder.path() / scene.file).string(), job, render::supported_isas().front(), 2);
  if (!file.ok()) return {file.status(), ""};
  const client::Image image = render_image(*file);
  Picture result;
  for (const client::Channel& channel : image.channels) {
    result.bits.append(reinterpret_cast<const char*>(channel.values.data()),
                       channel.values.size() * sizeof(channel.values[0]));
  }
  return result;
}

class CorpusAccelerators : public testing::TestWithParam<CorpusScene> {};

TEST_P(CorpusAccelerators, AllGiveTheSameBits) {
  const CorpusScene& scene = GetParam();
  if (!scene.small && !long_form()) GTEST_SKIP() << "long form only";
  const auto folder = find_corpus(scene.folder);
  if (!folder) GTEST_SKIP() << needs(absl::StrCat("../shared/scenes/", scene.folder));
  if (scene.curves) {
    const absl::Status refused =
        picture(*folder, scene, v1::ACCELERATOR_BVH_SAH, v1::TRAVERSAL_PACKET, 8, 1).status;
    EXPECT_NE(refused.message().find("met by accelerator 'embree' alone"), std::string::npos) << refused;
    return;
  }
  // Few rays are held against all primitives, more against the tree that is walked as it is read.
  for (const v1::Accelerator judge : {v1::ACCELERATOR_BRUTE, v1::ACCELERATOR_BVH_SAH}) {
    const std::uint32_t side = judge == v1::ACCELERATOR_BRUTE ? 12 : 48;
    const std::uint32_t spp = judge == v1::ACCELERATOR_BRUTE ? 1 : 4;
    if (judge != v1::ACCELERATOR_BRUTE && !long_form()) continue;
    const Picture expected = picture(*folder, scene, judge, v1::TRAVERSAL_SINGLE, side, spp);
    ASSERT_TRUE(expected.status.ok()) << expected.status;
    ASSERT_GE(expected.bits.size(), std::size_t{4 * 7} * side * side);
    for (int a = v1::ACCELERATOR_BRUTE + 1; a <= v1::Accelerator_MAX; ++a) {
      const auto accelerator = static_cast<v1::Accelerator>(a);
      for (const v1::Traversal traversal : {v1::TRAVERSAL_PACKET, v1::TRAVERSAL_SINGLE}) {
        const Picture found = picture(*folder, scene, accelerator, traversal, side, spp);
        EXPECT_TRUE(found.status.ok() && found.bits == expected.bits)
            << wire::word_of(accelerator) << ", " << wire::word_of(traversal) << " " << found.status;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, CorpusAccelerators, testing::ValuesIn(kScenes), [](const auto& scene) {
  std::string name = absl::StrCat(scene.param.folder);
  for (char& c : name) c = c == '/' || c == '-' ? '_' : c;
  return name;
});

}  // namespace
}  // namespace tessera::test::accelerators_of_the_corpus
