// Files that are wrong: every one gives located messages, none a crash.
#include "unit/import/import_fixture.h"

namespace tessera::client {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class PbrtErrors : public ImportTest {
 protected:
  std::string error(const std::string& world_text) { return error_of(import_world(world_text)); }
};

TEST_F(PbrtErrors, SeveralAtOnceEachWithItsPlace) {
  const std::string message =
      error("Shap \"sphere\" [ 1 2 ]\nShape \"crate\"\n  Translate 1 x 2\nLightSource \"moon\"\n");
  EXPECT_THAT(message,
              AllOf(HasSubstr("scene.pbrt:2:1: unknown directive \"Shap\"\n"),
                    HasSubstr("scene.pbrt:3:1: unknown shape \"crate\": expected trianglemesh, plymesh"),
                    HasSubstr("scene.pbrt:4:15: expected a number from -1e18 to 1e18, found \"x\""),
                    HasSubstr("scene.pbrt:5:1: unknown light type \"moon\"")));
}

TEST_F(PbrtErrors, StopAfterTwenty) {
  std::string text;
  for (int i = 0; i < 100; ++i) text += "Shape \"crate\"\n";
  EXPECT_THAT(error(text), HasSubstr("stopped after 20 errors"));
}

TEST_F(PbrtErrors, NumbersMustBeFinite) {
  EXPECT_THAT(error("Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 nan 0  0 1 0 ]"),
              HasSubstr("scene.pbrt:2:44: expected a number from -1e18 to 1e18 for \"P\", found \"nan\""));
  EXPECT_THAT(error("Shape \"sphere\" \"float radius\" inf"), HasSubstr("found \"inf\""));
  EXPECT_THAT(error("Shape \"implicit\" \"string expression\" \"x + tan(y)\" \"float radius\" 1"),
              HasSubstr("shape \"implicit\": expression, column 5: 'tan' is unknown"));
  EXPECT_THAT(error("Shape \"implicit\" \"string expression\" \"x\""), HasSubstr("expected bounds"));
  EXPECT_THAT(
      error("Shape \"implicit\" \"string expression\" \"x\" \"float radius\" 1 \"string roots\" \"sturn\""),
      HasSubstr("sturm"));
  EXPECT_THAT(error("Translate 0 0 1e999"), HasSubstr("found \"1e999\""));
  EXPECT_THAT(error("Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 1e39 0  0 1 0 ]"),
              HasSubstr("scene.pbrt:2:44: expected a number from -1e18 to 1e18 for \"P\", found \"1e39\""));
}

TEST_F(PbrtErrors, IndicesOfRefractionAreBounded) {
  EXPECT_THAT(error("\nMaterial \"dielectric\" \"float eta\" 0 Shape \"sphere\""),
              HasSubstr("scene.pbrt:3:1: material \"dielectric\": an index of refraction of 0 is not between "
                        "0.0001 and 10000"));
  EXPECT_THAT(error("MakeNamedMaterial \"g\" \"string type\" \"thindielectric\" \"float eta\" 1e5\n"
                    "NamedMaterial \"g\" Shape \"sphere\""),
              HasSubstr("scene.pbrt:2:1: "));
  EXPECT_THAT(error("Material \"coateddiffuse\" \"float eta\" 0 Shape \"sphere\""),
              HasSubstr("an index of refraction of 0"));
}

TEST_F(PbrtErrors, FilmsAreBounded) {
  const auto film = [&](const std::string& sides) {
    return import_text("Film \"rgb\" " + sides + " WorldBegin Shape \"sphere\"");
  };
  EXPECT_TRUE(film("\"integer xresolution\" 100000 \"integer yresolution\" 1").ok());
  EXPECT_THAT(
      error_of(film("\"integer xresolution\" 1000001 \"integer yresolution\" 1")),
      HasSubstr("scene.pbrt:1:1: film: a resolution of 1000001x1 is not possible: 1 to 1000000 each way"));
  EXPECT_THAT(error_of(film("\"integer xresolution\" 100000 \"integer yresolution\" 100000")),
              HasSubstr("at most 2^32 in all"));
}

TEST_F(PbrtErrors, MeshesMustFit) {
  const std::string p = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] ";
  EXPECT_THAT(error(p + "\"integer indices\" [ 0 1 3 ]"),
              HasSubstr("index 3 (number 2) is out of range: there are 3 vertices"));
  EXPECT_THAT(error(p + "\"integer indices\" [ 0 1 -1 ]"), HasSubstr("index -1"));
  EXPECT_THAT(error(p + "\"integer indices\" [ 0 1 ]"),
              HasSubstr("expected a multiple of 3 indices, found 2"));
  EXPECT_THAT(error(p + "\"integer indices\" [ 0 1 1.5 ]"), HasSubstr("expected 32-bit integers"));
  EXPECT_THAT(error(p + "\"normal N\" [ 0 0 1 ]"), HasSubstr("there are 1 normals for 3 vertices"));
  EXPECT_THAT(error(p + "\"point2 uv\" [ 0 0 1 ]"), HasSubstr("point2 takes 2 numbers a value, found 3"));
  EXPECT_THAT(error("Shape \"trianglemesh\""), HasSubstr("expected vertex positions"));
  EXPECT_THAT(error("Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 1 1 0 ]"),
              HasSubstr("\"integer indices\""));
}

