// Scenes that sound glTF files become.
#include <cmath>
#include <numbers>

#include "unit/import/gltf_fixture.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::FloatNear;
using testing::HasSubstr;
using testing::IsEmpty;

class GltfScene : public GltfTest {
 protected:
  static wire::MeshData mesh_of(const ImportedScene& scene, const v1::Shape& shape) {
    for (const SceneBlob& blob : scene.blobs) {
      if (blob.ref.digest() != shape.mesh().blob().digest()) continue;
      const auto mesh = wire::decode_mesh(blob.bytes);
      EXPECT_TRUE(mesh.ok());
      const auto copy = [](auto span) { return std::vector<float>(span.begin(), span.end()); };
      wire::MeshData data;
      data.positions = copy(mesh->positions);
      data.indices.assign(mesh->indices.begin(), mesh->indices.end());
      return data;
    }
    ADD_FAILURE() << "no such blob";
    return {};
  }
};

TEST_F(GltfScene, HasItsMeshItsMaterialAndItsCamera) {
  const ImportedScene scene = accepted(triangle());
  ASSERT_EQ(scene.scene.shapes_size(), 1);
  EXPECT_EQ(scene.scene.shapes(0).name(), "leaf");
  const wire::MeshData mesh = mesh_of(scene, scene.scene.shapes(0));
  EXPECT_THAT(mesh.positions, ElementsAre(0, 0, 0, 1, 0, 0, 0, 1, 0));
  EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2));
  ASSERT_EQ(scene.scene.materials_size(), 1);
  EXPECT_EQ(scene.scene.materials(0).name(), "paint");
  EXPECT_EQ(scene.scene.materials(0).gltf().metallic().constant(), 0.25f);
  EXPECT_EQ(scene.scene.materials(0).gltf().roughness().constant(), 0.5f);
  // It looks along -z: the third column is that, in the world.
  const auto& m = scene.scene.camera().world_from_camera().elements();
  EXPECT_THAT(std::vector<double>(m.begin(), m.end()),
              ElementsAre(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 5, 0, 0, 0, 1));
  EXPECT_NEAR(scene.scene.camera().perspective().fov_degrees(), 180 / std::numbers::pi, 1e-4);
  EXPECT_THAT(warnings_of(scene), HasSubstr("--default-light"));
}

TEST_F(GltfScene, OfAContainerIsTheSame) {
  Json document = triangle();
  std::string bytes;
  const std::string uri = document["buffers"][0]["uri"];
  ASSERT_TRUE(absl::Base64Unescape(uri.substr(uri.find(',') + 1), &bytes));
  const ImportedScene expected = accepted(document);
  document["buffers"][0].erase("uri");
  const auto scene = import_scene(
      write("scene.glb", glb({{"JSON", padded(document.dump())}, {std::string("BIN\0", 4), bytes}})), {});
  ASSERT_TRUE(scene.ok()) << scene.status().ToString();
  EXPECT_EQ(scene->scene.SerializeAsString(), expected.scene.SerializeAsString());
}

class GltfShapes : public GltfScene {
 protected:
  /// Adds an accessor of floats; returns its number.
  static int add(Json& document, const std::string& type, std::size_t components,
                 const std::vector<float>& values) {
    const std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    document["buffers"].push_back({{"byteLength", bytes.size()}, {"uri", data_uri(bytes)}});
    document["bufferViews"].push_back(
        {{"buffer", document["buffers"].size() - 1}, {"byteLength", bytes.size()}});
    document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                     {"componentType", 5126},
                                     {"count", values.size() / components},
                                     {"type", type}});
    return static_cast<int>(document["accessors"].size() - 1);
  }
};

TEST_F(GltfShapes, AreMorphedByTheWeightsOfTheirNode) {
  Json document = triangle();
  const int target = add(document, "VEC3", 3, {0, 0, 4, 0, 0, 0, 0, 0, 0});
  document["accessors"][target]["min"] = {0, 0, 0};
  document["accessors"][target]["max"] = {0, 0, 4};
  document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", target}}};
  document["meshes"][0]["weights"] = {1};
  document["nodes"][0]["weights"] = {0.5};
  const ImportedScene scene = accepted(document);
  EXPECT_THAT(mesh_of(scene, scene.scene.shapes(0)).positions, ElementsAre(0, 0, 2, 1, 0, 0, 0, 1, 0));
}

