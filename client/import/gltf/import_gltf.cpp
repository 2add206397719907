#include "import/gltf/import_gltf.h"

#include <algorithm>
#include <set>

#include "import/gltf/file/accessors.h"
#include "import/gltf/file/buffers.h"
#include "import/gltf/file/container.h"
#include "import/gltf/file/schema.h"
#include "import/gltf/matter/materials.h"
#include "import/gltf/nodes.h"
#include "import/gltf/rules/rules.h"
#include "import/gltf/shapes/shapes.h"
#include "import/gltf/view.h"
#include "import/input/finished_scene.h"

namespace tessera::client::gltf {
namespace {

/// Extensions without which a file must not be shown, and which have a message of their own.
std::string fate_of(const std::string& name) {
  if (name == "KHR_texture_basisu") return ": KTX2 images are not read";
  if (name == "KHR_materials_pbrSpecularGlossiness") return "";
  return " is not known here";
}

void check_version(Context& context) {
  const Json* asset = member(&context.document, "asset");
  const std::string version = text_of(asset, "version"), least = text_of(asset, "minVersion", "2.0");
  if (!version.starts_with("2.") || version.size() < 3 ||
      version.find_first_not_of("0123456789", 2) != std::string::npos)
    context.error("/asset/version", concat("version \"", version, "\": only 2.0 is read"));
  if (least != "2.0")
    context.error("/asset/minVersion", concat("version \"", least, "\" is needed: only 2.0 is read"));
}

void check_extensions(Context& context) {
  std::set<std::string> used, required;
  for (std::size_t i = 0; i < size_of(&context.document, "extensionsUsed"); ++i)
    used.insert(element(&context.document, "extensionsUsed", i)->get<std::string>());
  for (std::size_t i = 0; i < size_of(&context.document, "extensionsRequired"); ++i) {
    const auto name = element(&context.document, "extensionsRequired", i)->get<std::string>();
    required.insert(name);
    if (!used.contains(name))
      context.error(below("/extensionsRequired", i),
                    concat("the extension ", name, " is not in extensionsUsed"));
    if (is_known_extension(name) && name != "KHR_texture_basisu") continue;
    context.error(below("/extensionsRequired", i),
                  concat("the extension ", name, " is required", fate_of(name)));
  }
  for (std::size_t i = 0; i < size_of(&context.document, "extensionsUsed"); ++i) {
    const auto name = element(&context.document, "extensionsUsed", i)->get<std::string>();
    if (!is_known_extension(name) && !required.contains(name))
      context.warn(below("/extensionsUsed", i),
                   concat("the extension ", name, " is not known here: left out"));
  }
}

/// The algorithm that sees what the scene has.
void write_settings(Context& context) {
  const bool passes = std::ranges::any_of(
      context.scene.materials(), [](const v1::Material& material) { return material.has_opacity(); });
  const bool volumetric = passes || !context.scene.media().empty();
  v1::RenderSettings& settings = *context.scene.mutable_settings();
  settings.set_integrator(volumetric ? "volpath" : "path");
  constexpr std::uint32_t kSamples = 64, kDepth = 16;
  settings.set_spp(kSamples);
  settings.set_max_depth(kDepth);
}

void read_document(Context& context, std::string_view bytes) {
  std::string_view json = bytes;
  if (is_glb(bytes)) {
    const absl::StatusOr<GlbChunks> chunks = split_glb(bytes);
    if (!chunks.ok()) {
      context.error("", std::string(chunks.status().message()));
      return;
    }
    json = chunks->json;
    context.glb_binary_chunk = chunks->binary;
  }
  absl::StatusOr<Json> document = parse_json(json);
  if (!document.ok()) {
    context.error("", std::string(document.status().message()));
    return;
  }
  context.document = *std::move(document);
}

void write_scene(Context& context) {
  BufferTable buffers(context);
  if (context.diagnostics.has_errors()) return;
  AccessorTable accessors(context, buffers);
  if (context.diagnostics.has_errors()) return;
  check_rules(context, buffers, accessors);
  if (context.diagnostics.has_errors()) return;
  const std::vector<Node> nodes = read_nodes(context, accessors);
  if (context.diagnostics.has_errors()) return;
  SceneTextures textures(context, buffers);
  MaterialTable materials(context, textures);
  const Extent extent = write_shapes(context, buffers, accessors, materials, nodes);
  if (context.diagnostics.has_errors()) return;
  write_lights(context, buffers, nodes);
  write_camera(context, nodes, extent);
  write_settings(context);
}

absl::StatusOr<ImportedScene> import_bytes(const std::filesystem::path& path, std::string_view bytes,
                                           const GltfOptions& options, bool is_converted) {
  Context context;
  context.file_name = path.string();
  context.folder = path.parent_path();
  context.options = options;
  context.is_converted = is_converted;
  // Every byte may be read some times over, as interleaved attributes and shared accessors are.
  constexpr std::uint64_t kReadsOfByte = 16, kLeastElements = 1 << 20;
  context.elements_left = kLeastElements + kReadsOfByte * bytes.size();
  read_document(context, bytes);
  if (!context.diagnostics.has_errors()) check_form(context);
  if (!context.diagnostics.has_errors()) check_version(context);
  if (!context.diagnostics.has_errors()) check_extensions(context);
  for (std::size_t i = 0; i < size_of(&context.document, "buffers") && !context.diagnostics.has_errors(); ++i)
    context.elements_left +=
        kReadsOfByte * static_cast<std::uint64_t>(std::min<std::int64_t>(
                           integer_of(element(&context.document, "buffers", i), "byteLength", 0), 1ll << 36));
  if (!context.diagnostics.has_errors()) write_scene(context);
  if (absl::Status status = context.diagnostics.status(); !status.ok()) return status;

  return finished_scene(std::move(context.scene), path.stem().string(), std::move(context.blobs),
                        context.diagnostics);
}

}  // namespace

absl::StatusOr<ImportedScene> import_gltf(const std::filesystem::path& path, const GltfOptions& options) {
  const absl::StatusOr<InputFile> file = open_regular(path);
  if (!file.ok()) return file.status();
  return import_bytes(path, file->bytes(), options, false);
}

absl::StatusOr<ImportedScene> import_converted(const std::filesystem::path& path, std::string_view glb,
                                               const GltfOptions& options) {
  return import_bytes(path, glb, options, true);
}

}  // namespace tessera::client::gltf
