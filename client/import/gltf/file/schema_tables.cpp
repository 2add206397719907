// The JSON schemas of glTF 2.0 and of the extensions that are read, as tables.
#include <algorithm>
#include <iterator>
#include <string>

#include "import/gltf/file/schema.h"

namespace tessera::client::gltf {
namespace schema_tables {

using enum Kind;
constexpr bool kNeeded = true;
constexpr double kMost = std::numeric_limits<double>::max();

constexpr Member number(const char* name, double low = -kMost, double high = kMost, bool needed = false) {
  return {name, kNumber, "", needed, low, high};
}
constexpr Member integer(const char* name, double low = 0, double high = kMost, bool needed = false) {
  return {name, kInteger, "", needed, low, high};
}
constexpr Member numbers(const char* name, std::size_t count, double low = -kMost, double high = kMost) {
  return {name, kNumbers, "", false, low, high, count, count};
}
constexpr Member color(const char* name, std::size_t count = 3, double high = 1) {
  return numbers(name, count, 0, high);
}
constexpr Member texture(const char* name) { return {name, kObject, "textureInfo"}; }
constexpr Member text(const char* name, bool needed = false) { return {name, kText, "", needed}; }

constexpr Member kRoot[] = {{"asset", kObject, "asset", kNeeded},
                            {"extensionsUsed", kTexts},
                            {"extensionsRequired", kTexts},
                            {"accessors", kObjects, "accessor"},
                            {"animations", kObjects, "animation"},
                            {"buffers", kObjects, "buffer"},
                            {"bufferViews", kObjects, "bufferView"},
                            {"cameras", kObjects, "camera"},
                            {"images", kObjects, "image"},
                            {"materials", kObjects, "material"},
                            {"meshes", kObjects, "mesh"},
                            {"nodes", kObjects, "node"},
                            {"samplers", kObjects, "sampler"},
                            {"scene", kIndex, "scenes"},
                            {"scenes", kObjects, "scene"},
                            {"skins", kObjects, "skin"},
                            {"textures", kObjects, "texture"}};
constexpr Member kAsset[] = {text("version", kNeeded), text("minVersion"), text("generator"),
                             text("copyright")};
constexpr Member kAccessor[] = {{"bufferView", kIndex, "bufferViews"},
                                integer("byteOffset"),
                                {"componentType", kCode, "5120 5121 5122 5123 5125 5126", kNeeded},
                                {"normalized", kFlag},
                                integer("count", 1, kMost, kNeeded),
                                {"type", kWord, "SCALAR VEC2 VEC3 VEC4 MAT2 MAT3 MAT4", kNeeded},
                                {"max", kNumbers, "", false, -kMost, kMost, 1, 16},
                                {"min", kNumbers, "", false, -kMost, kMost, 1, 16},
                                {"sparse", kObject, "sparse"},
                                text("name")};
constexpr Member kSparse[] = {integer("count", 1, kMost, kNeeded),
                              {"indices", kObject, "sparseIndices", kNeeded},
                              {"values", kObject, "sparseValues", kNeeded}};
constexpr Member kSparseIndices[] = {{"bufferView", kIndex, "bufferViews", kNeeded},
                                     integer("byteOffset"),
                                     {"componentType", kCode, "5121 5123 5125", kNeeded}};
constexpr Member kSparseValues[] = {{"bufferView", kIndex, "bufferViews", kNeeded}, integer("byteOffset")};
constexpr Member kAnimation[] = {{"channels", kObjects, "channel", kNeeded},
                                 {"samplers", kObjects, "animationSampler", kNeeded},
                                 text("name")};
constexpr Member kChannel[] = {integer("sampler", 0, kMost, kNeeded), {"target", kObject, "target", kNeeded}};
constexpr Member kTarget[] = {{"node", kIndex, "nodes"}, text("path", kNeeded)};
constexpr Member kAnimationSampler[] = {{"input", kIndex, "accessors", kNeeded},
                                        {"interpolation", kWord, "LINEAR STEP CUBICSPLINE"},
                                        {"output", kIndex, "accessors", kNeeded}};
constexpr Member kBuffer[] = {text("uri"), integer("byteLength", 1, kMost, kNeeded), text("name")};
constexpr Member kBufferView[] = {{"buffer", kIndex, "buffers", kNeeded},   integer("byteOffset"),
                                  integer("byteLength", 1, kMost, kNeeded), integer("byteStride", 4, 252),
                                  {"target", kCode, "34962 34963"},         text("name")};
constexpr Member kMeshopt[] = {{"buffer", kIndex, "buffers", kNeeded},
                               integer("byteOffset"),
                               integer("byteLength", 1, kMost, kNeeded),
                               integer("byteStride", 1, 256, kNeeded),
                               integer("count", 1, kMost, kNeeded),
                               {"mode", kWord, "ATTRIBUTES TRIANGLES INDICES", kNeeded},
                               {"filter", kWord, "NONE OCTAHEDRAL QUATERNION EXPONENTIAL"}};
constexpr Member kMeshoptBuffer[] = {{"fallback", kFlag}};
constexpr Member kCamera[] = {{"type", kWord, "perspective orthographic", kNeeded},
                              {"perspective", kObject, "perspective"},
                              {"orthographic", kObject, "orthographic"},
                              text("name")};
constexpr double kTiny = std::numeric_limits<double>::denorm_min();
constexpr Member kPerspective[] = {number("aspectRatio", kTiny), number("yfov", kTiny, 3.14159265, kNeeded),
                                   number("znear", kTiny, kMost, kNeeded), number("zfar", kTiny)};
constexpr Member kOrthographic[] = {
    number("xmag", -kMost, kMost, kNeeded), number("ymag", -kMost, kMost, kNeeded),
    number("znear", 0, kMost, kNeeded), number("zfar", kTiny, kMost, kNeeded)};
constexpr Member kImage[] = {
    text("uri"), text("mimeType"), {"bufferView", kIndex, "bufferViews"}, text("name")};
constexpr Member kMaterial[] = {text("name"),
                                {"pbrMetallicRoughness", kObject, "metallicRoughness"},
                                {"normalTexture", kObject, "normalTexture"},
                                {"occlusionTexture", kObject, "occlusionTexture"},
                                texture("emissiveTexture"),
                                color("emissiveFactor", 3, kMost),
                                {"alphaMode", kWord, "OPAQUE MASK BLEND"},
                                number("alphaCutoff", 0),
                                {"doubleSided", kFlag}};
constexpr Member kMetallicRoughness[] = {color("baseColorFactor", 4), texture("baseColorTexture"),
                                         number("metallicFactor", 0, 1), number("roughnessFactor", 0, 1),
                                         texture("metallicRoughnessTexture")};
constexpr Member kTextureInfo[] = {{"index", kIndex, "textures", kNeeded}, integer("texCoord", 0, 255)};
constexpr Member kNormalTexture[] = {
    {"index", kIndex, "textures", kNeeded}, integer("texCoord", 0, 255), number("scale")};
constexpr Member kOcclusionTexture[] = {
    {"index", kIndex, "textures", kNeeded}, integer("texCoord", 0, 255), number("strength", 0, 1)};
constexpr Member kTextureTransform[] = {numbers("offset", 2), number("rotation"), numbers("scale", 2),
                                        integer("texCoord", 0, 255)};
constexpr Member kIor[] = {number("ior", 0)};
constexpr Member kTransmission[] = {number("transmissionFactor", 0, 1), texture("transmissionTexture")};
constexpr Member kVolume[] = {number("thicknessFactor", 0), texture("thicknessTexture"),
                              number("attenuationDistance", kTiny), color("attenuationColor")};
constexpr Member kSpecular[] = {number("specularFactor", 0, 1), texture("specularTexture"),
                                color("specularColorFactor", 3, kMost), texture("specularColorTexture")};
constexpr Member kClearcoat[] = {number("clearcoatFactor", 0, 1),
                                 texture("clearcoatTexture"),
                                 number("clearcoatRoughnessFactor", 0, 1),
                                 texture("clearcoatRoughnessTexture"),
                                 {"clearcoatNormalTexture", kObject, "normalTexture"}};
constexpr Member kSheen[] = {color("sheenColorFactor"), texture("sheenColorTexture"),
                             number("sheenRoughnessFactor", 0, 1), texture("sheenRoughnessTexture")};
constexpr Member kIridescence[] = {number("iridescenceFactor", 0, 1),
                                   texture("iridescenceTexture"),
                                   number("iridescenceIor", 1),
                                   number("iridescenceThicknessMinimum", 0),
                                   number("iridescenceThicknessMaximum", 0),
                                   texture("iridescenceThicknessTexture")};
constexpr Member kAnisotropy[] = {number("anisotropyStrength", 0, 1), number("anisotropyRotation"),
                                  texture("anisotropyTexture")};
constexpr Member kDispersion[] = {number("dispersion", 0)};
constexpr Member kEmissiveStrength[] = {number("emissiveStrength", 0)};
constexpr Member kDiffuseTransmission[] = {
    number("diffuseTransmissionFactor", 0, 1), texture("diffuseTransmissionTexture"),
    color("diffuseTransmissionColorFactor"), texture("diffuseTransmissionColorTexture")};
constexpr Member kSpecularGlossiness[] = {color("diffuseFactor", 4), texture("diffuseTexture"),
                                          color("specularFactor"), number("glossinessFactor", 0, 1),
                                          texture("specularGlossinessTexture")};
constexpr Member kMesh[] = {
    {"primitives", kObjects, "primitive", kNeeded}, {"weights", kNumbers}, text("name")};
constexpr Member kPrimitive[] = {{"attributes", kIndexMap, "accessors", kNeeded},
                                 {"indices", kIndex, "accessors"},
                                 {"material", kIndex, "materials"},
                                 {"mode", kCode, "0 1 2 3 4 5 6"},
                                 {"targets", kIndexMaps, "accessors"}};
constexpr Member kDraco[] = {{"bufferView", kIndex, "bufferViews", kNeeded},
                             {"attributes", kObject, "anything", kNeeded}};
constexpr Member kVariantMappings[] = {{"mappings", kObjects, "variantMapping", kNeeded}};
constexpr Member kVariantMapping[] = {{"variants", kIndices, "KHR_materials_variants/variants", kNeeded},
                                      {"material", kIndex, "materials", kNeeded}};
constexpr Member kNode[] = {{"camera", kIndex, "cameras"}, {"children", kIndices, "nodes"},
                            {"skin", kIndex, "skins"},     numbers("matrix", 16),
                            {"mesh", kIndex, "meshes"},    numbers("rotation", 4, -1, 1),
                            numbers("scale", 3),           numbers("translation", 3),
                            {"weights", kNumbers},         text("name")};
constexpr Member kLightOfNode[] = {{"light", kIndex, "KHR_lights_punctual/lights", kNeeded}};
constexpr Member kProfileOfNode[] = {
    {"light", kIndex, "EXT_lights_ies/lights", kNeeded}, number("multiplier", 0), color("color")};
constexpr Member kProfiles[] = {{"lights", kObjects, "lightProfile", kNeeded}};
constexpr Member kProfile[] = {
    text("name"), text("uri"), text("mimeType"), {"bufferView", kIndex, "bufferViews"}};
constexpr Member kInstancing[] = {{"attributes", kIndexMap, "accessors", kNeeded}};
constexpr Member kSampler[] = {{"magFilter", kCode, "9728 9729"},
                               {"minFilter", kCode, "9728 9729 9984 9985 9986 9987"},
                               {"wrapS", kCode, "33071 33648 10497"},
                               {"wrapT", kCode, "33071 33648 10497"},
                               text("name")};
constexpr Member kScene[] = {{"nodes", kIndices, "nodes"}, text("name")};
constexpr Member kSkin[] = {{"inverseBindMatrices", kIndex, "accessors"},
                            {"skeleton", kIndex, "nodes"},
                            {"joints", kIndices, "nodes", kNeeded},
                            text("name")};
// Sources are looked at where there are images: textures of unknown materials have none.
constexpr Member kTexture[] = {{"sampler", kIndex, "samplers"}, integer("source"), text("name")};
constexpr Member kTextureSource[] = {integer("source")};
constexpr Member kLights[] = {{"lights", kObjects, "light", kNeeded}};
constexpr Member kLight[] = {text("name"),           color("color"),
                             number("intensity", 0), {"type", kWord, "directional point spot", kNeeded},
                             number("range", kTiny), {"spot", kObject, "spot"}};
constexpr double kHalfPi = 1.5707963267948966;
constexpr Member kSpot[] = {number("innerConeAngle", 0, kHalfPi),
                            number("outerConeAngle", kTiny, kHalfPi + 1e-6)};
constexpr Member kVariants[] = {{"variants", kObjects, "variant", kNeeded}};
constexpr Member kVariant[] = {text("name", kNeeded)};

constexpr Schema kSchemas[] = {{"glTF", kRoot},
                               {"anything", {}},
                               {"asset", kAsset},
                               {"accessor", kAccessor},
                               {"sparse", kSparse},
                               {"sparseIndices", kSparseIndices},
                               {"sparseValues", kSparseValues},
                               {"animation", kAnimation},
                               {"channel", kChannel},
                               {"target", kTarget},
                               {"animationSampler", kAnimationSampler},
                               {"buffer", kBuffer},
                               {"bufferView", kBufferView},
                               {"camera", kCamera},
                               {"perspective", kPerspective},
                               {"orthographic", kOrthographic},
                               {"image", kImage},
                               {"material", kMaterial},
                               {"metallicRoughness", kMetallicRoughness},
                               {"textureInfo", kTextureInfo},
                               {"normalTexture", kNormalTexture},
                               {"occlusionTexture", kOcclusionTexture},
                               {"mesh", kMesh},
                               {"primitive", kPrimitive},
                               {"variantMapping", kVariantMapping},
                               {"node", kNode},
                               {"sampler", kSampler},
                               {"scene", kScene},
                               {"skin", kSkin},
                               {"texture", kTexture},
                               {"light", kLight},
                               {"spot", kSpot},
                               {"lightProfile", kProfile},
                               {"variant", kVariant},
                               {"glTF/EXT_lights_ies", kProfiles},
                               {"glTF/KHR_lights_punctual", kLights},
                               {"glTF/KHR_materials_variants", kVariants},
                               {"node/EXT_lights_ies", kProfileOfNode},
                               {"node/KHR_lights_punctual", kLightOfNode},
                               {"node/EXT_mesh_gpu_instancing", kInstancing},
                               {"buffer/EXT_meshopt_compression", kMeshoptBuffer},
                               {"bufferView/EXT_meshopt_compression", kMeshopt},
                               {"primitive/KHR_draco_mesh_compression", kDraco},
                               {"primitive/KHR_materials_variants", kVariantMappings},
                               {"texture/EXT_texture_webp", kTextureSource},
                               {"texture/KHR_texture_basisu", kTextureSource},
                               {"textureInfo/KHR_texture_transform", kTextureTransform},
                               {"normalTexture/KHR_texture_transform", kTextureTransform},
                               {"occlusionTexture/KHR_texture_transform", kTextureTransform},
                               {"material/KHR_materials_ior", kIor},
                               {"material/KHR_materials_transmission", kTransmission},
                               {"material/KHR_materials_volume", kVolume},
                               {"material/KHR_materials_specular", kSpecular},
                               {"material/KHR_materials_clearcoat", kClearcoat},
                               {"material/KHR_materials_sheen", kSheen},
                               {"material/KHR_materials_iridescence", kIridescence},
                               {"material/KHR_materials_anisotropy", kAnisotropy},
                               {"material/KHR_materials_dispersion", kDispersion},
                               {"material/KHR_materials_emissive_strength", kEmissiveStrength},
                               {"material/KHR_materials_diffuse_transmission", kDiffuseTransmission},
                               {"material/KHR_materials_pbrSpecularGlossiness", kSpecularGlossiness},
                               {"material/KHR_materials_unlit", {}},
                               // These say something by being used.
                               {"/KHR_mesh_quantization", {}},
                               {"/KHR_xmp_json_ld", {}},
                               {"/KHR_xmp", {}}};

}  // namespace schema_tables

const Schema* find_schema(std::string_view name) {
  const auto found = std::ranges::find_if(schema_tables::kSchemas,
                                          [&](const Schema& schema) { return schema.name == name; });
  return found == std::end(schema_tables::kSchemas) ? nullptr : &*found;
}

bool is_known_extension(std::string_view name) {
  return std::ranges::any_of(schema_tables::kSchemas, [&](const Schema& schema) {
    const std::string_view all = schema.name;
    return all.size() > name.size() && all.ends_with(name) && all[all.size() - name.size() - 1] == '/';
  });
}

}  // namespace tessera::client::gltf
