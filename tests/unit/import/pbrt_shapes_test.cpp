// Shapes that the importer turns into others: curves, subdivision surfaces, bilinear patches, grids of media.
#include <cmath>
#include <cstring>

#include "unit/import/import_fixture.h"
#include "wire/volume_blob.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class PbrtShapes : public ImportTest {
 protected:
  static const SceneBlob* blob(const ImportedScene& scene, const v1::BlobRef& ref) {
    for (const SceneBlob& blob : scene.blobs) {
      if (blob.ref.digest() == ref.digest()) return &blob;
    }
    return nullptr;
  }

  template <typename T>
  static std::vector<T> array(const ImportedScene& scene, const v1::BlobRef& ref) {
    const SceneBlob* bytes = blob(scene, ref);
    if (bytes == nullptr) return {};
    std::vector<T> values(bytes->bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes->bytes.data(), bytes->bytes.size());
    return values;
  }

  std::string error_of_world(const std::string& text) const { return error_of(import_world(text)); }

  static wire::MeshView mesh(const ImportedScene& scene) {
    const SceneBlob* bytes = blob(scene, scene.scene.shapes(0).mesh().blob());
    const auto view =
        bytes == nullptr ? wire::MeshView{} : wire::decode_mesh(bytes->bytes).value_or(wire::MeshView{});
    return view;
  }
};

TEST_F(PbrtShapes, ImplicitSurfacesAreTakenOver) {
  const ImportedScene scene = world(
      "Shape \"implicit\" \"string expression\" \"x^2 + y^2 = z\" \"point3 pmin\" [-1 -2 -3] \"point3 pmax\" "
      "[1 2 3]\n"
      "  \"string roots\" \"interval\"\n"
      "Shape \"implicit\" \"string expression\" \"sin(x)\" \"float radius\" 3 \"point3 center\" [0 1 0] "
      "\"float lipschitz\" 1");
  EXPECT_EQ(warnings_of(scene), "");
  ASSERT_EQ(scene.scene.shapes_size(), 2);
  const v1::ImplicitSurface &bowl = scene.scene.shapes(0).implicit(),
                            &wave = scene.scene.shapes(1).implicit();
  EXPECT_EQ(bowl.expression(), "x^2 + y^2 = z");
  EXPECT_EQ(bowl.box().low().y(), -2);
  EXPECT_EQ(bowl.box().high().z(), 3);
  EXPECT_EQ(bowl.roots(), v1::ImplicitSurface::INTERVAL);
  EXPECT_EQ(wave.ball().radius(), 3);
  EXPECT_EQ(wave.ball().center().y(), 1);
  EXPECT_EQ(wave.lipschitz(), 1);
}

TEST_F(PbrtShapes, CombinationsOfSolidsHaveTheirOperandsInTheirSpace) {
  const ImportedScene scene = world(
      "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\n"
      "MakeNamedMaterial \"b\" \"string type\" \"conductor\"\n"
      "NamedMaterial \"a\"\nTranslate 1 2 3\nScale 2 2 2\n"
      "CSGBegin \"difference\" \"string cutfaces\" \"cut\"\n"
      "  Shape \"box\" \"point3 p0\" [-1 -1 -1] \"point3 p1\" [1 1 1]\n"
      "  CSGBegin \"union\"\n    NamedMaterial \"b\"\n    Translate 0 0 5\n"
      "    Shape \"sphere\" \"float radius\" 0.5\n"
      "  CSGEnd\n"
      "  Shape \"torus\"\n"
      "CSGEnd\n"
      "Shape \"sphere\"");
  EXPECT_EQ(warnings_of(scene), "");
  ASSERT_EQ(scene.scene.shapes_size(), 2);
  const v1::Shape& shape = scene.scene.shapes(0);
  EXPECT_EQ(shape.world_from_object().elements(0), 2);
  EXPECT_EQ(shape.world_from_object().elements(3), 1);
  const v1::Csg& csg = shape.csg();
  EXPECT_EQ(csg.operation(), v1::Csg::DIFFERENCE);
  EXPECT_EQ(csg.cut_faces(), v1::Csg::CUT);
  ASSERT_EQ(csg.parts_size(), 5);
  EXPECT_EQ(csg.parts(0).solid().material(), "a");
  EXPECT_EQ(csg.parts(1).begin().operation(), v1::Csg::UNION);
  const v1::Shape& ball = csg.parts(2).solid();
  EXPECT_EQ(ball.sphere().radius(), 0.5f);
  EXPECT_EQ(ball.material(), "b");
  EXPECT_EQ(ball.world_from_object().elements(0), 1);
  EXPECT_EQ(ball.world_from_object().elements(11), 5);
  EXPECT_TRUE(csg.parts(3).end());
  // The block has ended, and so has what it said.
  EXPECT_TRUE(csg.parts(4).solid().has_torus());
  EXPECT_EQ(csg.parts(4).solid().material(), "a");
  EXPECT_TRUE(scene.scene.shapes(1).has_sphere());
}

