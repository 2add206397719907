// Lamps with photometric files: EXT_lights_ies.
#include <algorithm>

#include "import/gltf/file/container.h"
#include "import/gltf/view.h"
#include "import/lamp/lamp_file.h"

namespace tessera::client::gltf {
namespace {

constexpr const char* kProfiles = "EXT_lights_ies";

/// The file of a profile as a blob; nothing where something is wrong, which has been reported.
std::optional<v1::BlobRef> profile_blob(Context& context, BufferTable& buffers, const Json& profile,
                                        const std::string& place) {
  const Json* uri = member(&profile, "uri");
  const std::optional<std::size_t> view = index_of(&profile, "bufferView");
  if ((uri != nullptr) == view.has_value()) {
    context.error(place, "a light profile has either a uri or a bufferView");
    return std::nullopt;
  }
  const std::string name = concat(context.file_name, ": ", place);
  std::vector<std::string> warnings;
  absl::StatusOr<v1::BlobRef> blob = absl::InternalError("not read");
  if (view) {
    const std::optional<std::string_view> bytes = buffers.view(*view);
    if (!bytes) return std::nullopt;
    blob = add_lamp_bytes(std::string(*bytes), name, context.blobs, warnings);
  } else if (const auto& text = uri->get_ref<const std::string&>(); is_data_uri(text)) {
    absl::StatusOr<std::string> bytes = decode_data_uri(text);
    blob = bytes.ok() ? add_lamp_bytes(*std::move(bytes), name, context.blobs, warnings) : bytes.status();
  } else {
    const absl::StatusOr<std::filesystem::path> path = file_of_uri(context.folder, text);
    const absl::StatusOr<InputFile> file = path.ok() ? open_regular(*path) : path.status();
    blob = file.ok() ? add_lamp_file(*path, text, context.blobs, warnings) : file.status();
  }
  for (const std::string& warning : warnings) context.warn(place, warning);
  if (!blob.ok()) {
    context.error(place, std::string(blob.status().message()));
    return std::nullopt;
  }
  return *std::move(blob);
}

/// The luminance of linear Rec.709.
double luminance(const v1::Rgb& rgb) { return 0.2126 * rgb.r() + 0.7152 * rgb.g() + 0.0722 * rgb.b(); }

}  // namespace

void write_light_profile(Context& context, BufferTable& buffers, const Node& node) {
  const Json* of_node = extension(node.json, kProfiles);
  const auto index = index_of(of_node, "light");
  if (!index) return;
  const std::string place = below(below(below("/extensions", kProfiles), "lights"), *index);
  const Json& profile = *element(extension(&context.document, kProfiles), "lights", *index);
  const std::optional<Imath::M44d> world_from_node = without_scale(node.world_from_node);
  if (!world_from_node) {
    context.warn(node.place, "a light on a node whose scale is 0 is left out");
    return;
  }
  std::optional<v1::BlobRef> blob = profile_blob(context, buffers, profile, place);
  if (!blob) return;
  v1::Light& light = *context.scene.add_lights();
  light.set_name(node.name.empty() ? text_of(&profile, "name") : node.name);
  v1::GoniometricLight& goniometric = *light.mutable_goniometric();
  *goniometric.mutable_photometric_file() = *std::move(blob);
  write_matrix(*world_from_node, *goniometric.mutable_world_from_light());
  if (node.motion.size() > 1) {
    if (const auto end = without_scale(node.motion.back().place))
      write_all_elements(*end, *goniometric.mutable_world_from_light_end());
  }
  v1::Rgb rgb;
  const Json* color = member(of_node, "color");
  rgb.set_r(color == nullptr ? 1 : (*color)[0].get<float>());
  rgb.set_g(color == nullptr ? 1 : (*color)[1].get<float>());
  rgb.set_b(color == nullptr ? 1 : (*color)[2].get<float>());
  *goniometric.mutable_intensity()->mutable_rgb() = rgb;
  // The colour of a photometric light keeps its luminance; the one of this extension takes light away.
  const double scale = number_of(of_node, "multiplier", 1) * luminance(rgb);
  if (!(scale > 0)) {
    context.scene.mutable_lights()->RemoveLast();
    return;
  }
  light.set_scale(static_cast<float>(scale));
}

}  // namespace tessera::client::gltf
