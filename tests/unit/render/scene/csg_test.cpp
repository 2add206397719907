// Combinations of solids: what they refuse, by name, and what they become.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <list>

#include "unit/render/scene/names_for_shapes.h"
#include "wire/csg_limits.h"
#include "wire/mesh_blob.h"

namespace tessera::render {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class CsgBuilderTest : public NamesForShapes {
 protected:
  CsgBuilderTest() {
    EXPECT_EQ(materials_.add("paint", 1), absl::OkStatus());
    EXPECT_EQ(materials_.add("mask", 2), absl::OkStatus());
    material_table_.materials.resize(3);
    material_table_.materials[2].flags = kHasOpacity;
    EXPECT_EQ(media_.names.add("fog", 0), absl::OkStatus());
    // A tetrahedron, one of whose corners stands there three times; without a face; and one with a sliver.
    const std::vector<float> corners = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    blobs_.add("closed", wire::encode_mesh({corners, {}, {}, {0, 2, 1, 0, 1, 3, 1, 2, 4, 0, 5, 2}}));
    blobs_.add("open", wire::encode_mesh({corners, {}, {}, {0, 2, 1, 0, 1, 3, 1, 2, 4}}));
    blobs_.add("sliver", wire::encode_mesh({corners, {}, {}, {0, 2, 1, 0, 1, 3, 1, 2, 4, 0, 5, 2, 3, 4, 1}}));
  }
  absl::Status add(const v1::Shape& shape) {
    messages_.push_back(shape);
    if (auto s = shapes_.add(messages_.back(), {}, false, "here"); !s.ok()) return s;
    return shapes_.add_solids_of_combinations();
  }
  absl::Status add(const std::string& text) { return add(message<v1::Shape>(text)); }
  std::string refusal(const std::string& text) { return std::string(add(text).message()); }
  std::string refused_operand(const std::string& solid) {
    return refusal("csg { parts { solid { sphere { radius: 1 } } } parts { solid { " + solid + " } } }");
  }

