// Options of a picture's luminance in false colours.
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "command/command.h"
#include "image/image.h"
#include "plot/value_scale.h"

namespace tessera::client {

struct FalseColorChoice {
  bool asked = false;
  std::string map = "cividis";
  std::string scale = "linear";
  std::optional<ValueRange> range{};
  bool isolines = false;
  std::optional<double> white_luminance{};  // cd/m^2 of pixels of 1
};

/// The choice outlives the command line.
void define_false_color_options(Command& command, FalseColorChoice& choice);

/// Writes the picture's luminance in cd/m^2: as a map with a legend into a .png, as channel Y into an .exr.
/// InvalidArgument for a range that the scale does not have, FailedPrecondition for an image without
/// luminance.
absl::Status write_false_color_picture(const Image& image, const FalseColorChoice& choice,
                                       const std::string& path);

}  // namespace tessera::client
