// A scene file in, a Scene message and its blobs out.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "import/gltf/gltf_options.h"
#include "import/input/imported_scene.h"

namespace tessera::client {

/// Something that is wrong with an element of a scene.
struct SceneFault {
  const void* element;  // part of the scene's message
  std::string place;    // "shape 12 (lamp)", for people
  std::string message;
  int field = 0;  // number of the element's field that is at fault; 0: not known
};

struct ImportOptions {
  int threads = 0;                             // threads for reading meshes; 0: one a core
  std::map<std::string, std::string> defines;  // NAME=VALUE, for formats that have parameters
  GltfOptions gltf = {};
};

/// Endings of scene files, for people.
inline constexpr char kSceneFiles[] =
    ".pbrt, .xml (Mitsuba), .gltf, .glb, .obj, .stl, .fbx, .dae, .textproto or .tsb";

/// Imports a scene by the ending of its name: .pbrt, .pbrt.gz (pbrt-v4), .xml (Mitsuba 3), .gltf, .glb
/// (glTF 2.0), .obj, .stl, .fbx, .dae (by Assimp, where its module is), .textproto, .pbtxt (a Scene in text
/// form), .tsb (a serialized Scene).
///
/// InvalidArgument lists what is wrong as "file:line:column: message", one a line, several at once (of glTF
/// "file: /json/pointer: message"). NotFound
/// when there is no such file; Unimplemented for another ending. What the importer cannot express becomes a
/// warning of the result, which says what is done instead.
absl::StatusOr<ImportedScene> import_scene(const std::filesystem::path& path,
                                           const ImportOptions& options = {});

/// InvalidArgument lists faults that importers do not know of as those of import_scene(), each at its
/// element's place in the file where that is known; OK where there are none.
absl::Status status_of(const std::vector<SceneFault>& faults, const ImportedScene& scene);

/// wire::resolve_rig(); errors are at the rig's place, and those of its cameras will be at the camera's.
absl::Status resolve_rig(ImportedScene& scene);

/// Writes a scene that `import_scene` reads again: .textproto, .pbtxt or .tsb, with its blobs in a folder
/// beside it
/// ("kitchen.textproto" and "kitchen-blobs/").
absl::Status write_scene(const ImportedScene& scene, const std::filesystem::path& path);

}  // namespace tessera::client
