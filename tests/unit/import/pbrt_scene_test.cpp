// Meaning of pbrt directives: transformations, attributes, objects, media.
#include <cmath>

#include "unit/import/import_fixture.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

class PbrtScene : public ImportTest {};

TEST_F(PbrtScene, TransformsNestAndRestore) {
  const ImportedScene scene = world(
      "Translate 1 0 0\nCoordinateSystem \"here\"\n"
      "AttributeBegin Translate 0 1 0 Shape \"sphere\" AttributeEnd\n"
      "TransformBegin Translate 0 0 1 Shape \"sphere\" TransformEnd\n"
      "Transform [ 2 0 0 0  0 2 0 0  0 0 2 0  7 8 9 1 ] Shape \"sphere\"\n"
      "ConcatTransform [ 1 0 0 0  0 1 0 0  0 0 1 0  1 1 1 1 ] Shape \"sphere\"\n"
      "CoordSysTransform \"here\" Shape \"sphere\" Identity Shape \"sphere\"\n");
  ASSERT_EQ(scene.scene.shapes_size(), 6);
  const auto at = [&](int i) { return column3(scene.scene.shapes(i).world_from_object()); };
  EXPECT_THAT(at(0), ElementsAre(1, 1, 0));
  EXPECT_THAT(at(1), ElementsAre(1, 0, 1));
  EXPECT_THAT(at(2), ElementsAre(7, 8, 9));
  EXPECT_THAT(at(3), ElementsAre(9, 10, 11));
  EXPECT_THAT(at(4), ElementsAre(1, 0, 0));
  EXPECT_EQ(scene.scene.shapes(5).world_from_object().elements_size(), 0);
}

TEST_F(PbrtScene, AttributesAreSavedAndDefaultsApply) {
  const ImportedScene scene = world(
      "Attribute \"shape\" \"float radius\" 3\n"
      "AttributeBegin ReverseOrientation AreaLightSource \"diffuse\" \"rgb L\" [ 1 2 3 ] \"bool twosided\" "
      "\"true\"\n"
      "  Attribute \"shape\" \"float phimax\" 180 Shape \"sphere\" Shape \"sphere\" \"float radius\" 2 "
      "AttributeEnd\n"
      "Shape \"sphere\"\n");
  ASSERT_EQ(scene.scene.shapes_size(), 3);
  const v1::Shape& first = scene.scene.shapes(0);
  EXPECT_TRUE(first.reverse_orientation());
  EXPECT_FLOAT_EQ(first.sphere().radius(), 3);
  EXPECT_FLOAT_EQ(first.sphere().phi_max_degrees(), 180);
  EXPECT_FLOAT_EQ(first.area_light().radiance().rgb().b(), 3);
  EXPECT_TRUE(first.area_light().two_sided());
  EXPECT_FALSE(first.area_light().has_scale());
  EXPECT_FLOAT_EQ(scene.scene.shapes(1).sphere().radius(), 2);
  EXPECT_FALSE(scene.scene.shapes(2).has_area_light());
  EXPECT_FALSE(scene.scene.shapes(2).reverse_orientation());
  EXPECT_FALSE(scene.scene.shapes(2).sphere().has_phi_max_degrees());
  EXPECT_EQ(warnings_of(scene), "");
}

TEST_F(PbrtScene, ObjectsArePlacedAndUnusedOnesDropped) {
  const ImportedScene scene = world(
      "Translate 1 0 0 ObjectBegin \"a\" Translate 0 1 0 Shape \"sphere\" ObjectEnd\n"
      "ObjectBegin \"empty\" ObjectEnd ObjectBegin \"unused\" Shape \"plymesh\" \"string filename\" "
      "\"missing.ply\" "
      "ObjectEnd\n"
      "ObjectInstance \"a\" AttributeBegin Translate 0 0 5 ObjectInstance \"a\" AttributeEnd ObjectInstance "
      "\"empty\"\n");
  ASSERT_EQ(scene.scene.objects_size(), 1);
  EXPECT_EQ(scene.scene.objects(0).name(), "a");
  EXPECT_THAT(column3(scene.scene.objects(0).shapes(0).world_from_object()), ElementsAre(1, 1, 0));
  ASSERT_EQ(scene.scene.instances_size(), 2);
  EXPECT_THAT(column3(scene.scene.instances(0).world_from_instance()), ElementsAre(1, 0, 0));
  EXPECT_THAT(column3(scene.scene.instances(1).world_from_instance()), ElementsAre(1, 0, 5));
  EXPECT_EQ(scene.scene.shapes_size(), 0);
}

