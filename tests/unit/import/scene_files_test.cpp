// Tessera's own scene files, and the scenes that come with the source.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "unit/import/import_fixture.h"

namespace tessera::client {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

class SceneFiles : public ImportTest {};

constexpr char kPlyTriangle[] =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
    "face 1\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// Faults that are found from outside are told at the lines of their shapes, operands among them.
TEST_F(SceneFiles, FaultsOfShapesHaveTheirLines) {
  const auto told = [](const absl::StatusOr<ImportedScene>& imported) {
    std::vector<SceneFault> faults;
    for (const v1::Shape& shape : imported.value().scene.shapes()) {
      if (shape.has_torus()) faults.push_back({&shape, "", "is bad"});
      for (const v1::Csg::Part& part : shape.csg().parts())
        if (part.solid().has_box()) faults.push_back({&part.solid(), "", "is flat"});
    }
    return std::string(status_of(faults, *imported).message());
  };
  const std::string text = told(import_scene(write("s.textproto", R"(shapes { sphere { radius: 1 } }
shapes { torus {} name: 'ring' }
shapes { csg { parts { solid { sphere { radius: 1 } } }
  parts { solid { box {} } } } })")));
  EXPECT_THAT(text, AllOf(HasSubstr("s.textproto:2:1: shape (ring): is bad"),
                          HasSubstr("s.textproto:4:11: shape: is flat")));
  const std::string pbrt = told(import_scene(write("s.pbrt", R"(Camera "perspective"
WorldBegin
  Shape "torus" "float majorradius" 1 "float minorradius" 0.5
CSGBegin "union"
  Shape "sphere"
    Shape "box" "point3 p0" [0 0 0] "point3 p1" [1 1 1]
CSGEnd
)")));
  EXPECT_THAT(pbrt, AllOf(HasSubstr("s.pbrt:3:3: torus: is bad"), HasSubstr("s.pbrt:6:5: box: is flat")));
}

TEST_F(SceneFiles, TextScenesNameFiles) {
  write("meshes/t.ply", kPlyTriangle);
  write("sky.pfm", "picture");
  const auto scene = import_scene(write("s.textproto",
                                        "shapes { mesh { blob { path: \"meshes/t.ply\" } } }\n"
                                        "lights { infinite { image { path: \"sky.pfm\" } } }\n"));
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_THAT(scene->blobs, SizeIs(2));
  EXPECT_EQ(scene->scene.name(), "s");
  EXPECT_EQ(scene->scene.shapes(0).mesh().blob().digest(), scene->blobs[0].ref.digest());
  EXPECT_TRUE(wire::decode_mesh(scene->blobs[0].bytes).ok());
  EXPECT_EQ(scene->scene.lights(0).infinite().image().size_bytes(), 7u);
  EXPECT_EQ(scene->blobs[1].file, (folder_ / "sky.pfm").string());
}

TEST_F(SceneFiles, WrongSettingsAreAnsweredWithTheNamesThereAre) {
  const auto error = [&](const std::string& settings) {
    return error_of(import_scene(write("s.textproto", "settings { " + settings + " }\n")));
  };
  EXPECT_THAT(error("traversal: TRAVERSAL_PACKAGE"),
              AllOf(HasSubstr("s.textproto:1:"), HasSubstr("TRAVERSAL_PACKAGE"),
                    HasSubstr("There is: TRAVERSAL_PACKET, TRAVERSAL_SINGLE")));
  EXPECT_THAT(error("mlt { kind: MUTATION_KIND_PATH }"),
              AllOf(HasSubstr("s.textproto:1:"), HasSubstr("has no field named \"kind\"")));
  // The form of older versions.
  EXPECT_THAT(error("sampler: \"sobol\""), HasSubstr("There is: SAMPLER_SOBOL"));
  EXPECT_THAT(error("intersection: \"auto\""), HasSubstr("INTERSECTION_AUTO"));
}

TEST_F(SceneFiles, SettingsOfAnotherVersionAreLeftOutWithAWarning) {
  // Field 2 of the settings, the sampler when it was a string.
  const auto scene =
      import_scene(write("s.tsb", ImportedScene{}.scene.SerializeAsString() + "\x52\x07\x12\x05sobol"));
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->scene.settings().sampler(), v1::SAMPLER_UNSPECIFIED);
  ASSERT_FALSE(scene->warnings.empty());
  EXPECT_THAT(to_string(scene->warnings[0]), HasSubstr("another version wrote this file"));
}

TEST_F(SceneFiles, WrittenScenesReadBackTheSame) {
  write("t.ply", kPlyTriangle);
  write("a.png", "picture");
  const ImportedScene scene = world(
      "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" Material \"diffuse\" \"texture "
      "reflectance\" \"t\"\n"
      "Shape \"plymesh\" \"string filename\" \"t.ply\" Shape \"sphere\" \"texture alpha\" \"f\"\n"
      "Texture \"f\" \"float\" \"imagemap\" \"string filename\" \"a.png\"\n");
  for (const char* name : {"out/copy.textproto", "out/copy.pbtxt", "out/copy.tsb"}) {
    std::filesystem::create_directories(folder_ / "out");
    ASSERT_TRUE(write_scene(scene, folder_ / name).ok());
    const auto copy = import_scene(folder_ / name);
    ASSERT_TRUE(copy.ok()) << copy.status();
    // All is the same but where the blobs lie.
    v1::Scene expected = scene.scene, found = copy->scene;
    for (v1::Scene* s : {&expected, &found}) {
      s->mutable_shapes(0)->mutable_mesh()->mutable_blob()->clear_path();
      for (v1::Texture& texture : *s->mutable_textures())
        texture.mutable_image()->mutable_image()->clear_path();
    }
    EXPECT_EQ(found.SerializeAsString(), expected.SerializeAsString());
    std::set<std::string> digests, expected_digests;
    for (const SceneBlob& blob : copy->blobs) digests.insert(blob.ref.digest());
    for (const SceneBlob& blob : scene.blobs) expected_digests.insert(blob.ref.digest());
    EXPECT_EQ(digests, expected_digests);
    // And once more, over itself.
    ASSERT_TRUE(write_scene(*copy, folder_ / name).ok());
    EXPECT_TRUE(import_scene(folder_ / name).ok());
  }
  EXPECT_EQ(write_scene(scene, folder_ / "out/copy.pbrt").code(), absl::StatusCode::kUnimplemented);
  EXPECT_FALSE(write_scene(scene, folder_ / "nowhere\0/copy.tsb").ok());
}

TEST_F(SceneFiles, ErrorsHaveLines) {
  write("bad.tsr", "TSRMESH1");
  write("bad.ply", "plx");
  const std::string message = error_of(import_scene(
      write("s.textproto",
            "name: \"x\"\nshapes {\n  mesh { blob { path: \"no.ply\" } }\n}\nshapes { mesh { blob { path: "
            "\"bad.tsr\" } } }\nshapes { mesh { blob { path: \"bad.ply\" } } }\nshapes { mesh { blob {} } }\n"
            "lights { infinite { image { path: \"s.textproto\" digest: \"00\" } } }\n")));
  EXPECT_THAT(message,
              AllOf(HasSubstr("s.textproto:3: "), HasSubstr("no.ply"), HasSubstr("s.textproto:5: "),
                    HasSubstr("mesh blob"), HasSubstr("s.textproto:6: "), HasSubstr("not a PLY file"),
                    HasSubstr("s.textproto:7: expected \"path\""), HasSubstr("s.textproto:8: ")));
  EXPECT_THAT(message, HasSubstr("not 00 as the scene says"));
  EXPECT_THAT(error_of(import_scene(write("t.textproto", "name: \"a\"\n  colour: 3\n"))),
              AllOf(HasSubstr("t.textproto:2:"), HasSubstr("colour")));
  EXPECT_THAT(error_of(import_scene(write("u.tsb", "\xff\xff\xff"))), HasSubstr("not a serialized Scene"));
}

TEST_F(SceneFiles, FirstLightParses) {
  const auto scene = import_scene("scenes/first-light/scene.textproto");
  ASSERT_TRUE(scene.ok()) << scene.status();
  std::set<std::string> names;
  for (const v1::Material& material : scene->scene.materials()) names.insert(material.name());
  for (const v1::Shape& shape : scene->scene.shapes()) {
    EXPECT_TRUE(shape.material().empty() || names.contains(shape.material())) << shape.material();
    EXPECT_TRUE(!shape.has_world_from_object() || shape.world_from_object().elements_size() == 16);
  }
  EXPECT_GE(scene->scene.shapes_size(), 6);
}

TEST_F(SceneFiles, ScenesOfOurOwnImportWithoutWarningsAndAreShort) {
  int scenes = 0;
  for (const auto& folder : std::filesystem::directory_iterator("scenes")) {
    const std::filesystem::path file = folder.path() / "scene.textproto";
    if (!std::filesystem::exists(file)) continue;
    SCOPED_TRACE(file.string());
    ++scenes;
    const auto scene = import_scene(file.string());
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_EQ(warnings_of(*scene), "");
    EXPECT_EQ(scene->scene.name(), folder.path().filename().string());
    std::ifstream in(file);
    EXPECT_LT(std::count(std::istreambuf_iterator<char>(in), {}, '\n'), 100);
  }
  EXPECT_GE(scenes, 6);
}

TEST_F(SceneFiles, CornellBoxImportsWithoutWarnings) {
  const auto scene = import_scene("scenes/cornell-box/scene.pbrt");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->scene.shapes_size(), 8);
  EXPECT_EQ(scene->scene.settings().max_depth(), 63u);
  EXPECT_EQ(warnings_of(*scene), "");
}

TEST_F(SceneFiles, NamesOfNothingAreErrorsAllAtOnceWithTheNearestName) {
  const std::string message = error_of(import_scene(write("s.textproto",
                                                          R"(materials { name: "clay" diffuse {} }
materials { name: "glaze"
  mix { a: "clay"
        b: "glase" } }
materials { name: "clay" diffuse { reflectance { texture: "wood" } } }
textures { name: "woods" constant { constant: 1 } }
shapes { sphere { radius: 1 }
  material: "clai" }
shapes { sphere { radius: 1 } interior_medium: "fog" }
instances { object: "chair" }
objects { name: "chairs" shapes { sphere { radius: 1 } material: "Clay" } }
camera { perspective {} world_from_camera { elements: [1, 2, 3] } medium: "air" }
lights { scale: 2 }
materials { name: "flint" dielectric { dispersion { glass: "wate" } } }
)")));
  EXPECT_THAT(message, HasSubstr("s.textproto:14:40: there is no glass \"wate\"; did you mean 'water'?"));
  EXPECT_THAT(message, HasSubstr("s.textproto:8:3: there is no material \"clai\": did you mean \"clay\"?"));
  EXPECT_THAT(message, HasSubstr("s.textproto:4:9: there is no material \"glase\": did you mean \"glaze\"?"));
  EXPECT_THAT(message, HasSubstr("s.textproto:5:1: material \"clay\": the name is used twice"));
  EXPECT_THAT(message, HasSubstr("s.textproto:5:50: there is no texture \"wood\": did you mean \"woods\"?"));
  EXPECT_THAT(message, HasSubstr("s.textproto:9:31: there is no medium \"fog\""));
  EXPECT_THAT(message,
              HasSubstr("s.textproto:10:13: there is no object \"chair\": did you mean \"chairs\"?"));
  EXPECT_THAT(message, HasSubstr("s.textproto:11:56: there is no material \"Clay\": did you mean \"clay\"?"));
  EXPECT_THAT(message, HasSubstr("s.textproto:12:25: a matrix of 3 elements: expected 16"));
  EXPECT_THAT(message, HasSubstr("there is no medium \"air\""));
  EXPECT_THAT(message, HasSubstr("s.textproto:13:1: a light without a kind"));
}

TEST_F(SceneFiles, BadNumbersAreErrorsAllAtOnceAtTheirPlaces) {
  const std::string message = error_of(import_scene(write("s.textproto",
                                                          R"(shapes { name: "ball"
  sphere { radius: inf } }
shapes { material: "clai" sphere { radius: 1 }
  world_from_object { elements: [1, 0, 0, 0,
    0, nan, 0, 0, 0, 0, 1e30, 0, 0, 0, 0, 1] } }
lights { point { intensity { constant: -1e19 } } }
)")));
  EXPECT_THAT(message, HasSubstr("s.textproto:2:12: shapes[0].sphere.radius (ball): inf is not finite"));
  // The parser knows where a list begins.
  EXPECT_THAT(message,
              HasSubstr("s.textproto:4:3: shapes[1].world_from_object.elements[5]: nan is not finite"));
  EXPECT_THAT(message,
              HasSubstr("s.textproto:4:3: shapes[1].world_from_object.elements[10]: 1e+30 is beyond 1e+18"));
  EXPECT_THAT(message, HasSubstr("s.textproto:6:30: lights[0].point.intensity.constant: -1e+19 is beyond"));
  EXPECT_THAT(message, HasSubstr("s.textproto:3:10: there is no material \"clai\""));
}

TEST_F(SceneFiles, IndicesOfRefractionOutOfRangeAreErrorsAtTheirPlaces) {
  const std::string message =
      error_of(import_scene(write("s.textproto",
                                  "materials { name: 'g' dielectric { eta { constant: 0 } } }\n"
                                  "materials { name: 'h' hair { eta: 1e5 } }\n"
                                  "materials { name: 'p' principled { eta: 0 } }\n"
                                  "materials { name: 'o' dielectric {} }\n")));
  EXPECT_THAT(message,
              HasSubstr("s.textproto:1:1: material \"g\": an index of refraction of 0 is not between "
                        "0.0001 and 10000"));
  EXPECT_THAT(message, HasSubstr("s.textproto:2:1: material \"h\": an index of refraction of 100000"));
  EXPECT_THAT(message, HasSubstr("s.textproto:3:1: material \"p\""));
  EXPECT_THAT(message, Not(HasSubstr("\"o\"")));
}

TEST_F(SceneFiles, WordsOfSensorsAreErrorsAllAtOnceAtTheirPlaces) {
  const auto told = [&](const std::string& settings) {
    return error_of(import_scene(write("s.textproto", "settings {\n" + settings + "}\n")));
  };
  const std::string message =
      told("  sensor: \"nikon-d5200\"\n  white_balance: \"D56\"\n  film: \"spectral:0\"\n");
  EXPECT_THAT(message, HasSubstr("s.textproto:2:3: sensor: there is no sensor 'nikon-d5200'"));
  EXPECT_THAT(message, HasSubstr("did you mean 'nikon-d5100'?"));
  EXPECT_THAT(message, HasSubstr("s.textproto:3:3: white_balance: there is no illuminant 'D56'"));
  EXPECT_THAT(message, HasSubstr("did you mean 'D50'?"));
  EXPECT_THAT(message, HasSubstr("s.textproto:4:3: film: a spectral film has 1 to 512 bands, not '0'"));
  EXPECT_THAT(told("film: \"spectral:10000\""), HasSubstr("1 to 512 bands, not '10000'"));
  EXPECT_THAT(told("film: \"spectral:8:250-700\""), HasSubstr("wavelengths are 300 to 1000 nm"));
  EXPECT_THAT(told("sensor: \"band:900-1100\""), HasSubstr("wavelengths are 300 to 1000 nm"));
}

TEST_F(SceneFiles, ThousandsOfBadNumbersAreTwentyErrors) {
  std::string scene;
  for (int i = 0; i < 5000; ++i) scene += "shapes { sphere { radius: nan } }\n";
  const std::string message = error_of(import_scene(write("s.textproto", scene)));
  EXPECT_THAT(message, AllOf(HasSubstr("s.textproto:20:"), testing::Not(HasSubstr("s.textproto:21:")),
                             HasSubstr("stopped after 20 errors")));
}

TEST_F(SceneFiles, DarkScenesAndBrightSurfacesAreWarnedOf) {
  const auto dark = import_scene(write("s.textproto", "shapes { sphere { radius: 1 } }\n"));
  ASSERT_TRUE(dark.ok()) << dark.status();
  EXPECT_THAT(warnings_of(*dark), HasSubstr("the scene has no light"));
  const auto bright =
      import_scene(write("t.textproto",
                         "lights { point { intensity { constant: 1 } } }\n"
                         "materials { name: 'a' diffuse {\n  reflectance { constant { rgb { r: 0.5 "
                         "g: 1.5 b: 1 } } } } }\n"
                         "materials { name: 'b' diffuse { reflectance { constant { constant: 1 } } } }\n"));
  ASSERT_TRUE(bright.ok()) << bright.status();
  ASSERT_THAT(bright->warnings, SizeIs(1));
  EXPECT_THAT(warnings_of(*bright), HasSubstr("t.textproto:3:3: a reflectance of 1.5 gives back more light"));
}

}  // namespace
}  // namespace tessera::client
