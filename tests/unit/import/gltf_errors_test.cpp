// Files that are not glTF 2.0 are refused with the place in their JSON.
#include "unit/import/gltf_fixture.h"

namespace tessera::client {
namespace {

using testing::HasSubstr;

struct Fault {
  const char* patch;  // RFC 6902
  const char* place;  // place of the error
};

// ---- the form of objects
constexpr Fault kForms[] = {
    {R"([{"op":"remove","path":"/asset"}])", ": \"asset\" is missing"},
    {R"([{"op":"replace","path":"/asset/version","value":"1.0"}])", "/asset/version"},
    {R"([{"op":"add","path":"/asset/minVersion","value":"2.1"}])", "/asset/minVersion"},
    {R"([{"op":"replace","path":"/meshes","value":{}}])", "/meshes"},
    {R"([{"op":"replace","path":"/meshes","value":[]}])", "/meshes"},
    {R"([{"op":"replace","path":"/nodes/0","value":7}])", "/nodes/0"},
    {R"([{"op":"replace","path":"/nodes/0/mesh","value":1}])", "/nodes/0/mesh"},
    {R"([{"op":"replace","path":"/nodes/0/mesh","value":-1}])", "/nodes/0/mesh"},
    {R"([{"op":"replace","path":"/nodes/0/mesh","value":0.0}])", "/nodes/0/mesh"},
    {R"([{"op":"replace","path":"/scenes/0/nodes","value":[0,0]}])", "/scenes/0/nodes/1"},
    {R"([{"op":"replace","path":"/nodes/1/translation","value":[0,1]}])", "/nodes/1/translation"},
    {R"([{"op":"replace","path":"/nodes/1/translation/0","value":"x"}])", "/nodes/1/translation/0"},
    {R"([{"op":"replace","path":"/materials/0/pbrMetallicRoughness/roughnessFactor","value":2}])",
     "/materials/0/pbrMetallicRoughness/roughnessFactor"},
    {R"([{"op":"add","path":"/materials/0/alphaMode","value":"NONE"}])", "/materials/0/alphaMode"},
    {R"([{"op":"add","path":"/materials/0/extensions","value":{"KHR_materials_ior":{"ior":1.3}}}])",
     "/materials/0/extensions/KHR_materials_ior"},
    {R"([{"op":"add","path":"/extensionsRequired","value":["KHR_materials_ior"]}])", "/extensionsRequired/0"},
    {R"([{"op":"add","path":"/extensionsUsed","value":["ACME_glow"]},
         {"op":"add","path":"/extensionsRequired","value":["ACME_glow"]}])",
     "/extensionsRequired/0"},
    {R"([{"op":"add","path":"/extensionsUsed","value":["KHR_texture_basisu"]},
         {"op":"add","path":"/extensionsRequired","value":["KHR_texture_basisu"]}])",
     "KTX2"},
    {R"([{"op":"add","path":"/extensionsUsed","value":["KHR_materials_ior"]},
         {"op":"add","path":"/nodes/0/extensions","value":{"KHR_materials_ior":{}}}])",
     "/nodes/0/extensions/KHR_materials_ior"},
};

// ---- the extensions of materials
struct ExtensionFault {
  const char* extension;
  const char* content;
  const char* member;
};
constexpr ExtensionFault kExtensions[] = {
    {"KHR_materials_iridescence", R"({"iridescenceFactor":1.5})", "iridescenceFactor"},
    {"KHR_materials_iridescence", R"({"iridescenceFactor":-0.5})", "iridescenceFactor"},
    {"KHR_materials_iridescence", R"({"iridescenceFactor":"much"})", "iridescenceFactor"},
    {"KHR_materials_iridescence", R"({"iridescenceIor":0.9})", "iridescenceIor"},
    {"KHR_materials_iridescence", R"({"iridescenceThicknessMinimum":-1})", "iridescenceThicknessMinimum"},
    {"KHR_materials_iridescence", R"({"iridescenceThicknessMaximum":-1})", "iridescenceThicknessMaximum"},
    {"KHR_materials_iridescence", R"({"iridescenceThicknessMaximum":[400]})", "iridescenceThicknessMaximum"},
    {"KHR_materials_iridescence", R"({"iridescenceThicknessTexture":{"index":7}})",
     "iridescenceThicknessTexture/index"},
    {"KHR_materials_iridescence", R"({"iridescenceTexture":{"texCoord":0}})",
     "iridescenceTexture: \"index\" is missing"},
    {"KHR_materials_dispersion", R"({"dispersion":-0.1})", "dispersion"},
    {"KHR_materials_dispersion", R"({"dispersion":true})", "dispersion"},
    {"KHR_materials_clearcoat", R"({"clearcoatNormalTexture":{"index":0}})", "clearcoatNormalTexture/index"},
    {"KHR_materials_clearcoat", R"({"clearcoatNormalTexture":{"scale":1}})",
     "clearcoatNormalTexture: \"index\" is missing"},
    {"KHR_materials_anisotropy", R"({"anisotropyTexture":{"index":-1}})", "anisotropyTexture/index"},
};

