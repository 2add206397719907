#include "import/pbrt/matter/textures.h"

#include "import/input/concat.h"
#include "import/pbrt/matter/texture_writers.h"
#include "wire/limits.h"

namespace tessera::client::pbrt {

void SceneTextures::define(TextureKind kind, const std::string& name, const std::string& type,
                           ParameterList parameters, const Imath::M44d& world_from_texture) {
  Diagnostics& diagnostics = context_.diagnostics;
  if (find_texture_writer(type) == nullptr) {
    diagnostics.error(parameters.where(),
                      concat("unknown texture type \"", type, "\": expected ", names_of_texture_types()));
    return;
  }
  if (type == "imagemap") {
    // A missing file is an error even where nothing uses the texture: pbrt would stop there as well.
    const std::string file = parameters.get_string("filename", "", diagnostics);
    std::error_code error;
    if (file.empty()) {
      diagnostics.error(parameters.where(), concat(parameters.owner(), ": expected \"string filename\""));
    } else if (!std::filesystem::is_regular_file(context_.resolve(file), error)) {
      diagnostics.error(parameters.where(), concat("texture file \"", file, "\" does not exist"));
    }
  }
  const SourceLocation where = parameters.where();
  if (!entries_
           .try_emplace({kind, name},
                        Entry{type, std::move(parameters), world_from_texture, State::kDefined, ""})
           .second) {
    diagnostics.error(where, concat("texture \"", name, "\" is defined a second time"));
  }
}

std::string SceneTextures::unique_scene_name(TextureKind kind, const std::string& name) {
  if (scene_names_.insert(name).second) return name;
  std::string candidate = concat(name, kind == TextureKind::kFloat ? " (float)" : " (spectrum)");
  while (!scene_names_.insert(candidate).second) candidate += "'";
  return candidate;
}

std::string SceneTextures::use(TextureKind kind, const std::string& name, SourceLocation where) {
  const auto found = entries_.find({kind, name});
  if (found == entries_.end()) {
    context_.diagnostics.error(
        where, concat("there is no ", kind == TextureKind::kFloat ? "float" : "spectrum", " texture \"", name,
                      "\""));
    return "";
  }
  Entry& entry = found->second;
  if (entry.state == State::kDone) return entry.scene_name;
  if (entry.state == State::kInProgress) {
    context_.diagnostics.error(where, concat("texture \"", name, "\" refers to itself"));
    return "";
  }
  if (nesting_ == wire::kMaxNesting) {
    context_.diagnostics.error(where, concat("texture \"", name, "\": more than ", wire::kMaxNesting,
                                             " textures within one another"));
    return "";
  }
  entry.state = State::kInProgress;
  ++nesting_;
  v1::Texture texture;
  ValueReader values(context_, *this, entry.parameters);
  find_texture_writer(entry.type)({kind, entry.world_from_texture, values}, texture);
  --nesting_;
  entry.scene_name = unique_scene_name(kind, name);
  texture.set_name(entry.scene_name);
  v1::Texture& added = *context_.scene.add_textures();
  added = std::move(texture);
  context_.note(added, entry.parameters.where(), concat("texture (", name, "): "));
  entry.state = State::kDone;
  return entry.scene_name;
}

std::string SceneTextures::add(const std::string& hint, v1::Texture texture) {
  const auto [entry, fresh] = added_.try_emplace(texture.SerializeAsString());
  if (!fresh) return entry->second;
  entry->second = unique_scene_name(TextureKind::kSpectrum, hint);
  texture.set_name(entry->second);
  *context_.scene.add_textures() = std::move(texture);
  return entry->second;
}

v1::SpectrumValue ValueReader::spectrum(std::string_view name, double fallback, SpectrumUse use) {
  v1::SpectrumValue value;
  const Parameter* parameter =
      parameters_.find(name,
                       {ParameterType::kRgb, ParameterType::kSpectrum, ParameterType::kBlackbody,
                        ParameterType::kFloat, ParameterType::kTexture},
                       diagnostics());
  if (parameter != nullptr && parameter->type == ParameterType::kTexture) {
    const std::string texture =
        parameter->strings.empty()
            ? ""
            : textures_.use(TextureKind::kSpectrum, parameter->strings.front(), parameter->where);
    value.set_texture(texture);
    return value;
  }
  std::optional<v1::Spectrum> constant;
  if (parameter != nullptr) constant = read_spectrum(context_, *parameter, parameters_.owner(), use);
  *value.mutable_constant() = constant ? *std::move(constant) : constant_spectrum(fallback);
  return value;
}

v1::FloatValue ValueReader::number(std::string_view name, double fallback) {
  v1::FloatValue value;
  const Parameter* parameter =
      parameters_.find(name, {ParameterType::kFloat, ParameterType::kTexture}, diagnostics());
  if (parameter != nullptr && parameter->type == ParameterType::kTexture) {
    value.set_texture(parameter->strings.empty()
                          ? ""
                          : textures_.use(TextureKind::kFloat, parameter->strings.front(), parameter->where));
    return value;
  }
  value.set_constant(static_cast<float>(parameter == nullptr ? fallback : get_float(name, fallback)));
  return value;
}

v1::Spectrum ValueReader::plain_spectrum(std::string_view name, double fallback, SpectrumUse use) {
  const Parameter* parameter = parameters_.find(name, kSpectrumTypes, diagnostics());
  std::optional<v1::Spectrum> value;
  if (parameter != nullptr) value = read_spectrum(context_, *parameter, parameters_.owner(), use);
  return value ? *std::move(value) : constant_spectrum(fallback);
}

std::optional<std::string> ValueReader::texture(std::string_view name) {
  const Parameter* parameter =
      parameters_.find(name, {ParameterType::kTexture, ParameterType::kString}, diagnostics());
  if (parameter == nullptr || parameter->type != ParameterType::kTexture || parameter->strings.empty()) {
    return std::nullopt;
  }
  return textures_.use(TextureKind::kSpectrum, parameter->strings.front(), parameter->where);
}

std::optional<v1::BlobRef> ValueReader::image(std::string_view name) {
  const std::string file = get_string(name, "");
  if (file.empty()) return std::nullopt;
  absl::StatusOr<v1::BlobRef> blob = context_.blobs.add_file(context_.resolve(file), file);
  if (blob.ok()) return *std::move(blob);
  diagnostics().error(parameters_.where(),
                      concat("image of ", parameters_.owner(), ": ", blob.status().message()));
  return std::nullopt;
}

bool fail(ValueReader& values, std::string_view what) {
  values.diagnostics().error(values.parameters().where(), concat(values.parameters().owner(), ": ", what));
  return false;
}

}  // namespace tessera::client::pbrt