TEST_F(PbrtShapes, CombinationsOfSolidsMoveAsAWhole) {
  const std::string moving = "ActiveTransform EndTime\nTranslate 0 0 1\nActiveTransform All\n";
  const ImportedScene scene =
      world(moving + "CSGBegin \"union\"\nTranslate 1 0 0\nShape \"sphere\"\nCSGEnd\nShape \"sphere\"");
  ASSERT_EQ(scene.scene.shapes_size(), 2);
  EXPECT_EQ(scene.scene.shapes(0).world_from_object_end().elements(11), 1);
  EXPECT_EQ(scene.scene.shapes(0).csg().parts(0).solid().world_from_object_end().elements_size(), 0);
  EXPECT_THAT(error_of_world("CSGBegin \"union\"\n" + moving + "Shape \"sphere\"\nCSGEnd"),
              HasSubstr("do not move within it"));
}

TEST_F(PbrtShapes, CombinationsOfSolidsSayWhatIsWrong) {
  EXPECT_THAT(error_of_world("CSGBegin \"xor\"\nShape \"sphere\"\nCSGEnd"), HasSubstr("xor"));
  EXPECT_THAT(error_of_world("CSGBegin \"union\" \"string cutfaces\" \"x\"\nShape \"sphere\"\nCSGEnd"),
              HasSubstr("x"));
  EXPECT_THAT(error_of_world("CSGEnd"), HasSubstr("CSGEnd without CSGBegin"));
  EXPECT_THAT(error_of_world("CSGBegin \"union\"\nShape \"sphere\""), HasSubstr("never closed"));
  EXPECT_THAT(error_of_world("CSGBegin \"union\"\nAttributeEnd\nCSGEnd"), HasSubstr("AttributeEnd without"));
  EXPECT_THAT(error_of_world("CSGBegin \"union\"\nObjectBegin \"a\"\nObjectEnd\nCSGEnd"),
              HasSubstr("ObjectBegin inside of CSGBegin"));
  EXPECT_THAT(error_of_world("AreaLightSource \"diffuse\"\nCSGBegin \"union\"\nShape \"sphere\"\nCSGEnd"),
              HasSubstr("cannot emit light"));
  EXPECT_THAT(
      error_of_world("CSGBegin \"union\"\nShape \"curve\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0]\nCSGEnd"),
      HasSubstr("a curve is no closed solid"));
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "CSGBegin \"union\"\n";
  EXPECT_THAT(error_of_world(deep), HasSubstr("more than 1000 groups within one another"));
}

constexpr char kCurve[] =
    "Shape \"curve\" \"string type\" \"cylinder\" \"point3 P\" [ 0 0 0  1 0 0  2 0 0  3 0 0  4 0 0  5 0 0  6 "
    "0 0 ]\n"
    "  \"float width0\" 4 \"float width1\" 0\n";