// ---- buffers and accessors
constexpr Fault kData[] = {
    {R"([{"op":"replace","path":"/buffers/0/byteLength","value":77}])", "/buffers/0/byteLength"},
    {R"([{"op":"replace","path":"/buffers/0/byteLength","value":75}])", "/buffers/0/byteLength"},
    {R"([{"op":"replace","path":"/buffers/0/byteLength","value":9007199254740991}])",
     "/buffers/0/byteLength"},
    {R"([{"op":"replace","path":"/buffers/0/uri","value":"data:application/octet-stream;base64,%%"}])",
     "/buffers/0/uri"},
    {R"([{"op":"replace","path":"/buffers/0/uri","value":"absent.bin"}])", "/buffers/0/uri"},
    {R"([{"op":"replace","path":"/buffers/0/uri","value":"http://example.com/a"}])", "/buffers/0/uri"},
    {R"([{"op":"replace","path":"/buffers/0/uri","value":"/etc/passwd"}])", "/buffers/0/uri"},
    {R"([{"op":"remove","path":"/buffers/0/uri"}])", "/bufferViews/0/buffer"},
    {R"([{"op":"add","path":"/bufferViews/0/byteOffset","value":9007199254740991}])", "/bufferViews/0"},
    {R"([{"op":"add","path":"/bufferViews/0/byteStride","value":2}])", "/bufferViews/0/byteStride"},
    {R"([{"op":"add","path":"/bufferViews/0/byteStride","value":8}])", "/accessors/0"},
    {R"([{"op":"add","path":"/bufferViews/1/target","value":34962}])", "/bufferViews/1/target"},
    {R"([{"op":"replace","path":"/accessors/0/count","value":4}])", "/accessors/0"},
    {R"([{"op":"replace","path":"/accessors/0/count","value":9007199254740991}])", "/accessors/0"},
    {R"([{"op":"replace","path":"/accessors/0/componentType","value":5124}])", "/accessors/0/componentType"},
    {R"([{"op":"add","path":"/accessors/0/byteOffset","value":2}])", "/accessors/0"},
    {R"([{"op":"add","path":"/accessors/0/normalized","value":true}])", "/accessors/0/normalized"},
    {R"([{"op":"replace","path":"/accessors/0/max/0","value":2}])", "/accessors/0/max/0"},
    {R"([{"op":"remove","path":"/accessors/0/min"}])", "/meshes/0/primitives/0/attributes/POSITION"},
    {R"([{"op":"remove","path":"/accessors/0/bufferView"},
         {"op":"replace","path":"/accessors/0/count","value":1000000000000}])",
     "/accessors/0/count"},
    {R"([{"op":"add","path":"/accessors/0/sparse","value":{"count":4,
         "indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":0}}}])",
     "/accessors/0/sparse"},
    {R"([{"op":"add","path":"/accessors/0/sparse","value":{"count":1,
         "indices":{"bufferView":2,"componentType":5125,"byteOffset":4},"values":{"bufferView":3}}}])",
     "/accessors/0/sparse/indices"},
};

