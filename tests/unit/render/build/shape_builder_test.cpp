// One shape at a time, with materials, media and textures that are only names.
#include "render/build/shape/shape_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <list>

#include "unit/render/build/builder_inputs.h"
#include "wire/mesh_blob.h"
#include "wire/volume_blob.h"

namespace tessera::render {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ShapeBuilderTest : public testing::Test {
 protected:
  ShapeBuilderTest() {
    EXPECT_EQ(materials_.add("paint", 0), absl::OkStatus());
    EXPECT_EQ(materials_.add("nothing", 1), absl::OkStatus());
    texture_table_.attribute_names = 1;
    material_table_.materials.resize(3);
    material_table_.materials[1].kind = BsdfKind::kInterface;
    EXPECT_EQ(media_.names.add("fog", 0), absl::OkStatus());
    textures_.add_noise("holes");
    blobs_.add("triangle", wire::encode_mesh({{0, 0, 0, 1, 0, 0, 0, 1, 0}, {}, {}, {0, 1, 2}}));
    blobs_.add("curve", bytes_of<float>({0, 0, 0, 1, 1, 0, 0, 1, 2, 0, 0, 1, 3, 0, 0, 1}));
    blobs_.add("start", bytes_of<std::uint32_t>({0}));
    const std::vector<float> corners = {-1, 1, 1, 1, 1, 1, 1, 1};
    blobs_.add("corner", wire::encode_volume({2, 2, 2, 1, corners}));
  }
  absl::Status add(const std::string& text, bool instanced = false,
                   const Transform& placed_from_object = {}) {
    shapes_.push_back(message<v1::Shape>(text));
    return builder_.add(shapes_.back(), placed_from_object, instanced, "here");
  }
  std::string refusal(const std::string& text) { return std::string(add(text).message()); }

