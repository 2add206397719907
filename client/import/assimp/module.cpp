// The module with Assimp: the only file that includes it.
#include "import/assimp/module.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <exception>
#include <new>

namespace tessera::client::assimp {
namespace {

/// Names of images as they are written on Windows.
void turn_slashes(const aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMaterials; ++m) {
    const aiMaterial& material = *scene.mMaterials[m];
    for (unsigned p = 0; p < material.mNumProperties; ++p) {
      const aiMaterialProperty& property = *material.mProperties[p];
      if (property.mType == aiPTI_String && std::string(property.mKey.C_Str()) == _AI_MATKEY_TEXTURE_BASE)
        std::replace(property.mData, property.mData + property.mDataLength, '\\', '/');
    }
  }
}

bool convert(const std::string& file, std::string& glb, std::vector<std::string>& warnings,
             std::string& fault) {
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* const scene = importer.ReadFile(
      file, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_JoinIdenticalVertices |
                aiProcess_FindInvalidData | aiProcess_FindDegenerates | aiProcess_ValidateDataStructure);
  if (scene == nullptr || scene->mRootNode == nullptr || (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0) {
    fault = *importer.GetErrorString() != 0 ? importer.GetErrorString() : "there is no scene in it";
    return false;
  }
  if (scene->mNumLights > 0) warnings.push_back(std::to_string(scene->mNumLights) + " lights are left out");
  if (scene->mNumCameras > 0)
    warnings.push_back(std::to_string(scene->mNumCameras) + " cameras are left out");
  turn_slashes(*scene);
  Assimp::Exporter exporter;
  const aiExportDataBlob* const blob = exporter.ExportToBlob(scene, "glb2");
  if (blob == nullptr) {
    fault = exporter.GetErrorString();
    return false;
  }
  glb.assign(static_cast<const char*>(blob->data), blob->size);
  return true;
}

constexpr AssimpModule kModule = {
    [](const std::string& file, std::string& glb, std::vector<std::string>& warnings, std::string& fault) {
      try {
        return convert(file, glb, warnings, fault);
      } catch (const std::bad_alloc&) {
        fault = "it takes more memory than there is for it";
        return false;
      } catch (const std::exception& error) {
        fault = error.what();
        return false;
      }
    }};

}  // namespace
}  // namespace tessera::client::assimp

extern "C" __attribute__((visibility("default"))) const tessera::client::assimp::AssimpModule*
tessera_assimp() {
  return &tessera::client::assimp::kModule;
}