// ---- what refers to what
constexpr Fault kLinks[] = {
    {R"([{"op":"add","path":"/nodes/0/children","value":[1]},{"op":"add","path":"/nodes/1/children","value":[0]}])",
     "/nodes/0/children"},
    {R"([{"op":"add","path":"/nodes/0/children","value":[0]}])", "/nodes/0/children/0"},
    {R"([{"op":"add","path":"/nodes/0/children","value":[1]}])", "/scenes/0/nodes/1"},
    {R"([{"op":"add","path":"/nodes/1/matrix","value":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}])",
     "/nodes/1/translation"},
    {R"([{"op":"add","path":"/nodes/0/matrix","value":[1,0,0,0,1,1,0,0,0,0,1,0,0,0,0,1]}])",
     "/nodes/0/matrix"},
    {R"([{"op":"add","path":"/nodes/0/rotation","value":[0,0,0,0.5]}])", "/nodes/0/rotation"},
    {R"([{"op":"add","path":"/nodes/0/weights","value":[1]}])", "/nodes/0/weights"},
    {R"([{"op":"add","path":"/skins","value":[{"joints":[1]}]},{"op":"add","path":"/nodes/0/skin","value":0}])",
     "/nodes/0/skin"},
    {R"([{"op":"remove","path":"/cameras/0/perspective"}])", "/cameras/0"},
    {R"([{"op":"add","path":"/cameras/0/perspective/zfar","value":0.05}])", "/cameras/0/perspective/zfar"},
    {R"([{"op":"replace","path":"/meshes/0/primitives/0/attributes","value":{"PLACE":0}}])",
     "/meshes/0/primitives/0/attributes/PLACE"},
    {R"([{"op":"add","path":"/meshes/0/primitives/0/attributes/NORMAL","value":0}])", "/accessors/0"},
    {R"([{"op":"add","path":"/meshes/0/primitives/0/attributes/TEXCOORD_1","value":3}])",
     "/meshes/0/primitives/0/attributes"},
    {R"([{"op":"replace","path":"/meshes/0/primitives/0/indices","value":0}])",
     "/meshes/0/primitives/0/indices"},
    {R"([{"op":"add","path":"/meshes/0/primitives/0/targets","value":[{"NORMAL":0}]}])",
     "/meshes/0/primitives/0/targets/0/NORMAL"},
    {R"([{"op":"replace","path":"/animations/0/channels/0/sampler","value":1}])",
     "/animations/0/channels/0/sampler"},
    {R"([{"op":"replace","path":"/animations/0/channels/0/target/path","value":"rotation"}])",
     "/animations/0/channels/0/target/path"},
    {R"([{"op":"replace","path":"/animations/0/samplers/0/input","value":3}])",
     "/animations/0/samplers/0/input"},
    {R"([{"op":"add","path":"/images","value":[{}]}])", "/images/0"},
    {R"([{"op":"add","path":"/images","value":[{"uri":"absent.png"}]}])", "/images/0/uri"},
    {R"([{"op":"add","path":"/images","value":[{"uri":"data:image/png;base64,iVBORw0KGgo="}]}])",
     "/images/0"},
    {R"([{"op":"add","path":"/textures","value":[{"sampler":0}]}])", "/textures/0/sampler"},
};

class GltfErrors : public GltfTest {
 protected:
  void expect_refused(std::span<const Fault> faults) const {
    const absl::Status sound = import_gltf(triangle()).status();
    ASSERT_TRUE(sound.ok()) << sound.ToString();
    for (const Fault& fault : faults) {
      SCOPED_TRACE(fault.patch);
      const absl::StatusOr<ImportedScene> result = import_gltf(patched(triangle(), fault.patch));
      ASSERT_FALSE(result.ok());
      EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
      EXPECT_THAT(std::string(result.status().message()), HasSubstr(fault.place));
    }
  }
};

TEST_F(GltfErrors, OfForm) { expect_refused(kForms); }
TEST_F(GltfErrors, OfExtensionsOfMaterials) {
  for (const auto& [extension, content, member] : kExtensions) {
    SCOPED_TRACE(content);
    Json document = triangle();
    document["extensionsUsed"] = {extension};
    document["materials"][0]["extensions"][extension] = Json::parse(content);
    const absl::StatusOr<ImportedScene> result = import_gltf(document);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(result.status().message()),
                HasSubstr(absl::StrCat("/materials/0/extensions/", extension, "/", member)));
  }
}
TEST_F(GltfErrors, OfData) { expect_refused(kData); }
TEST_F(GltfErrors, OfReferences) { expect_refused(kLinks); }

