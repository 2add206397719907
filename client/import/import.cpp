#include "import/import.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "import/assimp/import_assimp.h"
#include "import/gltf/import_gltf.h"
#include "import/input/concat.h"
#include "import/input/diagnostics.h"
#include "import/mitsuba/import_mitsuba.h"
#include "import/pbrt/import_pbrt.h"
#include "import/tessera_scene/read_scene.h"
#include "import/tessera_scene/write_scene.h"
#include "wire/scene_numbers.h"
#include "wire/scene_views.h"

namespace tessera::client {

absl::StatusOr<ImportedScene> import_scene(const std::filesystem::path& path, const ImportOptions& options) {
  const std::string name = path.filename().string();
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    return absl::NotFoundError(concat(path.string(), ": no such file"));
  absl::StatusOr<ImportedScene> scene;
  if (name.ends_with(".pbrt") || name.ends_with(".pbrt.gz")) {
    scene = pbrt::import_pbrt(path, options.threads);
  } else if (name.ends_with(".xml")) {
    scene = mitsuba::import_mitsuba(path, options.defines, options.threads);
  } else if (name.ends_with(".gltf") || name.ends_with(".glb")) {
    scene = gltf::import_gltf(path, options.gltf);
  } else if (name.ends_with(".obj") || name.ends_with(".stl") || name.ends_with(".fbx") ||
             name.ends_with(".dae")) {
    scene = assimp::import_assimp(path, options.gltf);
  } else if (name.ends_with(".usd") || name.ends_with(".usda") || name.ends_with(".usdc") ||
             name.ends_with(".usdz")) {
    return absl::UnimplementedError(concat(path.string(), ": OpenUSD is not read yet; glTF is"));
  } else if (name.ends_with(".textproto") || name.ends_with(".pbtxt")) {
    scene = tessera_scene::read_text_scene(path);
  } else if (name.ends_with(".tsb")) {
    scene = tessera_scene::read_binary_scene(path);
  } else {
    return absl::UnimplementedError(
        concat(path.string(),
               ": unknown kind of scene file; expected .pbrt, .pbrt.gz, .xml, .gltf, .glb, .obj, .stl, "
               ".fbx, .dae, .textproto, .pbtxt or .tsb"));
  }
  if (!scene.ok()) return scene;
  // Products may be unsound though each factor is sound.
  Diagnostics diagnostics;
  const SourceLocation whole_file{.file = diagnostics.add_file(path.string())};
  for (const wire::BadNumber& bad : wire::find_bad_numbers(scene->scene, Diagnostics::kMaxErrors)) {
    diagnostics.error(whole_file, bad.to_string());
  }
  if (absl::Status sound = diagnostics.status(); !sound.ok()) return sound;
  scene->file = path.string();
  if (!options.defines.empty() && !name.ends_with(".xml")) {
    scene->warnings.push_back(
        {path.string(), 0, 0, "this kind of scene file has no parameters: definitions have no effect"});
  }
  return scene;
}

absl::Status status_of(const std::vector<SceneFault>& faults, const ImportedScene& scene) {
  std::vector<Diagnostic> located;
  for (const SceneFault& fault : faults) {
    const auto known = scene.places.find(fault.element);
    const auto field = scene.field_places.find({fault.element, fault.field});
    const std::string title = fault.place.empty() ? "" : concat(fault.place, ": ");
    Diagnostic& place =
        located.emplace_back(field != scene.field_places.end() ? field->second
                             : known != scene.places.end()     ? known->second
                                                               : Diagnostic{scene.file, 0, 0, title});
    place.message += fault.message;
  }
  std::ranges::stable_sort(
      located, {}, [](const Diagnostic& fault) { return std::tie(fault.file, fault.line, fault.column); });
  Diagnostics diagnostics;
  for (Diagnostic& fault : located)
    diagnostics.error({diagnostics.add_file(fault.file), fault.line, fault.column}, std::move(fault.message));
  return diagnostics.status();
}

absl::Status resolve_rig(ImportedScene& imported) {
  v1::Scene& scene = imported.scene;
  if (!scene.has_rig()) return absl::OkStatus();
  const void* const rig = &scene.rig();
  if (const absl::Status status = wire::resolve_rig(scene); !status.ok())
    return status_of({{rig, "", std::string(status.message())}}, imported);
  const auto camera = imported.places.find(&scene.camera());
  if (camera == imported.places.end()) return absl::OkStatus();
  const Diagnostic place = camera->second;
  for (const v1::Camera& view : scene.views()) imported.places[&view] = place;
  return absl::OkStatus();
}

absl::Status write_scene(const ImportedScene& scene, const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".textproto" || extension == ".pbtxt")
    return tessera_scene::write_scene(scene, path, true);
  if (extension == ".tsb") return tessera_scene::write_scene(scene, path, false);
  return absl::UnimplementedError(
      concat(path.string(), ": scenes are written as .textproto, .pbtxt or .tsb"));
}

}  // namespace tessera::client
