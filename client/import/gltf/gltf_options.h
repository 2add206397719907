// Choices from a glTF file, which may hold several cameras, scenes, moments and looks.
#pragma once

#include <optional>
#include <string>

namespace tessera::client {

/// Where the moment is in the time for which the shutter is open.
enum class ShutterPosition { kStart, kCenter, kEnd };

struct GltfOptions {
  std::string camera;          // name or number; empty: the first of the scene
  std::optional<double> time;  // seconds, at which animations are looked at; none: as nodes stand
  double shutter = 0;          // seconds for which it is open: nodes move in the picture
  ShutterPosition shutter_position = ShutterPosition::kStart;
  std::string animation;  // name or number; empty: all
  std::string variant;    // name in KHR_materials_variants; empty: the materials of the primitives
  std::optional<double> default_light;  // radiance of a white sky, where the file has no light
};

/// When the shutter opens, in seconds, for a moment.
inline double opening_time(const GltfOptions& options, double time) {
  const double before = options.shutter_position == ShutterPosition::kStart    ? 0
                        : options.shutter_position == ShutterPosition::kCenter ? 0.5
                                                                               : 1;
  return time - before * options.shutter;
}

}  // namespace tessera::client