  std::list<v1::Shape> messages_;
};

TEST_F(CsgBuilderTest, RefusesWhatIsNotClosed) {
  EXPECT_THAT(refused_operand("sphere { radius: 1 z_min: 0 }"),
              HasSubstr("operand 1: a part of a sphere is not closed"));
  EXPECT_THAT(refused_operand("cylinder { radius: 1 z_max: 1 }"),
              HasSubstr("a cylinder without caps is not"));
  EXPECT_THAT(refused_operand("cylinder { radius: 1 z_max: 1 capped: true phi_max_degrees: 90 }"),
              HasSubstr("cut by an angle"));
  EXPECT_THAT(refused_operand("cone { radius: 1 height: 1 } name: 'hat'"),
              HasSubstr("operand 1 (hat): a cone without caps is not closed"));
  EXPECT_THAT(refused_operand("cone { radius: 1 height: 1 capped: true phi_max_degrees: 90 }"),
              HasSubstr("cut by an angle"));
  EXPECT_THAT(refused_operand("disk { radius: 1 }"), HasSubstr("a disk is not closed"));
  EXPECT_THAT(refused_operand("polygon {}"), HasSubstr("a polygon is not closed"));
  EXPECT_THAT(refused_operand("curves {}"), HasSubstr("curves are not closed"));
  EXPECT_THAT(refused_operand("sdf_grid {}"), HasSubstr("a grid of distances"));
  EXPECT_THAT(refused_operand("csg {}"), HasSubstr("parts between"));
  EXPECT_THAT(refused_operand(""), HasSubstr("its kind is missing"));
}

TEST_F(CsgBuilderTest, SaysWhereAMeshIsOpen) {
  EXPECT_EQ(add("csg { parts { solid { mesh { blob { digest: 'closed' } } } } }"), absl::OkStatus());
  EXPECT_EQ(add("csg { parts { solid { mesh { blob { digest: 'sliver' } } } } }"), absl::OkStatus());
  EXPECT_THAT(refused_operand("mesh { blob { digest: 'open' } }"),
              HasSubstr("its mesh is not closed: 3 edges are open, from (0, 0, 0) to (0, 1, 0); (0, 0, 0) to "
                        "(0, 0, 1); (0, 1, 0) to (0, 0, 1)"));
  EXPECT_THAT(refused_operand("mesh { blob { digest: 'missing' } }"), HasSubstr("operand 1: mesh missing"));
}

TEST_F(CsgBuilderTest, RefusesWhatOnlyTheWholeCanHave) {
  EXPECT_THAT(refused_operand("sphere { radius: 1 } alpha { constant: 0.5 }"), HasSubstr("alpha is for the"));
  EXPECT_THAT(refused_operand("sphere { radius: 1 } interior_medium: 'fog'"), HasSubstr("media are for the"));
  EXPECT_THAT(refused_operand("sphere { radius: 1 } world_from_object_end { elements: "
                              "[1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1] }"),
              HasSubstr("do not move within it"));
  EXPECT_THAT(refused_operand("sphere { radius: 1 } area_light {}"),
              HasSubstr("a combination of solids cannot emit light"));
  EXPECT_THAT(refusal("csg { parts { solid { sphere { radius: 1 } } } } area_light {}"),
              HasSubstr("a combination of solids cannot emit light"));
  EXPECT_THAT(refusal("csg { parts { solid { sphere { radius: 1 } } } } uv_transform: [1,0,0,0,1,0]"),
              HasSubstr("a uv transform is for the operands"));
  EXPECT_THAT(refused_operand("sphere { radius: 1 } material: 'x'"),
              HasSubstr("operand 1: material 'x' does not exist"));
}

TEST_F(CsgBuilderTest, RefusesWhatHasNoSize) {
  EXPECT_THAT(refused_operand("half_space {}"), HasSubstr("has no end"));
  EXPECT_THAT(
      refused_operand("sphere { radius: 1 } world_from_object { elements: [0,0,0,0, 0,0,0,0, 0,0,0,0, "
                      "0,0,0,1] }"),
      HasSubstr("operand 1: its transform is singular"));
  EXPECT_THAT(refused_operand("sphere { radius: nan }"), HasSubstr("operand 1: its radius"));
  EXPECT_THAT(
      refused_operand("sphere { radius: 1 } world_from_object { elements: [nan,0,0,0, 0,1,0,0, 0,0,1,0, "
                      "0,0,0,1] }"),
      HasSubstr("operand 1: "));
  EXPECT_THAT(refused_operand("sphere { radius: 1e30 }"), HasSubstr("32-bit floats"));
  EXPECT_THAT(table_.shapes, IsEmpty());
}

TEST_F(CsgBuilderTest, RefusesTreesThatAreNone) {
  EXPECT_THAT(refusal("csg {}"), HasSubstr("no operands"));
  EXPECT_THAT(refusal("csg { parts { end: true } }"), HasSubstr("an end without a beginning"));
  EXPECT_THAT(refusal("csg { parts { begin {} } parts { end: true } }"), HasSubstr("no operands"));
  EXPECT_THAT(refusal("csg { parts { begin {} } parts { solid { sphere { radius: 1 } } } }"),
              HasSubstr("a group has no end"));
  EXPECT_THAT(refusal("csg { parts {} }"), HasSubstr("neither a solid nor"));
  v1::Shape unknown = message<v1::Shape>("csg { parts { solid { sphere { radius: 1 } } } }");
  unknown.mutable_csg()->set_operation(static_cast<v1::Csg::Operation>(7));
  EXPECT_THAT(std::string(add(unknown).message()), HasSubstr("none that is known"));
}

v1::Shape nested(int depth) {
  v1::Shape shape;
  v1::Csg& csg = *shape.mutable_csg();
  for (int i = 1; i < depth; ++i) csg.add_parts()->mutable_begin();
  csg.add_parts()->mutable_solid()->mutable_sphere()->set_radius(1);
  for (int i = 1; i < depth; ++i) csg.add_parts()->set_end(true);
  return shape;
}

TEST_F(CsgBuilderTest, NestsToALimit) {
  EXPECT_EQ(add(nested(wire::kMostCsgDepth)), absl::OkStatus());
  EXPECT_EQ(table_.csgs.back().nodes.size(), static_cast<std::size_t>(wire::kMostCsgDepth) + 1);
  for (const int depth : {wire::kMostCsgDepth + 1, 100'000})
    EXPECT_THAT(std::string(add(nested(depth)).message()),
                HasSubstr("more than 1000 groups within one another"));
}

TEST_F(CsgBuilderTest, LimitsSolidsAndGroups) {
  v1::Shape many;
  for (int i = 0; i <= wire::kMostCsgSolids; ++i)
    many.mutable_csg()->add_parts()->mutable_solid()->mutable_sphere()->set_radius(1);
  EXPECT_THAT(std::string(add(many).message()), HasSubstr("more than 65536 solids"));
  v1::Shape empty;
  for (int i = 0; i < 500'000; ++i) {
    empty.mutable_csg()->add_parts()->mutable_begin();
    empty.mutable_csg()->add_parts()->mutable_solid()->mutable_sphere()->set_radius(1);
    empty.mutable_csg()->add_parts()->set_end(true);
  }
  EXPECT_THAT(std::string(add(empty).message()), HasSubstr("more than"));
}

TEST_F(CsgBuilderTest, LeavesOutWhatIsEmpty) {
  EXPECT_EQ(add("csg { operation: INTERSECTION parts { solid { box { low: [0,0,0] high: [1,1,1] } } } "
                "parts { solid { box { low: [1,0,0] high: [2,1,1] } } } }"),
            absl::OkStatus());
  EXPECT_THAT(table_.shapes, IsEmpty());
  EXPECT_THAT(warnings_, ElementsAre("here: its operands leave nothing; left out"));
}

TEST_F(CsgBuilderTest, HalfSpacesAcrossAxesBoundEachOther) {
  std::string parts;
  for (const char* const turned :
       {"1,0,0,0, 0,1,0,0, 0,0,1,1", "1,0,0,0, 0,-1,0,0, 0,0,-1,0", "0,0,1,2, 1,0,0,0, 0,1,0,0",
        "0,0,-1,0, 1,0,0,0, 0,-1,0,0", "0,1,0,0, 0,0,1,4, 1,0,0,0", "0,-1,0,0, 0,0,-1,0, 1,0,0,0"})
    parts += absl::StrCat("parts { solid { half_space {} world_from_object { elements: [", turned,
                          ", 0,0,0,1] } } }");
  ASSERT_EQ(add("csg { operation: INTERSECTION " + parts + " }"), absl::OkStatus());
  // 2 by 4 by 1, in a unit space about its middle.
  EXPECT_THAT(table_.csgs[0].render_from_unit.m, ElementsAre(2, 0, 0, 1, 0, 2, 0, 2, 0, 0, 2, 0.5));
}

TEST_F(CsgBuilderTest, OperandsHaveRecordsThatNothingButTheWholeKnows) {
  ASSERT_EQ(add("csg { parts { solid { sphere { radius: 1 } material: 'paint' } } parts { solid { sphere { "
                "radius: 2 } "
                "material: 'mask' } } parts { solid { sphere { radius: 3 } } } } material: 'paint' "
                "interior_medium: 'fog'"),
            absl::OkStatus());
  ASSERT_EQ(table_.shapes.size(), 4u);
  const CsgRecord& csg = table_.csgs[0];
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(csg.solids[i].shape, static_cast<int>(i) + 1);
    EXPECT_EQ(table_.shapes[i + 1].material, i == 1 ? 2 : 1);
    EXPECT_EQ(table_.shapes[i + 1].interior, 0);
    EXPECT_TRUE(table_.shapes[i + 1].flags & kMediumBorder);
  }
  // Light may go through the one that is open, so rays have to look.
  EXPECT_EQ(table_.shapes[0].material, 2);
  EXPECT_EQ(shapes_.names()[2], "here, operand 1");
}

}  // namespace
}  // namespace tessera::render