TEST_F(PbrtScene, ObjectsMayHoldOthers) {
  const ImportedScene scene = world(
      "ObjectBegin \"leaf\" Shape \"disk\" ObjectEnd ObjectBegin \"nothing\" ObjectEnd\n"
      "Translate 1 0 0 ObjectBegin \"tree\" Translate 0 2 0 ObjectInstance \"leaf\" ObjectInstance "
      "\"nothing\" ObjectEnd\n"
      "ObjectBegin \"unused\" ObjectInstance \"tree\" ObjectEnd\n"
      "ObjectBegin \"forest\" ObjectInstance \"tree\" Scale -1 1 1 ObjectInstance \"tree\" ObjectEnd\n"
      "ObjectInstance \"forest\"\n");
  ASSERT_EQ(scene.scene.objects_size(), 3);
  EXPECT_EQ(scene.scene.objects(0).name(), "leaf");
  const v1::Object& tree = scene.scene.objects(1);
  EXPECT_EQ(tree.shapes_size(), 0);
  ASSERT_EQ(tree.instances_size(), 1);
  EXPECT_EQ(tree.instances(0).object(), "leaf");
  EXPECT_THAT(column3(tree.instances(0).world_from_instance()), ElementsAre(1, 2, 0));
  EXPECT_EQ(scene.scene.objects(2).instances_size(), 2);
  EXPECT_EQ(scene.scene.instances_size(), 1);
}

TEST_F(PbrtScene, IncludesActInPlaceAndImportsDoNotLeak) {
  write("parts/more words.pbrt", "Translate 1 0 0 Material \"diffuse\" Shape \"sphere\"");
  const ImportedScene scene = world(
      "Import \"parts/more words.pbrt\" Shape \"sphere\" Include \"parts/more words.pbrt\" Shape \"sphere\"");
  ASSERT_EQ(scene.scene.shapes_size(), 4);
  const double xs[] = {1, 0, 1, 1};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(column3(scene.scene.shapes(i).world_from_object())[0], xs[i]) << i;
  EXPECT_EQ(scene.scene.shapes(1).material(), "");
  EXPECT_EQ(scene.scene.shapes(2).material(), scene.scene.shapes(3).material());
}

TEST_F(PbrtScene, ReadsCommentsEscapesAndOddNumbers) {
  const ImportedScene scene = world(
      "Shape \"trianglemesh\" # the floor\n  \"point3 P\" [ # corners\n -0 0 0  +1 0 4.37114e-8 # one\n 0 1 "
      "0 ] # "
      "done\n"
      "  # nothing\n  \"integer indices\" [0 1 2]\"string nonsense\"[\"a \\\"b\\\"\"]\n");
  ASSERT_EQ(scene.scene.shapes_size(), 1);
  EXPECT_THAT(warnings_of(scene),
              HasSubstr("scene.pbrt:7:28: parameter \"string nonsense\" of shape \"trianglemesh\" is not "
                        "known: it is ignored"));
}

TEST_F(PbrtScene, EqualMeshesAreOneBlob) {
  const ImportedScene scene = world(std::string(kTriangle) + "Translate 1 1 1\n" + kTriangle);
  EXPECT_EQ(scene.scene.shapes_size(), 2);
  EXPECT_THAT(scene.blobs, SizeIs(1));
  EXPECT_EQ(scene.scene.shapes(0).mesh().blob().digest(), scene.blobs[0].ref.digest());
  EXPECT_EQ(scene.scene.shapes(0).mesh().blob().size_bytes(), scene.blobs[0].bytes.size());
}

