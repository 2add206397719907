// The item buffer: numbers of shapes and instances in the order of the scene, whatever finds them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "image/image.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"
#include "wire/algorithm.h"

namespace tessera::test::item_buffer {
namespace {

using testing::ElementsAre;

constexpr std::uint32_t kSide = 32;

/// A wall that is left out (no surface), one behind all, and on it four disks: a shape, one of two shapes of
/// an object placed twice, the other, and a shape that moves.
std::string scene() {
  const auto at = [](double x, double y, double z) {
    return absl::StrCat("{ elements: [1,0,0,", x, ", 0,1,0,", y, ", 0,0,1,", z, ", 0,0,0,1] }");
  };
  return absl::StrCat("camera { orthographic {} } film { width: 32 height: 32 filter { kind: BOX } }",
                      "lights { infinite { radiance { constant: 1 } } }",
                      "shapes { name: 'wall' disk { radius: 9 } world_from_object ", at(0, 0, 5), " }",
                      "shapes { name: 'mover' disk { radius: 0.4 } world_from_object ", at(0.5, -0.5, 3),
                      " world_from_object_end ", at(0.55, -0.5, 3), " }",
                      "shapes { name: 'coin' disk { radius: 0.4 } world_from_object ", at(-0.5, 0.5, 3), " }",
                      "objects { name: 'unused' shapes { sphere { radius: 1 } } }",
                      "objects { name: 'pair' shapes { name: 'near' disk { radius: 0.2 } world_from_object ",
                      at(0, 0, -0.1), " } shapes { name: 'far' disk { radius: 0.4 } } }",
                      "instances { object: 'pair' world_from_instance ", at(0.5, 0.5, 3), " }",
                      "instances { object: 'pair' world_from_instance ", at(-0.5, -0.5, 3), " }");
}

absl::StatusOr<LoadedFile> load(const std::string& text, const std::string& integrator, std::uint32_t spp) {
  SceneJob job;
  job.settings.set_integrator(integrator);
  job.settings.set_spp(spp);
  job.aovs = {v1::AOV_DEPTH, v1::AOV_ID};
  return load_scene_text(text, job, render::supported_isas().front());
}

/// Shape and instance at a place of [-1, 1]^2, y up.
std::pair<float, float> item_at(const client::Image& image, double x, double y) {
  const auto column = static_cast<std::size_t>((x + 1) / 2 * kSide),
             row = static_cast<std::size_t>((1 - y) / 2 * kSide);
  const std::size_t i = row * kSide + column;
  return {image.find("id.shape")->values[i], image.find("id.instance")->values[i]};
}

TEST(ItemBuffer, ShapesHaveTheirNumbersWhateverTheAlgorithm) {
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms()) {
    if (!algorithm.first_hit_aovs || !algorithm.phases.empty()) continue;
    for (const std::uint32_t spp : {1u, 7u}) {
      SCOPED_TRACE(absl::StrCat(algorithm.name, " of ", spp));
      const auto file = load(scene(), algorithm.name, spp);
      ASSERT_TRUE(file.ok()) << file.status();
      const client::Image image = render_image(*file);
      ASSERT_NE(image.find("id.shape"), nullptr);
      using Item = std::pair<float, float>;
      EXPECT_EQ(item_at(image, 0, 0), Item(1, 0)) << "wall";
      EXPECT_EQ(item_at(image, 0.5, -0.5), Item(2, 0)) << "mover";
      EXPECT_EQ(item_at(image, -0.5, 0.5), Item(3, 0)) << "coin";
      // 4 is the shape that no instance places.
      EXPECT_EQ(item_at(image, 0.5, 0.5), Item(5, 1)) << "near";
      EXPECT_EQ(item_at(image, 0.78, 0.5), Item(6, 1)) << "far";
      EXPECT_EQ(item_at(image, -0.5, -0.5), Item(5, 2)) << "near, second";
      // No mean of numbers anywhere: at edges, too, they are those of a sample.
      const std::set<float> all(image.find("id.shape")->values.begin(), image.find("id.shape")->values.end());
      EXPECT_THAT(all, ElementsAre(1, 2, 3, 5, 6));
    }
  }
}

TEST(ItemBuffer, NothingHasNumberZero) {
  const auto file = load(
      "camera { orthographic {} } film { width: 32 height: 32 } shapes { sphere { radius: 0.5 } "
      "world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,5, 0,0,0,1] } }",
      "raycast", 4);
  ASSERT_TRUE(file.ok()) << file.status();
  const client::Image image = render_image(*file);
  EXPECT_EQ(item_at(image, 0, 0).first, 1);
  EXPECT_EQ(item_at(image, 0.9, 0.9).first, 0);
}

}  // namespace
}  // namespace tessera::test::item_buffer