  NameTable materials_{"material", 2};
  MaterialTable material_table_;
  MediumNames media_;
  NamedTextures textures_;
  BlobsInMemory blobs_;
  const std::map<std::string, int> attribute_names_{{"dirt", 0}};
  TextureTable texture_table_;
  MeshAttributes attributes_{attribute_names_, blobs_.source, texture_table_};
  std::vector<std::string> warnings_;
  std::list<v1::Shape> shapes_;
  ShapeTable table_;
  ShapeBuilder builder_{
      {blobs_.source, materials_, material_table_, media_, textures_, attributes_}, table_, warnings_};
};

TEST_F(ShapeBuilderTest, PlacesTheVerticesOfAMesh) {
  Transform mirrored;
  mirrored.m[0] = -2, mirrored.m[3] = 5;  // x -> 5 - 2 x
  ASSERT_EQ(add("mesh { blob { digest: 'triangle' } } material: 'paint'", false, mirrored), absl::OkStatus());
  ASSERT_EQ(table_.vertices.size(), 3u);
  EXPECT_EQ(table_.vertices[1].position[0], 3);
  // A mirror turns the winding over, so that the front stays the front.
  EXPECT_THAT(std::vector<std::uint32_t>(table_.triangles.begin(), table_.triangles.end()),
              ElementsAre(0, 2, 1));
  EXPECT_EQ(table_.shapes[0].material, 0);
  EXPECT_EQ(table_.shapes[0].triangle_count, 1);
  EXPECT_THAT(builder_.names(), ElementsAre("here"));
}

TEST_F(ShapeBuilderTest, EveryKindHasItsArray) {
  ASSERT_EQ(add("sphere { radius: 2 z_max: 1 }"), absl::OkStatus());
  ASSERT_EQ(add("curves { points { digest: 'curve' } starts { digest: 'start' } }"), absl::OkStatus());
  ASSERT_EQ(add("sdf_grid { blob { digest: 'corner' } }"), absl::OkStatus());
  ASSERT_EQ(table_.shapes.size(), 3u);
  EXPECT_EQ(table_.shapes[0].kind, ShapeKind::kSphere);
  EXPECT_EQ(table_.quadrics[0].z_max, 1);
  EXPECT_TRUE(table_.quadrics[0].partial);
  EXPECT_EQ(table_.shapes[1].kind, ShapeKind::kCurves);
  EXPECT_EQ(table_.curves[0].points.size(), 4u);
  EXPECT_EQ(table_.shapes[2].kind, ShapeKind::kSdfGrid);
  EXPECT_THAT(table_.sdf_grids[0].voxels, ElementsAre(0));
  EXPECT_EQ(table_.shapes[2].material, 2);  // the one of shapes that name none
}

TEST_F(ShapeBuilderTest, ImplicitSurfacesAreProgramsAndPolynomials) {
  ASSERT_EQ(add("implicit { expression: 'x^2 + y^2 = 1 - 2*z^2' ball { radius: 2 } }"), absl::OkStatus());
  EXPECT_EQ(table_.shapes[0].kind, ShapeKind::kImplicit);
  const ImplicitRecord& polynomial = table_.implicits[0];
  EXPECT_EQ(polynomial.degree, 2);
  EXPECT_EQ(polynomial.roots, ImplicitRoots::kInterval);
  EXPECT_EQ(polynomial.coefficients.size(), 10u);
  EXPECT_EQ(polynomial.coefficients[0], 1);  // x^2
  EXPECT_EQ(polynomial.coefficients[7], 2);  // z^2
  EXPECT_EQ(polynomial.coefficients.back(), -1);
  EXPECT_NEAR(polynomial.magnitude, 4 + 4 + 8 + 1, 1e-5);  // within a box of 2
  EXPECT_NEAR(polynomial.slope, 4 + 4 + 8, 1e-5);
  ASSERT_EQ(
      add("implicit { expression: 'sin(x) + y' box { low { x: -1 y: -1 z: -1 } high { x: 1 y: 1 z: 1 } } }"),
      absl::OkStatus());
  EXPECT_EQ(table_.implicits[1].degree, 0);
  EXPECT_EQ(table_.implicits[1].roots, ImplicitRoots::kInterval);
  ASSERT_EQ(add("implicit { expression: 'x' ball { radius: 1 } roots: STURM }"), absl::OkStatus());
  EXPECT_EQ(table_.implicits[2].roots, ImplicitRoots::kSturm);
  ASSERT_EQ(add("implicit { expression: 'x' ball { radius: 1 } lipschitz: 1 roots: NEWTON }"),
            absl::OkStatus());
  EXPECT_EQ(table_.implicits[3].roots, ImplicitRoots::kSphereTracing);
}

TEST_F(ShapeBuilderTest, SaysWhatIsAtFaultWithImplicitSurfaces) {
  EXPECT_THAT(refusal("implicit { expression: 'x + ' ball { radius: 1 } }"),
              HasSubstr("expression: column 5"));
  EXPECT_THAT(refusal("implicit { expression: 'x' }"), HasSubstr("needs bounds"));
  EXPECT_THAT(refusal("implicit { expression: 'x' ball {} }"), HasSubstr("has no radius"));
  EXPECT_THAT(refusal("implicit { expression: 'x' box { high { x: 1 y: 1 } } }"),
              HasSubstr("have no volume"));
  EXPECT_THAT(refusal("implicit { expression: '2 - 1' ball { radius: 1 } }"), HasSubstr("a constant"));
  EXPECT_THAT(refusal("implicit { expression: 'exp(x)' ball { radius: 1 } roots: STURM }"),
              HasSubstr("sturm is for polynomials of degree 1 to 12"));
  EXPECT_THAT(refusal("implicit { expression: 'x^13' ball { radius: 1 } roots: NEWTON }"),
              HasSubstr("newton is for polynomials"));
  EXPECT_THAT(refusal("implicit { expression: 'x' ball { radius: 1 } lipschitz: -1 }"),
              HasSubstr("a Lipschitz bound"));
  EXPECT_THAT(refusal("implicit { expression: 'x^12' ball { radius: 1e18 } }"), HasSubstr("beyond 1e200"));
  EXPECT_THAT(refusal("implicit { expression: 'x' ball { radius: 1 } } area_light {}"),
              HasSubstr("an implicit surface cannot emit light"));
}

TEST_F(ShapeBuilderTest, ASurfaceOfNothingMattersAsABorderOnly) {
  ASSERT_EQ(add("sphere { radius: 1 } material: 'nothing'"), absl::OkStatus());
  EXPECT_THAT(table_.shapes, IsEmpty());
  ASSERT_EQ(add("sphere { radius: 1 } material: 'nothing' interior_medium: 'fog'"), absl::OkStatus());
  ASSERT_EQ(table_.shapes.size(), 1u);
  EXPECT_TRUE(table_.shapes[0].flags & kMediumBorder);
  EXPECT_EQ(table_.shapes[0].interior, 0);
  EXPECT_EQ(table_.shapes[0].exterior, -1);
}

TEST_F(ShapeBuilderTest, AlphaIsForMeshes) {
  ASSERT_EQ(add("mesh { blob { digest: 'triangle' } } alpha { texture: 'holes' }"), absl::OkStatus());
  EXPECT_TRUE(table_.shapes[0].flags & kHasAlpha);
  EXPECT_EQ(table_.shapes[0].alpha_texture, *textures_.node("holes"));
  EXPECT_THAT(warnings_, IsEmpty());
  ASSERT_EQ(add("disk { radius: 1 } alpha { constant: 0.5 }"), absl::OkStatus());
  EXPECT_THAT(warnings_, ElementsAre("here: alpha is for meshes only; left out"));
}

TEST_F(ShapeBuilderTest, NotesWhatEmitsLight) {
  ASSERT_EQ(add("disk { radius: 1 }"), absl::OkStatus());
  ASSERT_EQ(add("disk { radius: 1 } area_light { two_sided: true }"), absl::OkStatus());
  ASSERT_EQ(builder_.emitters().size(), 1u);
  EXPECT_EQ(builder_.emitters()[0].shape, 1);
  EXPECT_TRUE(builder_.emitters()[0].light->two_sided());
  ASSERT_EQ(add("disk { radius: 1 } area_light {}", true), absl::OkStatus());
  ASSERT_EQ(add("curves { points { digest: 'curve' } starts { digest: 'start' } } area_light {}"),
            absl::OkStatus());
  EXPECT_EQ(builder_.emitters().size(), 1u);
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("here: shapes of an object cannot emit light"),
                                     HasSubstr("here: curves cannot emit light")));
}

