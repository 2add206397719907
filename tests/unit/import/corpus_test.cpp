// The public scenes of the shared corpus, against the counts that come with them.
#include <map>
#include <set>

#include "support/needs.h"
#include "support/picture/unpacked_corpus.h"
#include "unit/import/import_fixture.h"

namespace tessera::client {
namespace {

struct CorpusScene {
  const char* name;
  std::size_t triangles;
  int shapes;
  std::size_t warnings;
};

void PrintTo(const CorpusScene& scene, std::ostream* out) { *out << scene.name; }

class Corpus : public testing::TestWithParam<CorpusScene> {};

TEST_P(Corpus, ImportsWithTheKnownCounts) {
  const CorpusScene& expected = GetParam();
  const auto folder = test::find_corpus(std::string("pbrt/") + expected.name);
  if (!folder) GTEST_SKIP() << test::needs(std::string("../shared/scenes/pbrt/") + expected.name);
  for (const char* view : {"scene.pbrt", "scene-bench.pbrt"}) {
    const auto scene = import_scene(folder->path() / view);
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_EQ(scene->scene.shapes_size(), expected.shapes);
    std::set<std::string> meshes;
    for (const v1::Shape& shape : scene->scene.shapes()) meshes.insert(shape.mesh().blob().digest());
    std::map<std::string, std::size_t> triangles_of_blob;
    for (const SceneBlob& blob : scene->blobs) {
      if (!meshes.contains(blob.ref.digest())) continue;
      const auto mesh = wire::decode_mesh(blob.bytes);
      ASSERT_TRUE(mesh.ok()) << mesh.status();
      triangles_of_blob[blob.ref.digest()] = mesh->triangle_count();
    }
    std::size_t triangles = 0;
    for (const v1::Shape& shape : scene->scene.shapes())
      triangles += triangles_of_blob[shape.mesh().blob().digest()];
    EXPECT_EQ(triangles, expected.triangles);
    EXPECT_EQ(scene->warnings.size(), expected.warnings);
  }
}

// From the table of ../shared/scenes/SOURCES.md; the one shape of hair-curl is a curve.
INSTANTIATE_TEST_SUITE_P(
    Pbrt, Corpus,
    testing::Values(CorpusScene{"cornell-box", 36, 8, 0}, CorpusScene{"veach-mis", 52, 9, 0},
                    CorpusScene{"coffee", 235271, 23, 0}, CorpusScene{"classroom", 103832, 79, 0},
                    CorpusScene{"water-caustic", 103487, 10, 0}, CorpusScene{"volumetric-caustic", 14, 8, 0},
                    CorpusScene{"staircase", 262663, 775, 0}, CorpusScene{"hair-curl", 0, 1, 0}));

}  // namespace
}  // namespace tessera::client