TEST_F(PbrtErrors, FilesMustBeThere) {
  EXPECT_THAT(error("Shape \"plymesh\" \"string filename\" \"no.ply\""),
              AllOf(HasSubstr("scene.pbrt:2:1"), HasSubstr("no.ply")));
  EXPECT_THAT(error("Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"no.png\""),
              HasSubstr("scene.pbrt:2:1: texture file \"no.png\" does not exist"));
  EXPECT_THAT(error("LightSource \"infinite\" \"string filename\" \"no.pfm\""),
              HasSubstr("no.pfm: no such file"));
  EXPECT_THAT(error("Include \"no.pbrt\""), AllOf(HasSubstr("scene.pbrt:2:1"), HasSubstr("no.pbrt")));
  EXPECT_THAT(error("Include \".\""), HasSubstr("not a regular file"));
  EXPECT_THAT(error("Material \"diffuse\" \"spectrum reflectance\" \"metal-Xx-eta\" Shape \"sphere\""),
              HasSubstr("\"metal-Xx-eta\" is neither a named spectrum nor a file"));
  EXPECT_EQ(import_scene(folder_ / "absent.pbrt").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(PbrtErrors, PlyErrorsNameBothFiles) {
  write("bad.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
  EXPECT_THAT(error("\nShape \"plymesh\" \"string filename\" \"bad.ply\""),
              AllOf(HasSubstr("scene.pbrt:3:1"), HasSubstr("bad.ply: the header has no \"end_header\"")));
}

TEST_F(PbrtErrors, BlocksMustBalance) {
  EXPECT_THAT(error("AttributeBegin\n"), HasSubstr("scene.pbrt:2:1: this block is never closed"));
  EXPECT_THAT(error("AttributeEnd\n"), HasSubstr("AttributeEnd without its beginning"));
  EXPECT_THAT(error("ObjectEnd\n"), HasSubstr("ObjectEnd without ObjectBegin"));
  EXPECT_THAT(error("AttributeBegin ObjectBegin \"a\" AttributeEnd"),
              HasSubstr("the block that is open began on line 2"));
  EXPECT_THAT(error("ObjectBegin \"a\" ObjectBegin \"b\" ObjectEnd ObjectEnd"),
              HasSubstr("inside of another object"));
  EXPECT_THAT(error("ObjectBegin \"a\" ObjectInstance \"a\" ObjectEnd"),
              HasSubstr("inside of an object: object \"a\" is not complete here"));
  EXPECT_THAT(error("ObjectBegin \"a\" ObjectInstance \"b\" ObjectEnd"), HasSubstr("is not complete here"));
  EXPECT_THAT(error("ObjectInstance \"a\""), HasSubstr("there is no object \"a\""));
}

TEST_F(PbrtErrors, OrderMatters) {
  EXPECT_THAT(error_of(import_text("Shape \"sphere\"")), HasSubstr("Shape is only allowed after WorldBegin"));
  EXPECT_THAT(error("Camera \"perspective\""), HasSubstr("Camera is only allowed before WorldBegin"));
  EXPECT_THAT(error("WorldBegin"), HasSubstr("WorldBegin is only allowed before WorldBegin"));
  EXPECT_THAT(error_of(import_text("")), HasSubstr("expected WorldBegin"));
}

TEST_F(PbrtErrors, IncludesMustEnd) {
  write("loop.pbrt", "Include \"loop.pbrt\"");
  EXPECT_THAT(error("Include \"loop.pbrt\""),
              AllOf(HasSubstr("loop.pbrt:1:1"), HasSubstr("includes itself")));
  EXPECT_THAT(error("Import \"scene.pbrt\""), HasSubstr("includes itself"));
  for (int i = 0; i < 100; ++i) {
    write("deep" + std::to_string(i) + ".pbrt", "Include \"deep" + std::to_string(i + 1) + ".pbrt\"");
  }
  EXPECT_THAT(error("Include \"deep0.pbrt\""), HasSubstr("files are included more than 63 deep"));
}

TEST_F(PbrtErrors, SyntaxOfParameters) {
  EXPECT_THAT(error("Shape \"sphere\" \"radius\" 1"),
              HasSubstr("expected a parameter as in \"float radius\", found \"radius\""));
  EXPECT_THAT(error("Shape \"sphere\" \"real radius\" 1"), HasSubstr("unknown parameter type \"real\""));
  EXPECT_THAT(error("Shape \"sphere\" \"float radius\" [ 1"),
              HasSubstr("expected \"]\" after the values of \"radius\""));
  EXPECT_THAT(error("Shape \"sphere\" \"float radius\""), HasSubstr("found the end of the file"));
  EXPECT_THAT(error("Shape \"sphere\" \"float radius\" Shape \"sphere\""),
              HasSubstr("expected the value of \"radius\""));
  EXPECT_THAT(error("Shape \"sphere\" \"integer radius\" 1"),
              HasSubstr("expected type float, found integer"));
  EXPECT_THAT(error("Shape \"sphere\" \"float radius\" [ 1 2 ]"), HasSubstr("expected one value, found 2"));
  EXPECT_THAT(error("Shape \"sphere\" \"float radius\" 1 \"float radius\" 1"), HasSubstr("is given twice"));
  EXPECT_THAT(error("Shape \"sphere\" \"float radius\" \"one\""), HasSubstr("found the string \"one\""));
  EXPECT_THAT(error("AreaLightSource \"diffuse\" \"bool twosided\" maybe Shape \"sphere\""),
              HasSubstr("expected true or false"));
  EXPECT_THAT(error("Shape sphere"), HasSubstr("expected the type or name of Shape in quotes"));
  EXPECT_THAT(error("Shape \"sphere"), HasSubstr("a string without a closing quote"));
}

TEST_F(PbrtErrors, ReferencesMustExistAndEnd) {
  EXPECT_THAT(error("NamedMaterial \"x\" Shape \"sphere\""), HasSubstr("there is no material \"x\""));
  EXPECT_THAT(error("Material \"diffuse\" \"texture reflectance\" \"x\" Shape \"sphere\""),
              HasSubstr("there is no spectrum texture \"x\""));
  EXPECT_THAT(error("MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [ \"m\" \"m\" ] "
                    "NamedMaterial \"m\" "
                    "Shape \"sphere\""),
              HasSubstr("is a mix of itself"));
  EXPECT_THAT(
      error(
          "Texture \"a\" \"float\" \"scale\" \"texture tex\" \"a\" Shape \"sphere\" \"texture alpha\" \"a\""),
      HasSubstr("refers to itself"));
  EXPECT_THAT(error("MediumInterface \"fog\" \"\""), HasSubstr("there is no medium \"fog\""));
  EXPECT_THAT(error("Material \"glass\""), HasSubstr("unknown material type \"glass\": expected diffuse"));
  EXPECT_THAT(error("Texture \"t\" \"float\" \"clouds\""), HasSubstr("unknown texture type \"clouds\""));
}

TEST_F(PbrtErrors, ValuesMustMakeSense) {
  EXPECT_THAT(error_of(import_text("Film \"rgb\" \"integer xresolution\" 0 WorldBegin")),
              HasSubstr("a resolution of 0x720"));
  EXPECT_THAT(error_of(import_text("Film \"rgb\" \"integer xresolution\" 2000000000 WorldBegin")),
              HasSubstr("not possible"));
  EXPECT_THAT(error_of(import_text("Camera \"perspective\" \"float fov\" 180 WorldBegin")),
              HasSubstr("field of view"));
  EXPECT_THAT(error_of(import_text("Scale 0 1 1 Camera \"perspective\" WorldBegin")), HasSubstr("singular"));
  EXPECT_THAT(error_of(import_text("Rotate 90 0 0 0 WorldBegin")), HasSubstr("axis has no direction"));
  EXPECT_THAT(error("LightSource \"point\" \"rgb I\" [ 1 -1 0 ]"), HasSubstr("an RGB value is negative"));
  EXPECT_THAT(error("LightSource \"point\" \"blackbody I\" 0"), HasSubstr("above 0 kelvin"));
  EXPECT_THAT(error("LightSource \"point\" \"spectrum I\" [ 500 1 400 1 ]"), HasSubstr("must ascend"));
  EXPECT_THAT(error("Shape \"sphere\" \"float radius\" -1"), HasSubstr("radius -1 is not above 0"));
}

TEST_F(PbrtErrors, OtherFormatsAreRefusedByName) {
  const absl::Status status = import_scene(write("a.blend", "")).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("expected .pbrt, .pbrt.gz, .xml, .gltf, .glb, .obj, .stl, .fbx, .dae, .textproto, "
                        ".pbtxt or .tsb"));
}

}  // namespace
}  // namespace tessera::client