TEST_F(ShapeBuilderTest, SaysWhatIsAtFault) {
  EXPECT_THAT(refusal(""), HasSubstr("its kind is missing"));
  EXPECT_THAT(refusal("disk { radius: 1 } material: 'x'"), HasSubstr("material 'x' does not exist"));
  EXPECT_THAT(refusal("disk { radius: 1 } exterior_medium: 'x'"), HasSubstr("medium 'x' does not exist"));
  EXPECT_THAT(refusal("disk { radius: 1 } alpha { texture: 'x' }"), HasSubstr("no texture x"));
  EXPECT_THAT(refusal("disk { radius: 1 inner_radius: 1 }"), HasSubstr("its radius, height or angle"));
  EXPECT_THAT(refusal("cylinder { radius: 1 }"), HasSubstr("a cylinder without height"));
  EXPECT_THAT(refusal("disk { radius: 1 } uv_transform: [1, 2]"),
              HasSubstr("a uv transform has six numbers"));
  EXPECT_THAT(refusal("mesh { blob { digest: 'x' } }"), HasSubstr("mesh x: there is no blob x"));
  EXPECT_THAT(refusal("mesh { blob { digest: 'start' } }"), HasSubstr("mesh start: "));
  EXPECT_THAT(
      refusal("mesh { blob { digest: 'triangle' } attributes { name: 'dirt' blob { digest: 'x' } } }"),
      HasSubstr("attribute 'dirt': there is no blob x"));
  EXPECT_THAT(refusal("curves { points { digest: 'curve' } starts { digest: 'x' } }"),
              HasSubstr("segments of curves: there is no blob x"));
  EXPECT_THAT(refusal("sdf_grid { blob { digest: 'corner' } } area_light {}"),
              HasSubstr("a grid of distances cannot emit light"));
  Transform flat;
  flat.m[0] = 0;
  EXPECT_THAT(std::string(add("disk { radius: 1 }", false, flat).message()),
              HasSubstr("its transform is singular"));
  Transform far;
  far.m[3] = 1e39;
  EXPECT_THAT(std::string(add("mesh { blob { digest: 'triangle' } }", false, far).message()),
              HasSubstr("a vertex is not finite"));
}

}  // namespace
}  // namespace tessera::render