TEST_F(GltfShapes, AreMorphedWhileTheShutterIsOpen) {
  Json document = triangle();
  const int target = add(document, "VEC3", 3, {0, 0, 4, 0, 0, 0, 0, 0, 0});
  document["accessors"][target]["min"] = {0, 0, 0};
  document["accessors"][target]["max"] = {0, 0, 4};
  document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", target}}};
  document["meshes"][0]["weights"] = {0};
  document["animations"][0]["samplers"].push_back(
      {{"input", 2}, {"output", add(document, "SCALAR", 1, {0, 1})}});
  document["animations"][0]["channels"].push_back(
      {{"sampler", 1}, {"target", {{"node", 0}, {"path", "weights"}}}});
  GltfOptions options;
  options.time = 0.25;
  options.shutter = 0.5;
  const ImportedScene scene = accepted(document, options);
  v1::Shape shape = scene.scene.shapes(0);
  EXPECT_THAT(mesh_of(scene, shape).positions, ElementsAre(0, 0, 1, 1, 0, 0, 0, 1, 0));
  ASSERT_GE(shape.mesh().later_blobs_size(), 2);
  const int middle = shape.mesh().later_blobs_size() / 2 - 1, last = shape.mesh().later_blobs_size() - 1;
  *shape.mutable_mesh()->mutable_blob() = scene.scene.shapes(0).mesh().later_blobs(middle);
  EXPECT_THAT(mesh_of(scene, shape).positions, ElementsAre(0, 0, 2, 1, 0, 0, 0, 1, 0));
  *shape.mutable_mesh()->mutable_blob() = scene.scene.shapes(0).mesh().later_blobs(last);
  EXPECT_THAT(mesh_of(scene, shape).positions, ElementsAre(0, 0, 3, 1, 0, 0, 0, 1, 0));
  // The node moves, too.
  EXPECT_THAT(place_of(shape.motion().rbegin()->place()), ElementsAre(1.5, 0, 0));
}

TEST_F(GltfShapes, AreBentByTheirSkinWhereverTheirNodeStands) {
  Json document = triangle();
  document["nodes"].push_back({{"translation", {0, 0, 1}}});
  document["scenes"][0]["nodes"] = {0, 1, 2};
  document["nodes"][0]["translation"] = {100, 0, 0};
  const int weights = add(document, "VEC4", 4, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  const std::string zeros(12, '\0');
  document["buffers"].push_back({{"byteLength", 12}, {"uri", data_uri(zeros)}});
  document["bufferViews"].push_back({{"buffer", document["buffers"].size() - 1}, {"byteLength", 12}});
  document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                   {"componentType", 5121},
                                   {"count", 3},
                                   {"type", "VEC4"}});
  Json& attributes = document["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = document["accessors"].size() - 1;
  attributes["WEIGHTS_0"] = weights;
  // The joint was at (0, 0, 3) when the mesh was bound to it.
  const int matrices = add(document, "MAT4", 16, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -3, 1});
  document["skins"] = {{{"joints", {2}}, {"inverseBindMatrices", matrices}}};
  document["nodes"][0]["skin"] = 0;
  const ImportedScene scene = accepted(document);
  EXPECT_THAT(mesh_of(scene, scene.scene.shapes(0)).positions, ElementsAre(0, 0, -2, 1, 0, -2, 0, 1, -2));
  EXPECT_THAT(place_of(scene.scene.shapes(0).world_from_object()), ElementsAre(0, 0, 0));
  // The joint goes on by 2 along x in a second.
  document["animations"][0]["channels"][0]["target"]["node"] = 2;
  document["animations"][0]["samplers"][0]["output"] = add(document, "VEC3", 3, {0, 0, 1, 2, 0, 1});
  GltfOptions options;
  options.time = 0;
  options.shutter = 1;
  const ImportedScene moving = accepted(document, options);
  v1::Shape shape = moving.scene.shapes(0);
  ASSERT_FALSE(shape.mesh().later_blobs().empty());
  EXPECT_TRUE(shape.motion().empty());
  *shape.mutable_mesh()->mutable_blob() = *shape.mesh().later_blobs().rbegin();
  EXPECT_THAT(mesh_of(moving, shape).positions, ElementsAre(2, 0, -2, 3, 0, -2, 2, 1, -2));
}