TEST_F(PbrtShapes, CurvesOfOneStateAreOneShape) {
  const ImportedScene scene = world(std::string(kCurve) + "AttributeBegin Translate 0 0 0\n" + kCurve +
                                    "AttributeEnd " + kCurve + "Translate 0 1 0\n" + kCurve);
  EXPECT_EQ(warnings_of(scene), "");
  ASSERT_EQ(scene.scene.shapes_size(), 2);  // the translation parts them
  const v1::Curves& curves = scene.scene.shapes(0).curves();
  EXPECT_EQ(curves.kind(), v1::Curves::CYLINDER);
  EXPECT_THAT(array<std::uint32_t>(scene, curves.starts()), ElementsAre(0, 3, 7, 10, 14, 17));
  const std::vector<float> points = array<float>(scene, curves.points());
  ASSERT_EQ(points.size(), 4u * 21);
  // Radii fall from 2 to 0 evenly along both segments.
  for (std::size_t i = 0; i < 7; ++i)
    EXPECT_NEAR(points[4 * i + 3], 2 - static_cast<float>(i) / 3, 1e-6f) << i;
  EXPECT_TRUE(curves.params().digest().empty());
}

TEST_F(PbrtShapes, SplinesBecomeBezierSegments) {
  // A quadratic B-spline with evenly spaced points runs straight on between the midpoints.
  const ImportedScene scene = world(
      "Shape \"curve\" \"string basis\" \"bspline\" \"integer degree\" 2 \"point3 P\" [ 0 0 0  6 0 0  12 0 0 "
      "]\n"
      "Material \"conductor\" Shape \"curve\" \"string basis\" \"bspline\" \"point3 P\" [ 0 0 0  6 0 0  12 0 "
      "0  18 6 0 "
      "]\n"
      "Material \"diffuse\" Shape \"curve\" \"string type\" \"ribbon\" \"point3 P\" [ 0 0 0  1 0 0  2 0 0  3 "
      "0 0 ]\n"
      "  \"normal N\" [ 0 0 2  0 1 0 ]\n");
  ASSERT_EQ(scene.scene.shapes_size(), 3);
  const auto x = [&](int shape, std::size_t point, std::size_t axis) {
    return array<float>(scene, scene.scene.shapes(shape).curves().points())[4 * point + axis];
  };
  for (std::size_t i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(x(0, i, 0), 3 + 2 * static_cast<float>(i)) << i;
  // Uniform cubic: ends (p0 + 4 p1 + p2) / 6 and (p1 + 4 p2 + p3) / 6.
  EXPECT_FLOAT_EQ(x(1, 0, 0), 6);
  EXPECT_FLOAT_EQ(x(1, 3, 0), 12);
  EXPECT_FLOAT_EQ(x(1, 3, 1), 1);
  const std::vector<float> normals = array<float>(scene, scene.scene.shapes(2).curves().normals());
  ASSERT_EQ(normals.size(), 12u);
  // A quarter turn in three equal steps.
  EXPECT_NEAR(normals[3 + 2], std::cos(std::numbers::pi / 6), 1e-6);
  EXPECT_NEAR(normals[3 + 1], std::sin(std::numbers::pi / 6), 1e-6);
  EXPECT_THAT(error_of(import_world("Shape \"curve\" \"point3 P\" [ 0 0 0 1 1 1 ]")),
              HasSubstr("2 control points \"P\" do not fit a bezier of degree 3"));
}

TEST_F(PbrtShapes, SubdividedOctahedronIsRound) {
  const std::string octahedron =
      " \"point3 P\" [ 1 0 0  -1 0 0  0 1 0  0 -1 0  0 0 1  0 0 -1 ] \"integer indices\" [ 0 2 4  2 1 4  1 3 "
      "4  3 0 4  "
      "2 0 5  1 2 5  3 1 5  0 3 5 ]";
  const ImportedScene scene = world("Shape \"loopsubdiv\" \"integer levels\" 2" + octahedron);
  const wire::MeshView smooth = mesh(scene);
  EXPECT_EQ(smooth.triangle_count(), 8u * 16);
  ASSERT_EQ(smooth.normals.size(), smooth.positions.size());
  // The limit of a vertex of valence 4: weight 1 / (4 + 3 / (8 beta)), beta = 3 / 32, for each neighbour of
  // its own ring. Opposite neighbours cancel, so what is left of (1, 0, 0) is 1 - 4 / (4 + 4) = 1/2 of its
  // length.
  EXPECT_NEAR(smooth.positions[0], 0.5, 1e-6);
  for (std::size_t i = 0; i < smooth.vertex_count(); ++i) {
    const float *p = &smooth.positions[3 * i], *n = &smooth.normals[3 * i];
    const float along = p[0] * n[0] + p[1] * n[1] + p[2] * n[2];
    const float lengths = std::hypot(p[0], p[1], p[2]) * std::hypot(n[0], n[1], n[2]);
    EXPECT_LT(along / lengths, -0.95f) << i;  // inwards, as in pbrt; not exactly, for it is no sphere
  }
  EXPECT_THAT(error_of(import_world("Shape \"loopsubdiv\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 0 0 1 ] "
                                    "\"integer indices\" [ 0 1 2 0 1 3 ]")),
              HasSubstr("do not fit one another"));
}

TEST_F(PbrtShapes, PatchesKeepTheirParameters) {
  const ImportedScene flat = world("Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  2 0 0  0 1 0  2 1 0 ]");
  EXPECT_EQ(mesh(flat).triangle_count(), 2u);
  EXPECT_THAT(std::vector<float>(mesh(flat).uvs.begin(), mesh(flat).uvs.end()),
              ElementsAre(0, 0, 1, 0, 0, 1, 1, 1));
  EXPECT_EQ(warnings_of(flat), "");
  // A saddle z = x y on the unit square: every vertex lies on it.
  const ImportedScene saddle = world("Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0  1 1 1 ]");
  EXPECT_THAT(warnings_of(saddle), HasSubstr("curved bilinear patches are cut into"));
  const wire::MeshView cells = mesh(saddle);
  EXPECT_GT(cells.triangle_count(), 100u);
  ASSERT_FALSE(cells.normals.empty());
  for (std::size_t i = 0; i < cells.vertex_count(); ++i) {
    const float* p = &cells.positions[3 * i];
    EXPECT_NEAR(p[2], p[0] * p[1], 1e-6f);  // a few roundings
  }
}

TEST_F(PbrtShapes, GridsFadeAtTheirBorder) {
  const ImportedScene scene = world(
      "MakeNamedMedium \"smoke\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"float density\" [ 1 3 ]\n"
      "  \"rgb sigma_a\" [ 1 1 1 ] \"rgb sigma_s\" [ 1 1 1 ] \"point3 p0\" [ 0 0 0 ] \"point3 p1\" [ 4 1 1 "
      "]\n"
      "MediumInterface \"smoke\" \"\" Material \"interface\" Shape \"sphere\"\n");
  ASSERT_EQ(scene.scene.media_size(), 1);
  const v1::VolumeGrid& grid = scene.scene.media(0).extinction().grid();
  const SceneBlob* bytes = blob(scene, grid.blob());
  ASSERT_NE(bytes, nullptr);
  const auto volume = wire::decode_volume(bytes->bytes);
  ASSERT_TRUE(volume.ok());
  // One empty cell about the two: 4 x 3 x 3 samples over [-2, 6] x [-1, 2]^2.
  EXPECT_EQ(volume->nx, 4u);
  EXPECT_EQ(volume->nz, 3u);
  EXPECT_EQ(volume->channels, 1u);
  const std::size_t middle = (1 * 3 + 1) * 4;
  EXPECT_THAT(std::vector<float>(volume->samples.begin() + middle, volume->samples.begin() + middle + 4),
              ElementsAre(0, 2, 6, 0));
  EXPECT_DOUBLE_EQ(grid.world_from_grid().elements(0), 8);
  EXPECT_DOUBLE_EQ(grid.world_from_grid().elements(3), -2);
  EXPECT_FLOAT_EQ(scene.scene.media(0).albedo().constant().rgb().g(), 0.5f);
  EXPECT_THAT(error_of(import_world("MakeNamedMedium \"v\" \"string type\" \"nanovdb\"")),
              HasSubstr("NanoVDB files are not supported"));
}

}  // namespace
}  // namespace tessera::client
