// tessera denoise IN.exr -o OUT
#include "denoise/denoise.h"

#include <iostream>
#include <memory>

#include "absl/strings/str_cat.h"
#include "command/command.h"
#include "command/denoise_result.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/report/exr_options.h"
#include "command/report/output.h"
#include "image/exr.h"

namespace tessera::client {
namespace {

struct DenoiseCommandOptions {
  std::string input, output;
  std::string method = "regression";
  ExrFormat exr;
  int threads = 0;
  bool quiet = false;
};

int run(const DenoiseCommandOptions& options) {
  if (const absl::Status status = check_output(options.output); !status.ok())
    return report(kUsage, std::string{status.message()});
  absl::StatusOr<Image> image = read_exr(options.input);
  if (!image.ok()) return report(kUsage, std::string{image.status().message()});
  const absl::StatusOr<std::optional<DenoiseMethod>> method = parse_denoise_method(options.method);
  const absl::StatusOr<DenoiseReport> done =
      denoise_image(denoise_options(**method, options.threads), *image);
  if (!done.ok()) {
    const bool usage = absl::IsInvalidArgument(done.status()) || absl::IsNotFound(done.status());
    return report(usage ? kUsage : kIncomplete, absl::StrCat(options.input, ": ", done.status().message()));
  }
  if (!options.quiet) tell(*done);
  const absl::Status written = write_image(*image, options.output, options.exr);
  return written.ok() ? kDone : report(kIncomplete, std::string{written.message()});
}

}  // namespace

void add_denoise_command(CommandLine& line) {
  auto options = std::make_shared<DenoiseCommandOptions>();
  Command command = line.add_command("denoise", "Take the noise out of a picture");
  command
      .add("IN", options->input,
           "an .exr with --aov variance,albedo,normal,depth,halves; its R, G and B are denoised, or raw.R, "
           "raw.G and raw.B where it has been before")
      .required();
  command.add("-o,--output", options->output, "the image: .exr (linear) or .png (tone-mapped)")
      .type_name("FILE")
      .required();
  command.add("--method", options->method, "how: regression, statistical or oidn (docs/denoising.md)")
      .type_name("NAME")
      .one_of({"regression", "statistical", "oidn"})
      .with_default();
  define_exr_options(command, options->exr);
  command.add("--threads", options->threads, "threads; 0: one a core").in_range(0, 1024).with_default();
  command.add_flag("--quiet", options->quiet, "say nothing of pixels that were cut or filled");
  command.example("tessera render scene.pbrt -o raw.exr --aov variance,albedo,normal,depth,halves");
  command.example("tessera denoise raw.exr -o picture.exr");
  command.does([options](Interrupt&) { return run(*options); });
}

}  // namespace tessera::client