TEST_F(GltfShapes, AreInstancedByExtensionAndBySeveralNodes) {
  Json document = triangle();
  const int places = add(document, "VEC3", 3, {1, 0, 0, 2, 0, 0, 3, 0, 0});
  document["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = places;
  const ImportedScene scene = accepted(document);
  EXPECT_EQ(scene.scene.objects_size(), 1);
  ASSERT_EQ(scene.scene.instances_size(), 3);
  EXPECT_THAT(place_of(scene.scene.instances(2).world_from_instance()), ElementsAre(3, 0, 0));

  Json twice = triangle();
  twice["nodes"].push_back({{"mesh", 0}, {"translation", {0, 7, 0}}});
  twice["scenes"][0]["nodes"] = {0, 1, 2};
  EXPECT_EQ(accepted(twice).scene.instances_size(), 2);
}

TEST_F(GltfScene, HasLightsInTheirUnits) {
  Json document = triangle();
  document["extensionsUsed"] = {"KHR_lights_punctual"};
  document["extensions"]["KHR_lights_punctual"]["lights"] = Json::parse(
      R"([{"type": "directional", "intensity": 3, "color": [1, 0.5, 0]}, {"type": "point", "intensity": 683},
          {"type": "spot", "intensity": 2, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.3}}])");
  for (int i = 0; i < 3; ++i) {
    Json node;
    node["extensions"]["KHR_lights_punctual"]["light"] = i;
    document["nodes"].push_back(node);
    document["scenes"][0]["nodes"].push_back(2 + i);
  }
  const ImportedScene scene = accepted(document);
  ASSERT_EQ(scene.scene.lights_size(), 3);
  EXPECT_EQ(scene.scene.lights(0).distant().direction().z(), -1);
  EXPECT_EQ(scene.scene.lights(0).distant().irradiance().rgb().g(), 1.5f);
  EXPECT_EQ(scene.scene.lights(1).point().intensity().rgb().r(), 683);
  EXPECT_NEAR(scene.scene.lights(2).spot().cone_angle_degrees(), 0.3 * 180 / std::numbers::pi, 1e-4);
  EXPECT_NEAR(scene.scene.lights(2).spot().cone_delta_degrees(), 0.2 * 180 / std::numbers::pi, 1e-4);

  // Blender's exporter writes watts times 683 / 4 pi.
  document["asset"]["generator"] = "Khronos glTF Blender I/O v3.4.50";
  EXPECT_NEAR(accepted(document).scene.lights(1).point().intensity().rgb().r(), 1, 1e-6);
}