TEST_F(PbrtScene, FacesTurnToTheirVertexNormals) {
  // pbrt: with vertex normals, the geometric normal is on their side whatever the winding.
  const ImportedScene scene = world(
      "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"normal N\" [ 0 0 -1 0 0 -1 0 0 -1 ]");
  const auto mesh = wire::decode_mesh(scene.blobs.at(0).bytes);
  ASSERT_TRUE(mesh.ok());
  EXPECT_THAT(mesh->indices, ElementsAre(0, 2, 1));
}

TEST_F(PbrtScene, ReadsCompressedFiles) {
  // gzip of "WorldBegin Shape \"sphere\"\n", made with zlib at its default level.
  const unsigned char bytes[] = {0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x03, 0x0b, 0xcf,
                                 0x2f, 0xca, 0x49, 0x71, 0x4a, 0x4d, 0xcf, 0xcc, 0x53, 0x08, 0xce, 0x48,
                                 0x2c, 0x48, 0x55, 0x50, 0x2a, 0x2e, 0xc8, 0x48, 0x2d, 0x4a, 0x55, 0xe2,
                                 0x02, 0x00, 0x74, 0xab, 0x29, 0x3e, 0x1a, 0x00, 0x00, 0x00};
  const std::string_view all(reinterpret_cast<const char*>(bytes), sizeof(bytes));
  const auto scene = import_scene(write("a.pbrt.gz", all));
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->scene.shapes_size(), 1);
  EXPECT_EQ(scene->scene.name(), "a");
  for (std::size_t size = 0; size < all.size(); ++size) {
    EXPECT_FALSE(import_scene(write("cut.pbrt.gz", all.substr(0, size))).ok()) << size;
  }
}

TEST_F(PbrtScene, NamesInOtherEncodingsStayApart) {
  // Latin-1, which protobuf would refuse to read back.
  const ImportedScene scene = world(
      "MakeNamedMaterial \"M\xf6"
      "bel\" \"string type\" \"diffuse\" MakeNamedMaterial \"M\xe4"
      "bel\" \"string type\" "
      "\"diffuse\"\nMakeNamedMaterial \"\xc3\xb6\" \"string type\" \"diffuse\"\n"
      "NamedMaterial \"M\xf6"
      "bel\" Shape \"sphere\" NamedMaterial \"M\xe4"
      "bel\" Shape \"sphere\" NamedMaterial "
      "\"\xc3\xb6\" Shape \"sphere\"");
  ASSERT_EQ(scene.scene.materials_size(), 3);
  EXPECT_EQ(scene.scene.shapes(0).material(), "M%F6bel");
  EXPECT_EQ(scene.scene.shapes(1).material(), "M%E4bel");
  EXPECT_EQ(scene.scene.shapes(2).material(), "\xc3\xb6");
  EXPECT_EQ(scene.scene.materials(0).name(), scene.scene.shapes(0).material());
  v1::Scene copy;
  EXPECT_TRUE(copy.ParseFromString(scene.scene.SerializeAsString()));
}

TEST_F(PbrtScene, PartialSpheresAreClampedAsInPbrt) {
  const ImportedScene scene = world(
      "Shape \"sphere\" \"float radius\" 2 \"float zmin\" 1 \"float zmax\" -1 \"float phimax\" 90\n"
      "Shape \"sphere\" \"float zmin\" -5 \"float zmax\" 5 \"float phimax\" 400\n");
  EXPECT_FLOAT_EQ(scene.scene.shapes(0).sphere().z_min(), -1);
  EXPECT_FLOAT_EQ(scene.scene.shapes(0).sphere().z_max(), 1);
  EXPECT_FLOAT_EQ(scene.scene.shapes(0).sphere().phi_max_degrees(), 90);
  const v1::Sphere& whole = scene.scene.shapes(1).sphere();
  EXPECT_FALSE(whole.has_z_min() || whole.has_z_max() || whole.has_phi_max_degrees());
}

