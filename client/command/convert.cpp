// tessera convert IN OUT: a scene to Tessera's own forms, or an image to another format.
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/gltf_choice.h"
#include "command/interrupt.h"
#include "command/report/exr_options.h"
#include "command/report/output.h"
#include "image/exr.h"
#include "image/layer_strip.h"
#include "import/import.h"
#include "local/scene_check.h"

namespace tessera::client {
namespace {

struct ConvertOptions {
  std::string input;
  std::string output;
  GltfOptions gltf;
  ExrFormat exr;
  std::vector<std::string> layers;  // layers of the image to write; none: all channels
  bool quiet = false;
};

int convert_image(const ConvertOptions& options) {
  if (const absl::Status status = check_output(options.output); !status.ok()) {
    return report(kUsage, std::string{status.message()});
  }
  absl::StatusOr<Image> image = read_exr(options.input);
  if (image.ok() && !options.layers.empty()) image = layer_strip(*image, options.layers);
  if (!image.ok()) return report(kUsage, std::string{image.status().message()});
  const absl::Status written = write_image(*image, options.output, options.exr);
  return written.ok() ? kDone : report(kIncomplete, std::string{written.message()});
}

int convert_scene(const ConvertOptions& options) {
  const absl::StatusOr<ImportedScene> scene =
      import_scene(options.input, {.threads = 0, .defines = {}, .gltf = options.gltf});
  if (!scene.ok()) return report(kBadScene, std::string{scene.status().message()});
  if (const absl::Status sound = status_of(find_scene_faults(*scene, nullptr), *scene); !sound.ok())
    return report(kBadScene, std::string{sound.message()});
  if (!options.quiet) {
    for (const Diagnostic& warning : scene->warnings) std::cerr << "warning: " << to_string(warning) << '\n';
  }
  const absl::Status written = write_scene(*scene, options.output);
  if (written.ok()) return kDone;
  const bool unknown_format = absl::IsInvalidArgument(written) || absl::IsUnimplemented(written);
  return report(unknown_format ? kUsage : kIncomplete, std::string{written.message()});
}

}  // namespace

void add_convert_command(CommandLine& line) {
  auto options = std::make_shared<ConvertOptions>();
  Command command = line.add_command("convert", "Convert a scene to .textproto or .tsb, or an .exr to .png");
  command.add("IN", options->input, "a scene, or an .exr").required();
  command.add("OUT", options->output, "a .textproto or .tsb; a .png or .exr").required();
  define_exr_options(command, options->exr);
  command
      .add("--layers", options->layers,
           "of an .exr: these layers, side by side; rgba is the picture, visits a heat map")
      .separated_by_commas()
      .type_name("NAME,...");
  command.add_flag("--quiet", options->quiet, "no warnings");
  define_gltf_options(command, options->gltf);
  command.example("tessera convert scene.pbrt scene.textproto");
  command.example("tessera convert picture.exr picture.png");
  command.does([options](Interrupt&) {
    const bool is_image = is_exr(options->input);
    return is_image ? convert_image(*options) : convert_scene(*options);
  });
}

}  // namespace tessera::client
