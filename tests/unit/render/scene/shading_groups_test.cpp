// Which shapes are shaded together.
#include "render/scene/shape/shading_groups.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::render {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class GroupForShading : public testing::Test {
 protected:
  GroupForShading() {
    arrays_.materials.materials.resize(3);
    arrays_.materials.materials[1].kind = BsdfKind::kHair;
    for (const int material : {1, 0, 2, 0}) {
      arrays_.shapes.shapes.emplace_back().material = material;
    }
  }
  void group() { group_for_shading(arrays_.shapes, arrays_.materials, tables_); }

  SceneArrays arrays_;
  SceneTables tables_{arrays_};
};

TEST_F(GroupForShading, PutsShapesOfOneMaterialTogether) {
  group();
  EXPECT_EQ(tables_.shading_groups, 3);
  EXPECT_THAT(tables_.shading_group, ElementsAre(2, 0, 1, 0));
}

TEST_F(GroupForShading, DoesNothingWhereAllAreOfOneKind) {
  arrays_.materials.materials[1].kind = BsdfKind::kDiffuse;
  group();
  EXPECT_EQ(tables_.shading_groups, 0);
  EXPECT_THAT(tables_.shading_group, IsEmpty());
}

TEST_F(GroupForShading, ABytePerShapeIsEnoughForAnyNumberOfMaterials) {
  arrays_.materials.materials.resize(1000);
  for (int i = 0; i < 1000; ++i) arrays_.shapes.shapes.emplace_back().material = i;
  group();
  EXPECT_LE(tables_.shading_groups, kMostShadingGroups);
  for (const std::uint8_t g : tables_.shading_group) EXPECT_LT(g, tables_.shading_groups);
}

}  // namespace
}  // namespace tessera::render