TEST_F(PbrtScene, ShapesOfItsOwnLanguageAreThoseMessages) {
  const ImportedScene scene = world(
      "Shape \"halfspace\" \"float height\" 2\n"
      "Shape \"cone\" \"float radius\" 3 \"float topradius\" 1 \"float height\" 2 \"bool capped\" \"true\" "
      "\"float phimax\" 90\n"
      "Shape \"polygon\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ]\n"
      "Shape \"box\" \"point3 p0\" [ 1 2 3 ] \"point3 p1\" [ 4 5 6 ]\n"
      "Shape \"polyhedron\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0  0 0 1 ]\n"
      "Shape \"polyhedron\" \"float planes\" [ 1 0 0 1  0 1 0 1  0 0 1 1  -1 -1 -1 1 ]\n"
      "Shape \"torus\" \"float majorradius\" 2\n"
      "Shape \"ellipsoid\" \"vector3 radii\" [ 1 2 3 ]\n"
      "Shape \"cylinder\" \"bool capped\" \"true\"\n");
  ASSERT_EQ(scene.scene.shapes_size(), 9);
  const auto shape = [&](int i) { return scene.scene.shapes(i); };
  EXPECT_EQ(shape(0).half_space().height(), 2);
  EXPECT_EQ(shape(1).cone().radius(), 3);
  EXPECT_EQ(shape(1).cone().top_radius(), 1);
  EXPECT_EQ(shape(1).cone().phi_max_degrees(), 90);
  EXPECT_TRUE(shape(1).cone().capped());
  EXPECT_THAT(shape(2).polygon().corners(), ElementsAre(0, 0, 0, 1, 0, 0, 0, 1, 0));
  EXPECT_THAT(shape(3).box().low(), ElementsAre(1, 2, 3));
  EXPECT_THAT(shape(3).box().high(), ElementsAre(4, 5, 6));
  EXPECT_EQ(shape(4).polyhedron().vertices_size(), 12);
  EXPECT_EQ(shape(5).polyhedron().planes_size(), 16);
  EXPECT_EQ(shape(6).torus().major_radius(), 2);
  EXPECT_EQ(shape(6).torus().minor_radius(), 0.25);
  EXPECT_THAT(shape(7).ellipsoid().radii(), ElementsAre(1, 2, 3));
  EXPECT_TRUE(shape(8).cylinder().capped());
  EXPECT_EQ(warnings_of(scene), "");
}

TEST_F(PbrtScene, PowerOfABoxIsThatOfItsArea) {
  const ImportedScene scene = world(
      "Scale 2 1 1 AreaLightSource \"diffuse\" \"float power\" 100 Shape \"box\" \"point3 p0\" [ 0 0 0 ] "
      "\"point3 p1\" [ 1 1 1 ]\n");
  // Sides of 2, 1 and 1: an area of 10.
  EXPECT_NEAR(scene.scene.shapes(0).area_light().scale() * M_PI * 10, 100, 1e-3);
}

TEST_F(PbrtScene, WhatIsDefinedLaterIsFound) {
  // pbrt-v4 looks names up when it has read everything.
  const ImportedScene scene = world(
      "AreaLightSource \"diffuse\" NamedMaterial \"none\" Shape \"sphere\" \"texture alpha\" \"a\" "
      "ObjectInstance "
      "\"o\"\n"
      "MakeNamedMaterial \"none\" \"string type\" \"interface\" Texture \"a\" \"float\" \"constant\" \"float "
      "value\" "
      ".5\n"
      "AttributeBegin ObjectBegin \"o\" Shape \"disk\" ObjectEnd AttributeEnd\n");
  EXPECT_EQ(scene.scene.shapes(0).alpha().texture(), "a");
  EXPECT_FALSE(scene.scene.shapes(0).has_area_light());
  EXPECT_EQ(scene.scene.instances_size(), 1);
  EXPECT_THAT(warnings_of(scene), HasSubstr("interface material is ignored"));
}

TEST_F(PbrtScene, DefinitionsWithoutEffectAreWarnedOf) {
  const auto scene = import_scene(write("a.pbrt", "WorldBegin"), {.threads = 1, .defines = {{"x", "1"}}});
  ASSERT_TRUE(scene.ok());
  EXPECT_THAT(warnings_of(*scene), HasSubstr("definitions have no effect"));
}

