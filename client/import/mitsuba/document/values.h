// A Mitsuba scene file in memory: objects with named properties.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "import/geometry/motion_keys.h"
#include "import/input/diagnostics.h"
#include "spectra/curve.h"

namespace tessera::client::mitsuba {

struct Object;

struct Rgb {
  std::array<double, 3> value;
};

/// <spectrum>: one value for all wavelengths, or samples (at least two).
struct SpectrumData {
  double uniform = 0;
  spectra::Curve samples;  // empty: uniform

  bool is_uniform() const { return samples.values.empty(); }
};

/// <animation>: transforms at times, in seconds, which ascend.
struct Animation {
  std::vector<TimedPlacing> keys;
};

/// A file that a <string> may name, resolved when it is asked for.
struct String {
  std::string text;
};

using Value = std::variant<bool, std::int64_t, double, String, Imath::V3d, Rgb, SpectrumData, Imath::M44d,
                           Animation, Object*>;

struct Property {
  std::string name;  // empty for an object without a name
  Value value;
  SourceLocation where;
  bool used = false;
};

/// <bsdf type="...">, <shape>, ... with what stands inside.
struct Object {
  std::string tag;   // "bsdf", "shape", ...
  std::string type;  // the plugin; "scene" for the root
  std::string id;
  SourceLocation where;
  std::vector<Property> properties;  // the order is that of the file
  bool is_read = false;  // a PropertyReader took it: a property that nobody asked for has no effect

  /// For messages: bsdf "diffuse".
  std::string title() const;
};

/// A whole scene. Owns its objects; references are resolved and free of cycles.
struct Document {
  std::deque<Object> objects;
  Object* root = nullptr;
  // Folders where files are looked for: the last <path> first, the scene's own folder at the end.
  std::vector<std::filesystem::path> search_path;

  /// The first folder's file that exists; else the name itself in the scene's folder.
  std::filesystem::path resolve(const std::string& file) const;
};

}  // namespace tessera::client::mitsuba
