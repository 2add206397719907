// All faults of a scene's elements at once, each with its element.
#include "render/scene/scene_faults.h"

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>

#include <map>

#include "wire/mesh_blob.h"

namespace tessera::render {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class SceneFaults : public testing::Test {
 protected:
  SceneFaults() {
    const std::vector<float> corners = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    add_blob("closed", {corners, {}, {}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}});
    add_blob("open", {corners, {}, {}, {0, 2, 1, 0, 1, 3, 1, 2, 3}});
    add_blob("doubled", {corners, {}, {}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2, 2, 3, 1}});
  }
  void add_blob(const std::string& digest, const wire::MeshData& mesh) {
    blobs_[digest] = std::make_shared<std::string>(wire::encode_mesh(mesh));
  }
  v1::Scene scene(const std::string& text) {
    v1::Scene scene;
    EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &scene)) << text;
    return scene;
  }
  std::vector<SceneFault> faults(const v1::Scene& scene, std::size_t most = 100) {
    return find_scene_faults(
        scene, nullptr,
        [this](const std::string& digest) -> absl::StatusOr<BlobBytes> {
          const auto& bytes = blobs_.at(digest);
          return BlobBytes{*bytes, bytes};
        },
        most);
  }

  std::map<std::string, std::shared_ptr<std::string>> blobs_;
};

struct Hostile {
  const char* shape;
  const char* message;
};
/// A shape each, and what is told of it.
constexpr Hostile kHostile[] = {
    {"torus { major_radius: 1 minor_radius: 2 }", "a torus wants"},
    {"box { low: [0, 0, 0] high: [1, 0, 1] }", "a box wants its high above its low"},
    {"polyhedron { planes: [1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, -1, 0, 0, 1] }", "leave it open"},
    {"polygon { corners: [0, 0, 0, 1, 0, 0, 1, 1, 1, 0, 1, 0] }", "do not lie in one plane"},
    {"sphere { radius: 1 } world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,1,1] }",
     "not affine"},
    {"sphere { radius: 1 } world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1] }", "singular"},
    {"implicit { expression: '3 - 1' ball { radius: 1 } }", "a constant, which has no surface"},
    {"implicit { expression: 'x + y' }", "needs bounds"},
    {"torus { major_radius: 1 minor_radius: 0.5 } area_light {}", "a torus cannot emit light"},
    {"csg { parts { solid { half_space {} } } parts { solid { half_space {} } } }", "no end that is known"},
    {"csg { operation: DIFFERENCE parts { begin {} } parts { end: true } }", "a group has no operands"},
};

TEST_F(SceneFaults, AreToldAllAtOnceInTheirOrder) {
  std::string text = "shapes { sphere { radius: 1 } }\n";
  for (const Hostile& one : kHostile) text += std::string("shapes { ") + one.shape + " }\n";
  text += "objects { name: 'lot' shapes { box { low: [0, 0, 0] high: [1, 1, 0] } } }\n";
  const v1::Scene all = scene(text);
  const std::vector<SceneFault> found = faults(all);
  ASSERT_EQ(found.size(), std::size(kHostile) + 1);
  for (std::size_t i = 0; i < std::size(kHostile); ++i) {
    EXPECT_EQ(found[i].element, &all.shapes(static_cast<int>(i) + 1)) << kHostile[i].shape;
    EXPECT_THAT(found[i].message, HasSubstr(kHostile[i].message));
  }
  EXPECT_EQ(found.back().element, &all.objects(0).shapes(0));
  EXPECT_THAT(found.back().place, HasSubstr("object 'lot', shape 0"));
  EXPECT_EQ(faults(all, 3).size(), 3);
}

TEST_F(SceneFaults, OfACombinationAreThoseOfItsOperands) {
  const v1::Scene all = scene(R"(shapes { csg {
      parts { solid { mesh { blob { digest: 'closed' } } } }
      parts { solid { mesh { blob { digest: 'open' } } name: 'lid' } }
      parts { solid { mesh { blob { digest: 'doubled' } } } }
      parts { solid { disk { radius: 1 } } }
      parts { solid { implicit { expression: '2' ball { radius: 1 } } } } } })");
  const std::vector<SceneFault> found = faults(all);
  ASSERT_EQ(found.size(), 4);
  const auto& parts = all.shapes(0).csg().parts();
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(found[static_cast<std::size_t>(i)].element, &parts[i + 1].solid()) << i;
  EXPECT_THAT(found[0].place, HasSubstr("operand 1 (lid)"));
  EXPECT_THAT(found[0].message, HasSubstr("not closed: 3 edges are open"));
  EXPECT_THAT(found[1].message, HasSubstr("triangle 5 is there twice, so that 3 edges have an odd number"));
  EXPECT_THAT(found[2].message, HasSubstr("a disk is not closed"));
  EXPECT_THAT(found[3].message, HasSubstr("a constant"));
}

TEST_F(SceneFaults, AreNoneOfSoundShapes) {
  EXPECT_THAT(faults(scene(R"(
      shapes { torus { major_radius: 1 minor_radius: 0.5 } }
      shapes { implicit { expression: 'x^2 + y^2 - z'
        box { low {x: -1 y: -1 z: -1} high {x: 1 y: 1 z: 1} } } }
      shapes { csg { parts { solid { mesh { blob { digest: 'closed' } } } }
        parts { solid { implicit { expression: 'sin(9*x) + y' ball { radius: 1 } } } } } })")),
              IsEmpty());
}

}  // namespace
}  // namespace tessera::render
