// Photometric files that scenes of all formats name, and units that formats have.
#include <numbers>

#include "import/lamp/lamp_file.h"
#include "unit/import/gltf_fixture.h"
#include "unit/lib/photometry/sample_lamps.h"

namespace tessera::client {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class LampFiles : public GltfTest {
 protected:
  void SetUp() override {
    GltfTest::SetUp();
    write("lamp.ies", photometry::symmetric_ies());
  }

  /// triangle() with a light profile on node 0.
  static Json with_profile(const std::string& profile, const std::string& use = "{}") {
    Json document = triangle();
    document["extensionsUsed"] = {"EXT_lights_ies"};
    document["extensions"]["EXT_lights_ies"]["lights"] = {Json::parse(profile)};
    document["nodes"][0]["extensions"]["EXT_lights_ies"] = Json::parse(use);
    document["nodes"][0]["extensions"]["EXT_lights_ies"]["light"] = 0;
    return document;
  }

  std::string refusal(const Json& document) { return std::string(import_gltf(document).status().message()); }
};

TEST_F(LampFiles, OfGltfAreBlobsOfGoniometricLights) {
  const ImportedScene scene =
      accepted(with_profile(R"({"uri": "lamp.ies"})", R"({"multiplier": 0.5, "color": [1, 0.5, 0]})"));
  ASSERT_EQ(scene.scene.lights_size(), 1);
  const v1::Light& light = scene.scene.lights(0);
  EXPECT_EQ(light.name(), "leaf");
  EXPECT_EQ(light.goniometric().photometric_file().path(), "lamp.ies");
  EXPECT_FALSE(light.goniometric().photometric_file().digest().empty());
  EXPECT_EQ(light.goniometric().intensity().rgb().g(), 0.5f);
  EXPECT_FLOAT_EQ(light.scale(), 0.5 * (0.2126 + 0.5 * 0.7152));
  EXPECT_EQ(scene.scene.units().metres(), 1);
  EXPECT_EQ(scene.scene.units().cd_per_m2(), 1);
}

TEST_F(LampFiles, OfGltfMayBeWithinIt) {
  const std::string uri = data_uri(photometry::full_ies());
  const ImportedScene scene = accepted(with_profile(R"({"uri": ")" + uri + R"("})"));
  ASSERT_EQ(scene.scene.lights_size(), 1);
  EXPECT_EQ(scene.scene.lights(0).scale(), 1);
  EXPECT_THAT(refusal(with_profile(R"({"uri": "none.ies"})")),
              HasSubstr("/extensions/EXT_lights_ies/lights/0"));
  EXPECT_THAT(refusal(with_profile("{}")), HasSubstr("either a uri or a bufferView"));
  write("broken.ies", "IES:LM-63-2019\nTILT=NONE\n1 -1 x");
  EXPECT_THAT(refusal(with_profile(R"({"uri": "broken.ies"})")),
              HasSubstr("broken.ies:3:6: 'x' is no number"));
}

TEST_F(LampFiles, LampsOfBlendersExporterAreWatts) {
  Json document = triangle();
  document["asset"]["generator"] = "Khronos glTF Blender I/O v4.0";
  const ImportedScene scene = accepted(document);
  EXPECT_EQ(scene.scene.units().metres(), 1);
  EXPECT_EQ(scene.scene.units().cd_per_m2(), 0);
}

TEST_F(LampFiles, OfPbrtHangUnderY) {
  const auto light = [&](const std::string& more) {
    const ImportedScene scene = world("LightSource \"goniometric\" \"string filename\" \"lamp.ies\" " + more);
    EXPECT_EQ(scene.scene.lights_size(), 1);
    EXPECT_THAT(warnings_of(scene), IsEmpty());
    EXPECT_FALSE(scene.scene.has_units());
    return scene.scene.lights_size() > 0 ? scene.scene.lights(0) : v1::Light();
  };
  const v1::Light lamp = light("\"float scale\" 0.5");
  EXPECT_EQ(lamp.goniometric().photometric_file().path(), "lamp.ies");
  EXPECT_TRUE(lamp.goniometric().texture().empty());
  EXPECT_EQ(lamp.scale(), 0.5f);
  // -z of the light is -y of pbrt's space.
  EXPECT_EQ(lamp.goniometric().world_from_light().elements(6), 1);
  const v1::Light powered = light("\"float power\" 10");
  EXPECT_EQ(powered.amount().unit(), "lm");
  EXPECT_EQ(powered.amount().value(), 6830);
  write("lamp.ies", "IES:LM-63-2019\nTILT=NONE\n1 -1 x");
  EXPECT_THAT(error_of(import_world("LightSource \"goniometric\" \"string filename\" \"lamp.ies\"")),
              HasSubstr("lamp.ies:3:6"));
}

TEST_F(LampFiles, OfTextScenesAreUploadedByTheirPath) {
  const auto scene = import_scene(write("scene.textproto",
                                        "lights { goniometric { photometric_file { path: 'lamp.ies' } } "
                                        "amount { value: 5 unit: 'lm' } } units { metres: 0.01 }"),
                                  {.threads = 1, .defines = {}});
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->scene.lights(0).goniometric().photometric_file().size_bytes(),
            photometry::symmetric_ies().size());
  EXPECT_EQ(scene->blobs.size(), 1u);
}

TEST_F(LampFiles, TiltFactorsGoWithTheLamp) {
  std::string text = photometry::symmetric_ies();
  text.replace(text.find("TILT=NONE"), 9, "TILT=lamp.tlt");
  write("tilted.ies", text);
  write("lamp.tlt", "1\n2\n0 90\n1 0.8\n");
  BlobCollector blobs;
  std::vector<std::string> warnings;
  const auto blob = add_lamp_file(write("tilted.ies", text), "tilted.ies", blobs, warnings);
  ASSERT_TRUE(blob.ok()) << blob.status();
  EXPECT_THAT(warnings, IsEmpty());
  EXPECT_EQ(blob->path(), "tilted.ies");
  EXPECT_THAT(blobs.find(blob->digest())->bytes, HasSubstr("TILT=INCLUDE\n1\n2\n0 90\n1 0.8\n"));
  EXPECT_TRUE(is_lamp_file("LAMP.IES"));
  EXPECT_TRUE(is_lamp_file("a/b.ldt"));
  EXPECT_FALSE(is_lamp_file("sky.exr"));
}

}  // namespace
}  // namespace tessera::client
