// One shape at a time, with materials, media and textures that are only names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <list>

#include "unit/render/scene/names_for_shapes.h"
#include "wire/mesh_blob.h"
#include "wire/volume_blob.h"

namespace tessera::render {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ShapeBuilderTest : public NamesForShapes {
 protected:
  ShapeBuilderTest() : NamesForShapes(2, {{"dirt", 0}}) {
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
    messages_.push_back(message<v1::Shape>(text));
    return shapes_.add(messages_.back(), placed_from_object, instanced, "here");
  }
  std::string refusal(const std::string& text) { return std::string(add(text).message()); }

  std::list<v1::Shape> messages_;
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
  EXPECT_THAT(shapes_.names(), ElementsAre("here"));
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
  EXPECT_NEAR(polynomial.magnitude, 4 + 4 + 8 + 1, 1e-5);  // the bound within a box of 2
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

TEST_F(ShapeBuilderTest, AlphaIsForAllKinds) {
  for (const char* const kind : {"mesh { blob { digest: 'triangle' } }", "disk { radius: 1 }",
                                 "torus { major_radius: 2 minor_radius: 1 }"}) {
    ASSERT_EQ(add(absl::StrCat(kind, " alpha { texture: 'holes' }")), absl::OkStatus());
    EXPECT_TRUE(table_.shapes.back().flags & kHasAlpha);
    EXPECT_EQ(table_.shapes.back().alpha_texture, *textures_.node("holes"));
  }
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(ShapeBuilderTest, NotesWhatEmitsLight) {
  ASSERT_EQ(add("disk { radius: 1 }"), absl::OkStatus());
  ASSERT_EQ(add("disk { radius: 1 } area_light { two_sided: true }"), absl::OkStatus());
  ASSERT_EQ(shapes_.emitters().size(), 1u);
  EXPECT_EQ(shapes_.emitters()[0].shape, 1);
  EXPECT_TRUE(shapes_.emitters()[0].light->two_sided());
  ASSERT_EQ(add("disk { radius: 1 } area_light {}", true), absl::OkStatus());
  ASSERT_EQ(add("curves { points { digest: 'curve' } starts { digest: 'start' } } area_light {}"),
            absl::OkStatus());
  EXPECT_EQ(shapes_.emitters().size(), 1u);
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("here: curves cannot emit light")));
}

TEST_F(ShapeBuilderTest, EveryPlaceOfAnEmitterIsAShape) {
  ASSERT_EQ(add("disk { radius: 1 }"), absl::OkStatus());
  ASSERT_EQ(add("disk { radius: 2 } area_light {}", true), absl::OkStatus());
  EXPECT_FALSE(shapes_.waits_for_places(0));
  EXPECT_TRUE(shapes_.waits_for_places(1));
  EXPECT_THAT(shapes_.emitters(), IsEmpty());
  EXPECT_EQ(*shapes_.place_emitter(1), 1);
  EXPECT_EQ(*shapes_.place_emitter(1), 2);
  ASSERT_EQ(table_.shapes.size(), 3u);
  EXPECT_EQ(table_.shapes[2].quadric, table_.shapes[1].quadric);
  EXPECT_EQ(shapes_.names()[2], shapes_.names()[1]);
  ASSERT_EQ(shapes_.emitters().size(), 2u);
  EXPECT_EQ(shapes_.emitters()[1].shape, 2);
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

/// Area of the triangles of a shape.
double mesh_area(const ShapeTable& table, const ShapeRecord& shape) {
  double area = 0;
  for (std::int32_t t = 0; t < shape.triangle_count; ++t) {
    Imath::V3d p[3];
    for (int k = 0; k < 3; ++k) {
      const auto corner = table.triangles[3 * static_cast<std::size_t>(shape.first_triangle + t) + k];
      const float* at = table.vertices[static_cast<std::size_t>(shape.first_vertex) + corner].position;
      p[k] = {at[0], at[1], at[2]};
    }
    area += (p[1] - p[0]).cross(p[2] - p[0]).length() / 2;
  }
  return area;
}

constexpr const char* kCube =
    "vertices: [0,0,0, 2,0,0, 0,2,0, 2,2,0, 0,0,2, 2,0,2, 0,2,2, 2,2,2, 1,1,1, 1,1,2, 1,0.5,0]";
constexpr const char* kSlabs = "planes: [2,0,0,4, -3,0,0,0, 0,1,0,2, 0,-1,0,0, 0,0,1,2, 0,0,-1,0, 1,1,1,99]";

TEST_F(ShapeBuilderTest, PolyhedraOfVerticesAndOfPlanesAreTheSame) {
  for (const char* const given : {kCube, kSlabs}) {
    ASSERT_EQ(add(absl::StrCat("polyhedron { ", given, " }")), absl::OkStatus());
    const QuadricRecord& q = table_.quadrics.back();
    // Points inside of the hull and planes that bound nothing are gone.
    ASSERT_EQ(q.facet_count, 6) << given;
    EXPECT_EQ(table_.shapes.back().kind, ShapeKind::kPolyhedron);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_FLOAT_EQ(q.render_from_object.m[5 * axis], 1);
      EXPECT_FLOAT_EQ(q.render_from_object.m[4 * axis + 3], 1);
    }
    for (int i = 0; i < 6; ++i)
      EXPECT_FLOAT_EQ(table_.facets[static_cast<std::size_t>(q.first_facet + i)].offset, 1);
  }
}

TEST_F(ShapeBuilderTest, FlatShapesThatEmitAreTheirTriangles) {
  Transform doubled;
  doubled.m[0] = doubled.m[5] = doubled.m[10] = 2;
  const struct {
    std::string shape;
    std::int32_t triangles;
    double area;  // area in object space
  } cases[] = {
      {"box { low: [-1,0,0] high: [1,3,4] }", 12, 2 * (2 * 3 + 3 * 4 + 4 * 2)},
      {absl::StrCat("polyhedron { ", kCube, " }"), 12, 24},
      {"polyhedron { vertices: [0,0,0, 1,0,0, 0,1,0, 0,0,1] }", 4, 1.5 + std::sqrt(3) / 2},
      // An L, and one with a corner on the line between its neighbours.
      {"polygon { corners: [0,0,5, 2,0,5, 2,1,5, 1,1,5, 1,2,5, 0,2,5] }", 4, 3},
      {"polygon { corners: [0,0,0, 0,1,0, 0,2,0, 0,2,2, 0,0,2] }", 3, 4},
  };
  for (const auto& one : cases) {
    ASSERT_EQ(add(one.shape + " area_light {}", false, doubled), absl::OkStatus()) << one.shape;
    const ShapeRecord& shape = table_.shapes.back();
    EXPECT_EQ(shape.kind, ShapeKind::kTriangles);
    EXPECT_EQ(shape.triangle_count, one.triangles) << one.shape;
    EXPECT_NEAR(mesh_area(table_, shape), 4 * one.area, 1e-5) << one.shape;
    // Those of an object emit where it is placed.
    ASSERT_EQ(add(one.shape + " area_light {}", true), absl::OkStatus());
    EXPECT_EQ(table_.shapes.back().kind, ShapeKind::kTriangles);
  }
}

TEST_F(ShapeBuilderTest, SolidsAreOfSizeOneInTheirOwnSpace) {
  ASSERT_EQ(add("cone { radius: 2 top_radius: 4 height: 6 capped: true phi_max_degrees: 90 }"),
            absl::OkStatus());
  const QuadricRecord cone = table_.quadrics.back();
  EXPECT_FLOAT_EQ(cone.radius, 0.5);
  EXPECT_FLOAT_EQ(cone.top_radius, 1);
  EXPECT_FLOAT_EQ(cone.render_from_object.m[0], 4);
  EXPECT_FLOAT_EQ(cone.render_from_object.m[10], 3);
  EXPECT_FLOAT_EQ(cone.render_from_object.m[11], 3);
  EXPECT_TRUE(cone.capped && cone.partial);
  ASSERT_EQ(add("ellipsoid { radii: [1, 2, 3] }"), absl::OkStatus());
  EXPECT_EQ(table_.shapes.back().kind, ShapeKind::kSphere);
  EXPECT_FLOAT_EQ(table_.quadrics.back().render_from_object.m[10], 3);
  // A mirror keeps the outside of solids; that of spheres is turned, as in pbrt.
  Transform mirror;
  mirror.m[0] = -1;
  ASSERT_EQ(add("ellipsoid { radii: [1, 2, 3] }", false, mirror), absl::OkStatus());
  EXPECT_FALSE(table_.shapes.back().flags & kFlipNormal);
  ASSERT_EQ(add("sphere { radius: 1 }", false, mirror), absl::OkStatus());
  EXPECT_TRUE(table_.shapes.back().flags & kFlipNormal);
}

TEST_F(ShapeBuilderTest, SaysWhatIsAtFaultInSolids) {
  EXPECT_THAT(refusal("half_space { height: nan }"), HasSubstr("its height is not finite"));
  EXPECT_THAT(refusal("half_space {} area_light {}"), HasSubstr("a half-space cannot emit light"));
  EXPECT_THAT(refusal("cone { radius: 1 }"), HasSubstr("its radius, height or angle"));
  EXPECT_THAT(refusal("cone { radius: -1 top_radius: 1 height: 1 }"),
              HasSubstr("its radius, height or angle"));
  EXPECT_THAT(refusal("cone { radius: 1 height: 1 } area_light {}"), HasSubstr("a cone cannot emit light"));
  EXPECT_THAT(refusal("cylinder { radius: 1 z_max: 1 capped: true } area_light {}"),
              HasSubstr("a cylinder with caps cannot emit light"));
  EXPECT_THAT(refusal("torus { major_radius: 1 minor_radius: 1 }"), HasSubstr("a torus wants"));
  EXPECT_THAT(refusal("torus { major_radius: 1 minor_radius: 0.1 } area_light {}"),
              HasSubstr("a torus cannot emit light"));
  EXPECT_THAT(refusal("ellipsoid { radii: [1, 0, 1] }"), HasSubstr("three radii above 0"));
  EXPECT_THAT(refusal("box { low: [0, 0, 0] high: [1, 0, 1] }"), HasSubstr("its high above its low"));
  EXPECT_THAT(refusal("box { low: [0, 0] high: [1, 1, 1] }"), HasSubstr("three finite numbers"));
  EXPECT_THAT(refusal("polygon { corners: [0,0,0, 1,0,0] }"), HasSubstr("3 to 4096 corners"));
  EXPECT_THAT(refusal("polygon { corners: [0,0,0, 1,0,0, 2,0,0] }"), HasSubstr("no area"));
  EXPECT_THAT(refusal("polygon { corners: [0,0,0, 1,0,0, 1,1,0.1, 0,1,0] }"), HasSubstr("in one plane"));
  EXPECT_THAT(refusal("polygon { corners: [0,0,0, 1,0,0, 1,0,0, 0,1,0] }"), HasSubstr("are the same"));
  EXPECT_THAT(refusal("polygon { corners: [0,0,0, 3,0,0, 3,1,0, 1,-1,0, 1,3,0] } area_light {}"),
              HasSubstr("edges of a polygon cross"));
  EXPECT_THAT(refusal("polyhedron {}"), HasSubstr("either vertices or planes"));
  EXPECT_THAT(refusal("polyhedron { vertices: [0,0,0, 1,0,0, 0,1,0, 1,1,0] }"),
              HasSubstr("lie in one plane"));
  EXPECT_THAT(refusal("polyhedron { planes: [1,0,0,1, 0,1,0,1, 0,0,1,1, -1,-1,0,1] }"),
              HasSubstr("leave it open"));
  EXPECT_THAT(refusal("polyhedron { planes: [1,0,0,-1, -1,0,0,-1, 0,1,0,1, 0,-1,0,1, 0,0,1,1, 0,0,-1,1] }"),
              HasSubstr("nothing inside"));
  EXPECT_THAT(refusal("polyhedron { planes: [0,0,0,1, 0,1,0,1, 0,0,1,1, -1,-1,0,1] }"),
              HasSubstr("no normal"));
}

}  // namespace
}  // namespace tessera::render