TEST_F(GltfScene, HasASkyWhereItIsAskedForAndThereIsNoLight) {
  GltfOptions options;
  options.default_light = 2;
  const ImportedScene scene = accepted(triangle(), options);
  ASSERT_EQ(scene.scene.lights_size(), 1);
  EXPECT_EQ(scene.scene.lights(0).infinite().scale(), 2);
  EXPECT_THAT(scene.warnings, IsEmpty());

  Json lit = triangle();
  lit["extensionsUsed"] = {"KHR_lights_punctual"};
  lit["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  lit["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  const ImportedScene own = accepted(lit, options);
  ASSERT_EQ(own.scene.lights_size(), 1);
  EXPECT_TRUE(own.scene.lights(0).has_point());
}

/// The camera that is put where everything is seen has x to the right: it is no mirror.
TEST_F(GltfScene, WithoutACameraIsSeenFromTheFront) {
  const ImportedScene scene = accepted(patched(triangle(), R"([{"op":"remove","path":"/nodes/1/camera"}])"));
  const auto& m = scene.scene.camera().world_from_camera().elements();
  ASSERT_EQ(m.size(), 16);
  EXPECT_GT(m[0], 0.5);    // x of the camera along x of the world
  EXPECT_GT(m[5], 0.5);    // y along y
  EXPECT_LT(m[10], -0.5);  // it looks along -z
  EXPECT_THAT(warnings_of(scene), HasSubstr("no camera"));
}

TEST_F(GltfScene, HasTheLayersOfItsExtensions) {
  Json document = triangle();
  document["extensionsUsed"] = {"KHR_materials_ior",    "KHR_materials_transmission",
                                "KHR_materials_volume", "KHR_materials_clearcoat",
                                "KHR_materials_sheen",  "KHR_materials_emissive_strength"};
  document["materials"][0]["emissiveFactor"] = {1, 0.5, 0};
  document["materials"][0]["extensions"] = Json::parse(
      R"({"KHR_materials_ior": {"ior": 1.33}, "KHR_materials_transmission": {"transmissionFactor": 0.75},
          "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [0.25, 1, 1]},
          "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.125},
          "KHR_materials_sheen": {"sheenColorFactor": [0, 0, 1], "sheenRoughnessFactor": 0.5},
          "KHR_materials_emissive_strength": {"emissiveStrength": 4}})");
  const ImportedScene scene = accepted(document);
  const v1::GltfMaterial& gltf = scene.scene.materials(0).gltf();
  EXPECT_EQ(gltf.ior(), 1.33f);
  EXPECT_EQ(gltf.transmission().constant(), 0.75f);
  EXPECT_TRUE(gltf.volume());
  EXPECT_EQ(gltf.clearcoat().constant(), 0.5f);
  EXPECT_EQ(gltf.clearcoat_roughness().constant(), 0.125f);
  EXPECT_EQ(gltf.sheen_color().constant().rgb().b(), 1);
  EXPECT_EQ(gltf.sheen_roughness().constant(), 0.5f);
  EXPECT_EQ(scene.scene.shapes(0).area_light().scale(), 4);
  // Half of a half: what is left of red after the distance.
  ASSERT_EQ(scene.scene.media_size(), 1);
  EXPECT_NEAR(scene.scene.media(0).extinction().constant().rgb().r(), std::log(4.0) / 2, 1e-6);
}

TEST_F(GltfScene, HasFilmsAndDispersion) {
  Json document = triangle();
  document["extensionsUsed"] = {"KHR_materials_transmission", "KHR_materials_volume",
                                "KHR_materials_iridescence", "KHR_materials_dispersion"};
  document["materials"][0]["extensions"] = Json::parse(
      R"({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 1},
          "KHR_materials_iridescence": {"iridescenceFactor": 0.5},
          "KHR_materials_dispersion": {"dispersion": 0.4}})");
  const ImportedScene scene = accepted(document);
  EXPECT_THAT(warnings_of(scene), testing::Not(HasSubstr("/materials")));
  const v1::GltfMaterial& gltf = scene.scene.materials(0).gltf();
  EXPECT_EQ(gltf.iridescence().constant(), 0.5f);
  EXPECT_EQ(gltf.iridescence_ior(), 1.3f);
  EXPECT_EQ(gltf.iridescence_thickness().constant(), 400);
  EXPECT_EQ(gltf.dispersion(), 0.4f);

  // A sheet refracts nothing.
  Json& extensions = document["materials"][0]["extensions"];
  extensions.erase("KHR_materials_volume");
  extensions["KHR_materials_iridescence"] =
      Json::parse(R"({"iridescenceFactor": 0, "iridescenceThicknessMaximum": 200})");
  const ImportedScene sheet = accepted(document);
  EXPECT_EQ(sheet.scene.materials(0).gltf().dispersion(), 0);
  EXPECT_FALSE(sheet.scene.materials(0).gltf().has_iridescence());
  EXPECT_THAT(warnings_of(sheet), HasSubstr("KHR_materials_dispersion: dispersion without a volume"));
}