TEST_F(GltfErrors, OfNumbersInBuffers) {
  struct {
    std::size_t at;
    std::string bytes;
    const char* place;
  } const faults[] = {{4, std::string("\0\0\xc0\x7f", 4), "/accessors/0: element 0 is not finite"},
                      {12, std::string("\0\0\x80\x7f", 4), "/accessors/0: element 1 is not finite"},
                      {38, std::string("\3\0", 2), "/accessors/1: element 1 is 3"},
                      {38, std::string("\xff\xff", 2), "/accessors/1: element 1"},
                      {48, std::string("\0\0\0\0", 4), "/animations/0/samplers/0/input"}};
  for (const auto& [at, bytes, place] : faults) {
    SCOPED_TRACE(place);
    Json document = triangle();
    std::string data;
    const std::string uri = document["buffers"][0]["uri"];
    ASSERT_TRUE(absl::Base64Unescape(uri.substr(uri.find(',') + 1), &data));
    document["buffers"][0]["uri"] = data_uri(data.replace(at, bytes.size(), bytes));
    if (at == 48) document["accessors"][2]["max"][0] = 0;
    EXPECT_THAT(error_of(import_gltf(document)), HasSubstr(place));
  }
}

TEST_F(GltfErrors, OfJson) {
  for (const auto& [text, place] : {std::pair("", "1:1"),
                                    {"{", "scene.gltf: 1:"},
                                    {"[]", "expected an object"},
                                    {"{\"asset\":{\"version\":\"2.0\"},\n \"asset\":{}}", "twice"},
                                    {"{\"a\":1e999}", "scene.gltf: "}}) {
    SCOPED_TRACE(text);
    EXPECT_THAT(error_of(import_scene(write("scene.gltf", text), {})), HasSubstr(place));
  }
  const std::string deep(100000, '[');
  EXPECT_THAT(error_of(import_scene(write("scene.gltf", deep), {})), HasSubstr("64 levels"));
}

TEST_F(GltfErrors, OfContainers) {
  Json document = triangle();
  const std::string json = padded(document.dump());
  const std::string whole = glb({{"JSON", json}});
  EXPECT_TRUE(import_scene(write("scene.glb", whole), {}).ok());
  for (std::size_t size : {std::size_t{4}, std::size_t{11}, std::size_t{12}, std::size_t{19}, std::size_t{20},
                           whole.size() / 2, whole.size() - 1}) {
    SCOPED_TRACE(size);
    EXPECT_THAT(error_of(import_scene(write("scene.glb", whole.substr(0, size)), {})),
                HasSubstr("scene.glb: "));
  }
  EXPECT_THAT(error_of(import_scene(write("scene.glb", whole + "more"), {})), HasSubstr("byte 8"));
  EXPECT_THAT(error_of(import_scene(write("scene.glb", glb({{"JSON", json}}, 1)), {})),
              HasSubstr("version 1"));
  EXPECT_THAT(error_of(import_scene(write("scene.glb", glb({{std::string("BIN\0", 4), json}})), {})),
              HasSubstr("first chunk"));
  EXPECT_THAT(error_of(import_scene(write("scene.glb", glb({{"JSON", json}, {"JSON", json}})), {})),
              HasSubstr("second chunk"));
}

/// A few hundred bytes that ask for gigabytes: many primitives of few data, and instances of nothing.
TEST_F(GltfErrors, OfFilesThatAskForTooMuch) {
  Json document = triangle();
  document["accessors"][0] = {
      {"componentType", 5126}, {"count", 1 << 19}, {"type", "VEC3"}, {"min", {0, 0, 0}}, {"max", {0, 0, 0}}};
  document["accessors"][1] = document["accessors"][0];
  Json& primitives = document["meshes"][0]["primitives"];
  primitives[0].erase("indices");
  for (int i = 0; i < 64; ++i) primitives.push_back(primitives[0]);
  EXPECT_THAT(error_of(import_gltf(document)), HasSubstr("/accessors/0: the file asks for more"));
}

}  // namespace
}  // namespace tessera::client