TEST_F(PbrtScene, NamesWhatIsMissing) {
  const ImportedScene scene = world(
      "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\nMediumInterface \"fog\" \"\"\nMaterial "
      "\"interface\"\n"
      "AreaLightSource \"diffuse\"\nShape \"sphere\"\nScale 1 0 1 Shape \"sphere\"\n");
  ASSERT_EQ(scene.scene.shapes_size(), 1);
  EXPECT_FALSE(scene.scene.shapes(0).has_area_light());
  EXPECT_THAT(warnings_of(scene),
              HasSubstr("scene.pbrt:6:1: an area light on a shape of interface material is ignored"));
  EXPECT_THAT(warnings_of(scene), HasSubstr("its transformation is singular"));
}

TEST_F(PbrtScene, LightsMoveWithinTheExposure) {
  // It moves by 8 along x from time 0 to 2; the shutter is open from 0.5 to 1: from x = 2 to x = 4.
  const auto result = import_text(
      "TransformTimes 0 2\nCamera \"perspective\" \"float shutteropen\" .5 \"float shutterclose\" 1\n"
      "WorldBegin\nActiveTransform EndTime Translate 8 0 0 ActiveTransform All\n"
      "LightSource \"point\" \"point3 from\" [0 1 0]\n"
      "LightSource \"spot\" \"point3 from\" [0 2 0] \"point3 to\" [0 0 0]\n"
      "LightSource \"distant\"\nLightSource \"infinite\"\nLightSource \"goniometric\"\n"
      "AreaLightSource \"diffuse\" Shape \"sphere\"\n");
  ASSERT_TRUE(result.ok()) << result.status();
  const v1::Scene& scene = result->scene;
  EXPECT_EQ(scene.lights(0).point().position().x(), 2);
  EXPECT_EQ(scene.lights(0).point().position_end().x(), 4);
  EXPECT_EQ(scene.lights(0).point().position_end().y(), 1);
  EXPECT_EQ(scene.lights(1).spot().target().x(), 2);
  EXPECT_EQ(scene.lights(1).spot().position_end().x(), 4);
  EXPECT_EQ(scene.lights(1).spot().target_end().x(), 4);
  EXPECT_EQ(scene.lights(2).distant().direction_end().z(), 1);
  EXPECT_THAT(column3(scene.lights(4).goniometric().world_from_light_end()), ElementsAre(4, 0, 0));
  EXPECT_THAT(column3(scene.shapes(0).world_from_object_end()), ElementsAre(4, 0, 0));
  EXPECT_EQ(warnings_of(*result).find("move"), std::string::npos);
}

TEST_F(PbrtScene, MediaFollowTheGraphicsState) {
  const auto result = import_text(
      "MakeNamedMedium \"air\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 1 2 3 ] \"rgb sigma_s\" [ 3 "
      "2 1 ]\n"
      "  \"float scale\" 2 \"float g\" .5 \"rgb Le\" [ 1 0 0 ] \"float Lescale\" 4\n"
      "MakeNamedMedium \"unused\" \"string type\" \"homogeneous\"\nMediumInterface \"\" \"air\"\nCamera "
      "\"orthographic\"\n"
      "Integrator \"simplevolpath\"\nWorldBegin\nMediumInterface \"air\" \"\" Shape \"sphere\" "
      "MediumInterface "
      "\"air\" Shape "
      "\"disk\"\n");
  ASSERT_TRUE(result.ok()) << result.status();
  const v1::Scene& scene = result->scene;
  EXPECT_EQ(scene.camera().medium(), "air");
  EXPECT_TRUE(scene.camera().has_orthographic());
  EXPECT_EQ(scene.settings().integrator(), "volpath");
  EXPECT_EQ(scene.shapes(0).interior_medium(), "air");
  EXPECT_EQ(scene.shapes(0).exterior_medium(), "");
  EXPECT_EQ(scene.shapes(1).interior_medium(), "");  // the same on both sides: no border
  ASSERT_EQ(scene.media_size(), 1);
  const v1::Medium& air = scene.media(0);
  EXPECT_FLOAT_EQ(air.extinction().constant().rgb().r(), 4);
  EXPECT_FLOAT_EQ(air.sigma_s().constant().rgb().b(), 1);
  EXPECT_FLOAT_EQ(air.scale(), 2);
  EXPECT_FLOAT_EQ(air.g(), 0.5f);
  EXPECT_FLOAT_EQ(air.emission().constant().rgb().r(), 4);
  EXPECT_EQ(warnings_of(*result), "");
}