TEST_F(GltfScene, HasTheTexturesOfItsExtensions) {
  Json document = with_texture(triangle());
  document["extensionsUsed"] = {"KHR_materials_iridescence", "KHR_materials_clearcoat",
                                "KHR_materials_anisotropy"};
  document["materials"][0]["extensions"] = Json::parse(
      R"({"KHR_materials_iridescence": {"iridescenceFactor": 0.5, "iridescenceThicknessMinimum": 50,
                                        "iridescenceThicknessMaximum": 250, "iridescenceTexture": {"index": 0},
                                        "iridescenceThicknessTexture": {"index": 0}},
          "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatNormalTexture": {"index": 0}},
          "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyTexture": {"index": 0}}})");
  const ImportedScene scene = accepted(document);
  EXPECT_THAT(warnings_of(scene), testing::Not(HasSubstr("/materials")));
  const auto texture = [&](const std::string& name) -> const v1::Texture& {
    for (const v1::Texture& found : scene.scene.textures()) {
      if (found.name() == name) return found;
    }
    ADD_FAILURE() << "no texture " << name;
    return v1::Texture::default_instance();
  };
  const v1::GltfMaterial& gltf = scene.scene.materials(0).gltf();
  EXPECT_EQ(texture(gltf.iridescence().texture()).image().channel(), v1::ImageTexture::RED);
  EXPECT_EQ(texture(gltf.iridescence().texture()).image().scale(), 0.5f);
  const v1::MixTexture& thickness = texture(gltf.iridescence_thickness().texture()).mix();
  EXPECT_EQ(thickness.a().constant().rgb().g(), 50);
  EXPECT_EQ(thickness.b().constant().rgb().g(), 250);
  EXPECT_EQ(texture(thickness.amount().texture()).image().channel(), v1::ImageTexture::GREEN);
  EXPECT_EQ(gltf.clearcoat_normal_map().encoding(), v1::ImageTexture::LINEAR);
  EXPECT_EQ(texture(gltf.anisotropy().texture()).image().channel(), v1::ImageTexture::BLUE);
  const v1::ImageTexture& direction = texture(gltf.anisotropy_direction().texture()).image();
  EXPECT_EQ(direction.channel(), v1::ImageTexture::ALL);
  EXPECT_EQ(direction.encoding(), v1::ImageTexture::LINEAR);
  EXPECT_EQ(direction.wrap(), v1::ImageTexture::CLAMP);
  EXPECT_EQ(direction.wrap_v(), v1::ImageTexture::MIRROR);
}

TEST_F(GltfScene, HasTheMaterialsOfItsVariant) {
  Json document = triangle();
  document["extensionsUsed"] = {"KHR_materials_variants"};
  document["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "day"}}, {{"name", "night"}}};
  document["materials"].push_back({{"name", "dark"}});
  document["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] =
      Json::parse(R"([{"material": 1, "variants": [1]}])");
  const auto material_of = [&](const std::string& variant) {
    GltfOptions options;
    options.variant = variant;
    return accepted(document, options).scene.shapes(0).material();
  };
  EXPECT_EQ(material_of(""), "paint");
  EXPECT_EQ(material_of("day"), "paint");
  EXPECT_EQ(material_of("night"), "dark");
  GltfOptions options;
  options.variant = "noon";
  EXPECT_THAT(error_of(import_gltf(document, options)), HasSubstr("/extensions/KHR_materials_variants"));
}

TEST_F(GltfScene, IsSeenByTheCameraOfTheOption) {
  Json document = triangle();
  document["nodes"].push_back({{"name", "above"}, {"camera", 0}, {"translation", {0, 9, 0}}});
  document["scenes"][0]["nodes"] = {0, 1, 2};
  GltfOptions options;
  options.camera = "above";
  EXPECT_THAT(place_of(accepted(document, options).scene.camera().world_from_camera()), ElementsAre(0, 9, 0));
  options.camera = "below";
  EXPECT_THAT(error_of(import_gltf(document, options)),
              HasSubstr("/cameras: the scene has no camera \"below\""));
}

}  // namespace
}  // namespace tessera::client
