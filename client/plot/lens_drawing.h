// Sections of lenses with rays, as PNG or SVG.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"

namespace tessera::client {

struct DrawnPoint {
  double along = 0;   // the axis, from the scene to the film, mm
  double height = 0;  // mm
};

struct LensDrawing {
  struct Glass {
    std::vector<DrawnPoint> outline;  // closed
    double index = 1.5;               // the higher, the darker
  };
  struct Rays {
    std::vector<std::vector<DrawnPoint>> paths;
  };

  std::string title;
  std::vector<Glass> elements;
  std::vector<std::vector<DrawnPoint>> blades;  // lines of the stop
  std::vector<Rays> bundles;                    // of a colour each
  double film = 0;                              // its place along the axis
  double film_height = 0;                       // half of it
};

/// InvalidArgument when `path` ends in neither .png nor .svg. The file is replaced as a whole.
absl::Status write_lens_drawing(const LensDrawing& drawing, const std::string& path);

}  // namespace tessera::client