TEST_F(PbrtScene, GridsOfDensityKeepWhatWasMeasured) {
  const auto fog = [&](const std::string& parameters) {
    return world(
               "MakeNamedMedium \"fog\" \"string type\" \"uniformgrid\" \"integer nx\" 2 "
               "\"float density\" [ 0.5 1 ] " +
               parameters + "\nMediumInterface \"fog\" \"\" Shape \"sphere\"\n")
        .scene.media(0);
  };
  const std::string measured =
      "\"spectrum sigma_a\" [ 400 1 700 3 ] \"spectrum sigma_s\" [ 400 3 700 1 ] "
      "\"blackbody Le\" 3000 \"float Lescale\" [ 1 0 ]";
  const v1::Medium medium = fog(measured);
  const v1::SampledSpectrum& sigma_t = medium.extinction().grid().factor().sampled();
  EXPECT_THAT(sigma_t.wavelengths_nm(), ElementsAre(400, 700));
  EXPECT_THAT(sigma_t.values(), ElementsAre(4, 4));
  const v1::SampledSpectrum& albedo = medium.albedo().constant().sampled();
  ASSERT_GT(albedo.values_size(), 300);
  EXPECT_FLOAT_EQ(albedo.wavelengths_nm(190), 550);
  EXPECT_FLOAT_EQ(albedo.values(190), 0.5f);
  EXPECT_FLOAT_EQ(albedo.values(0), 0.75f);
  EXPECT_TRUE(medium.emission().grid().factor().has_sampled());
  // In jobs of RGB it is the medium of these colours.
  const auto& rgb = medium.extinction().grid().factor().in_rgb();
  EXPECT_NEAR(rgb.r(), 4, 0.01);
  EXPECT_NEAR(rgb.b(), 4, 0.01);
  EXPECT_GT(medium.albedo().constant().in_rgb().b(), medium.albedo().constant().in_rgb().r());
  // Of colours, everything is in the grid.
  const v1::Medium colours = fog("\"rgb sigma_a\" [ 1 2 3 ] \"rgb sigma_s\" [ 3 2 2 ]");
  EXPECT_FALSE(colours.extinction().grid().has_factor());
  EXPECT_FLOAT_EQ(colours.albedo().constant().rgb().r(), 0.75f);
}

TEST_F(PbrtScene, WhatNobodyAsksForIsSaidOfEveryDirective) {
  const ImportedScene scene = world(
      "AttributeBegin AreaLightSource \"diffuse\" \"float brightness\" 3\n"
      "Shape \"sphere\" Shape \"disk\"\nAttributeEnd\n"
      "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"float thickness\" 1\n"
      "Texture \"t\" \"spectrum\" \"checkerboard\" \"float texture1\" 1 \"bool odd\" true\n"
      "Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"\n"
      "Material \"diffuse\" \"float albedo\" 1\n"
      "MakeNamedMaterial \"m\" \"string type\" \"hair\" \"float eumelanin\" 8\n");
  const std::string warnings = warnings_of(scene);
  // Two shapes share one light: its parameters are counted together.
  EXPECT_THAT(warnings, HasSubstr("scene.pbrt:2:42: parameter \"float brightness\" of"));
  EXPECT_THAT(warnings,
              Not(HasSubstr("brightness\" of area light \"diffuse\" is not known: it is ignored (and")));
  EXPECT_THAT(warnings, HasSubstr("parameter \"float thickness\" of"));
  EXPECT_THAT(warnings, HasSubstr("parameter \"bool odd\" of"));
  // A material of no shape has no effect as a whole.
  EXPECT_THAT(warnings, Not(HasSubstr("albedo")));
  EXPECT_THAT(warnings, Not(HasSubstr("eumelanin")));
}

}  // namespace
}  // namespace tessera::client
