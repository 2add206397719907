#include "import/assimp/import_assimp.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/installed_module.h"
#include "import/assimp/apart.h"
#include "import/assimp/module.h"
#include "import/gltf/file/buffers.h"
#include "import/gltf/import_gltf.h"
#include "import/input/concat.h"
#include "import/input/input_file.h"
#include "import/input/load_bytes.h"

namespace tessera::client::assimp {
namespace {

absl::StatusOr<const AssimpModule*> open_module() {
  const auto entry = base::installed_module(kAssimpModuleFile, kAssimpModuleEntry,
                                            "OBJ, STL, FBX and COLLADA are read by a module with Assimp");
  if (!entry.ok()) return entry.status();
  return reinterpret_cast<AssimpModuleEntry>(*entry)();
}

/// Result of the module's work, on its way from one process to another.
struct Converted {
  bool done = false;
  std::string glb, fault;
  std::vector<std::string> warnings;

  std::string to_bytes() const {
    std::string bytes(1, done ? '1' : '0');
    const auto put = [&](const std::string& text) {
      const std::uint64_t size = text.size();
      bytes.append(reinterpret_cast<const char*>(&size), sizeof size).append(text);
    };
    put(fault), put(glb);
    for (const std::string& warning : warnings) put(warning);
    return bytes;
  }
  static Converted from_bytes(std::string_view bytes) {
    Converted result;
    result.done = bytes.front() == '1';
    bytes.remove_prefix(1);
    const auto take = [&] {
      const auto size = load_bytes<std::uint64_t>(bytes, 0);
      const std::string text(bytes.substr(sizeof size, size));
      bytes.remove_prefix(sizeof size + size);
      return text;
    };
    result.fault = take(), result.glb = take();
    while (!bytes.empty()) result.warnings.push_back(take());
    return result;
  }
};

/// Assimp follows nodes that hold themselves, and copies those that others share: in a process of its own,
/// with bounds that grow with the file.
absl::StatusOr<Converted> convert(const AssimpModule& module, const std::filesystem::path& path,
                                  std::uint64_t file_bytes) {
  constexpr std::uint64_t kMemory = std::uint64_t{512} << 20, kMemoryOfByte = 64;
  constexpr std::uint64_t kSeconds = 60, kBytesOfSecond = 1 << 20;
  const ProcessBounds bounds{kMemory + kMemoryOfByte * file_bytes, kSeconds + file_bytes / kBytesOfSecond};
  const absl::StatusOr<std::string> bytes = run_apart(bounds, [&] {
    Converted result;
    result.done = module.to_glb(path.string(), result.glb, result.warnings, result.fault);
    return result.to_bytes();
  });
  if (!bytes.ok()) return bytes.status();
  return Converted::from_bytes(*bytes);
}

}  // namespace

absl::StatusOr<ImportedScene> import_assimp(const std::filesystem::path& path, const GltfOptions& options) {
  // Says what is wrong with files that are not there, or are pipes.
  const absl::StatusOr<InputFile> file = gltf::open_regular(path);
  if (!file.ok()) return file.status();
  static const absl::StatusOr<const AssimpModule*> module = open_module();
  if (!module.ok()) return module.status();
  const absl::StatusOr<Converted> converted = convert(**module, path, file->bytes().size());
  if (!converted.ok())
    return absl::InvalidArgumentError(
        concat(path.string(), ": ", converted.status().message(),
               ": objects that hold themselves, or one another many times over, do that"));
  if (!converted->done) return absl::InvalidArgumentError(concat(path.string(), ": ", converted->fault));
  absl::StatusOr<ImportedScene> scene = gltf::import_converted(path, converted->glb, options);
  if (!scene.ok()) return scene;
  for (const std::string& warning : converted->warnings)
    scene->warnings.push_back({.file = path.string(), .message = warning});
  return scene;
}

}  // namespace tessera::client::assimp
