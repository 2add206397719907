// Sets that commands read, and pictures that they write.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "command/command_line.h"
#include "light_field/interpolate.h"
#include "light_field/light_field.h"

namespace tessera::client {

/// Options that `view`, `refocus` and `export` share.
struct PictureOptions {
  std::string set, output;
  int threads = 1;
  bool quiet = false;
};
/// Defines SET and -o, and at the end of the command's options those of computation.
void define_set_and_output(Command& command, PictureOptions& options, const char* output);
void define_picture_computation(Command& command, PictureOptions& options);

/// The option --by. Absent: kDepth of grids, kLumigraph of other sets.
void define_interpolation(Command& command, std::optional<light_field::Interpolation>& by);
light_field::Interpolation interpolation_of(const light_field::Manifest& manifest,
                                            std::optional<light_field::Interpolation> by);

/// Opens the set; null, with the message printed and the exit code set, where there is none that can be read.
std::unique_ptr<light_field::LightField> open_set(const std::string& folder, int& exit_code);

/// Ends a command: tells of missing rays and damaged tiles, and returns the exit code: kIncomplete with
/// damage.
int report_rays(const light_field::LightField& field, const light_field::Picture& picture, bool quiet);
/// The exit code of damage that was met, and its tiles on stderr.
int report_damage(const light_field::LightField& field);

}  // namespace tessera::client
