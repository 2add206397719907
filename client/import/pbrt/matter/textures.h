// pbrt Texture directives -> Texture messages, and the values of materials and shapes that may be textures.
#pragma once

#include <map>
#include <set>
#include <string>

#include "import/pbrt/context.h"
#include "import/pbrt/file/parameters.h"
#include "import/pbrt/matter/spectrum_values.h"

namespace tessera::client::pbrt {

enum class TextureKind { kFloat, kSpectrum };  // pbrt keeps a name space for each

/// All textures of the file by name. A texture is converted when something refers to it, so that what is
/// unused does not burden the scene.
class SceneTextures {
 public:
  explicit SceneTextures(Context& context) : context_(context) {}

  /// `type` is "imagemap", "checkerboard", ... Errors: an unknown type, a name that is taken, an image that
  /// is missing.
  void define(TextureKind kind, const std::string& name, const std::string& type, ParameterList parameters,
              const Imath::M44d& world_from_texture);

  /// The name in the scene of a texture; empty after an error at `where`.
  std::string use(TextureKind kind, const std::string& name, SourceLocation where);

  /// Takes a texture that no directive names; equal ones become one. Its name in the scene begins with
  /// `hint`.
  std::string add(const std::string& hint, v1::Texture texture);

 private:
  enum class State { kDefined, kInProgress, kDone };
  struct Entry {
    std::string type;
    ParameterList parameters;
    Imath::M44d world_from_texture;
    State state = State::kDefined;
    std::string scene_name;
  };

  std::string unique_scene_name(TextureKind kind, const std::string& name);

  Context& context_;
  int nesting_ = 0;  // textures that are being converted, each for the one before
  std::map<std::pair<TextureKind, std::string>, Entry> entries_;
  std::set<std::string> scene_names_;
  std::map<std::string, std::string> added_;  // names by content
};

/// Reads the parameters of one directive that can be constants or textures.
class ValueReader {
 public:
  ValueReader(Context& context, SceneTextures& textures, ParameterList& parameters)
      : context_(context), textures_(textures), parameters_(parameters) {}

  Context& context() { return context_; }
  Diagnostics& diagnostics() { return context_.diagnostics; }
  ParameterList& parameters() { return parameters_; }

  /// A constant or a texture; `fallback` where the parameter is absent.
  v1::SpectrumValue spectrum(std::string_view name, double fallback, SpectrumUse use);
  v1::FloatValue number(std::string_view name, double fallback);
  /// A constant.
  v1::Spectrum plain_spectrum(std::string_view name, double fallback, SpectrumUse use);
  /// The name in the scene of a spectrum texture, empty after an error; nothing where the parameter is
  /// something else.
  std::optional<std::string> texture(std::string_view name);
  /// An image file that must exist, as a blob; nothing after an error.
  std::optional<v1::BlobRef> image(std::string_view name);

  double get_float(std::string_view name, double fallback) {
    return parameters_.get_float(name, fallback, diagnostics());
  }
  std::int64_t get_integer(std::string_view name, std::int64_t fallback) {
    return parameters_.get_integer(name, fallback, diagnostics());
  }
  bool get_bool(std::string_view name, bool fallback) {
    return parameters_.get_bool(name, fallback, diagnostics());
  }
  std::string get_string(std::string_view name, const std::string& fallback) {
    return parameters_.get_string(name, fallback, diagnostics());
  }
  void warn(std::string message) { diagnostics().warning(parameters_.where(), std::move(message)); }

 private:
  Context& context_;
  SceneTextures& textures_;
  ParameterList& parameters_;
};

/// Reports an error of the directive that the parameters belong to. False, for what returns whether it could
/// read them.
bool fail(ValueReader& values, std::string_view what);

}  // namespace tessera::client::pbrt
