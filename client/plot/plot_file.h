// Drawings as files. For the sources of this folder only.
#pragma once

#include <cairo.h>

#include <functional>
#include <string>

#include "absl/status/status.h"

namespace tessera::client {

/// Draws so many points as .png (with twice as many pixels each way) or .svg; check_plot_path() is the
/// caller's. The file is replaced as a whole (image/atomic_file.h).
absl::Status draw_file(const std::string& path, double width, double height,
                       const std::function<void(cairo_t*)>& draw);

}  // namespace tessera::client
