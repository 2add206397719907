// The public glTF files of the shared corpus.
#include <set>

#include "support/needs.h"
#include "support/picture/unpacked_corpus.h"
#include "unit/import/import_fixture.h"

namespace tessera::client {
namespace {

TEST(GltfCorpus, IsReadButForTheFileThatAsksForALaterVersion) {
  std::set<std::string> refused;
  int count = 0;
  for (const char* name : {"asset-generator", "dragon-transmission", "gltf-pipeline", "gltf-transform",
                           "house-v2", "material-ball", "nvpro", "ring", "tinygltf", "vase"}) {
    const auto folder = test::find_corpus(std::string("gltf/") + name);
    if (!folder) GTEST_SKIP() << test::needs(std::string("../shared/scenes/gltf/") + name);
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder->path())) {
      const std::filesystem::path& path = entry.path();
      if (path.extension() != ".gltf" && path.extension() != ".glb") continue;
      ++count;
      if (!import_scene(path, {.threads = 1, .defines = {}, .gltf = {}}).ok())
        refused.insert(path.filename());
    }
  }
  EXPECT_EQ(count, 69);
  EXPECT_THAT(refused, testing::ElementsAre("Compatibility_04.gltf"));
}

}  // namespace
}  // namespace tessera::client
