#include "import/assimp/import_assimp.h"

#include <dlfcn.h>

#include "import/assimp/module.h"
#include "import/gltf/file/buffers.h"
#include "import/gltf/import_gltf.h"
#include "import/input/concat.h"
#include "import/input/input_file.h"

namespace tessera::client::assimp {
namespace {

/// Found by the program's run path, as kernels are. Never closed: it may keep threads and tables.
absl::StatusOr<const AssimpModule*> open_module() {
  void* const module = dlopen(kAssimpModuleFile, RTLD_LAZY | RTLD_LOCAL);
  void* const entry = module == nullptr ? nullptr : dlsym(module, kAssimpModuleEntry);
  if (entry != nullptr) return reinterpret_cast<AssimpModuleEntry>(entry)();
  return absl::UnimplementedError(
      concat("OBJ, STL, FBX and COLLADA are read by a module with Assimp, which is not here: ", dlerror(),
             " (", kAssimpModuleFile, " belongs into the folder lib beside bin)"));
}

}  // namespace

absl::StatusOr<ImportedScene> import_assimp(const std::filesystem::path& path, const GltfOptions& options) {
  // Says what is wrong with files that are not there, or are pipes.
  if (const absl::StatusOr<InputFile> file = gltf::open_regular(path); !file.ok()) return file.status();
  static const absl::StatusOr<const AssimpModule*> module = open_module();
  if (!module.ok()) return module.status();
  std::string glb, fault;
  std::vector<std::string> warnings;
  if (!(*module)->to_glb(path.string(), glb, warnings, fault))
    return absl::InvalidArgumentError(concat(path.string(), ": ", fault));
  absl::StatusOr<ImportedScene> scene = gltf::import_converted(path, glb, options);
  if (!scene.ok()) return scene;
  for (const std::string& warning : warnings)
    scene->warnings.push_back({.file = path.string(), .message = warning});
  return scene;
}

}  // namespace tessera::client::assimp
