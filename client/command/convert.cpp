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
#include "command/report/false_color_options.h"
#include "command/report/output.h"
#include "image/color_space.h"
#include "image/exr.h"
#include "image/layer_strip.h"
#include "image/spectral_image.h"
#include "image/view/display_view.h"
#include "import/import.h"
#include "local/scene_check.h"
#include "spectra/sensor/sensor_response.h"
#include "wire/enum_words.h"
#include "wire/film_sensor.h"

namespace tessera::client {
namespace {

struct ConvertOptions {
  std::string input;
  std::string output;
  GltfOptions gltf;
  ExrFormat exr;
  std::string view_name;            // of an .exr with several views; empty: the first
  std::vector<std::string> layers;  // layers of the image to write; none: all channels
  // The space of what is seen of a spectral image, and of red, green and blue; empty: their own.
  std::string sensor, rgb_space, white_balance;
  ViewOptions view;
  FalseColorChoice false_color;
  bool quiet = false;
};

/// Returns what the sensor sees of the image's bands, or its red, green and blue in the space that was asked
/// for.
absl::StatusOr<Image> seen_image(Image image, const ConvertOptions& options) {
  v1::JobSpec::View view;
  view.set_sensor(options.sensor);
  view.set_white_balance(options.white_balance);
  if (!options.rgb_space.empty()) {
    const auto space = wire::value_of<v1::RgbSpace>(options.rgb_space);
    if (!space.ok()) return space.status();
    view.set_rgb_space(*space);
  }
  if (const absl::Status sound = wire::check_film_words(view); !sound.ok()) return sound;
  const auto film = wire::film_sensor_of(view);
  if (!film.ok()) return film.status();
  if (options.sensor.empty() && options.white_balance.empty()) {
    if (options.rgb_space.empty()) return image;
    if (image.metadata.contains(kRawChannels)) {
      return absl::InvalidArgumentError("red, green and blue are a sensor's own: they are in no space that " +
                                        options.rgb_space + " could be made of");
    }
    convert_space(film->space, image);
    return image;
  }
  if (film->sensor.kind == spectra::SensorKind::kFilm)
    return absl::InvalidArgumentError("sensor 'film' is of a scene, which an image does not have");
  const auto response = spectra::sensor_response(film->sensor, film->white, film->space);
  if (!response.ok()) return response.status();
  absl::StatusOr<Image> seen = seen_by(image, *response);
  if (!seen.ok()) return seen.status();
  if (film->sensor.kind == spectra::SensorKind::kObserver) {
    set_space(film->space, *seen);
  } else {
    seen->metadata[kRawChannels] = options.sensor;
  }
  seen->metadata["tessera.sensor"] = options.sensor.empty() ? "cie1931" : options.sensor;
  return seen;
}

int convert_image(const ConvertOptions& options) {
  if (const absl::Status status = check_output(options.output); !status.ok()) {
    return report(kUsage, std::string{status.message()});
  }
  if (options.view != ViewOptions() && is_exr(options.output)) {
    return report(kUsage,
                  "--exposure, --view, --dither and OpenColorIO are for a .png; an .exr keeps its values");
  }
  if (options.view != ViewOptions() && options.false_color.asked)
    return report(kUsage, "--false-color has colours of its own, without --exposure, --view and OpenColorIO");
  if (const auto view = make_display_view(options.view); !view.ok())
    return report(kUsage, std::string{view.status().message()});
  absl::StatusOr<Image> image = read_exr(options.input, kMostImagePixels, options.view_name);
  if (image.ok()) image = seen_image(*std::move(image), options);
  if (image.ok() && !options.layers.empty()) image = layer_strip(*image, options.layers);
  if (!image.ok()) return report(kUsage, std::string{image.status().message()});
  if (options.false_color.asked) {
    const absl::Status written = write_false_color_picture(*image, options.false_color, options.output);
    if (absl::IsInvalidArgument(written) || absl::IsFailedPrecondition(written))
      return report(kUsage, std::string{written.message()});
    return written.ok() ? kDone : report(kIncomplete, std::string{written.message()});
  }
  const absl::Status written = write_image(*image, options.output, options.exr, options.view);
  return written.ok() ? kDone : report(kIncomplete, std::string{written.message()});
}

int convert_scene(const ConvertOptions& options) {
  if (options.view != ViewOptions() || !options.layers.empty() || !options.sensor.empty() ||
      !options.white_balance.empty() || !options.rgb_space.empty() || !options.view_name.empty() ||
      options.false_color.asked) {
    return report(kUsage,
                  options.input +
                      " is a scene; --exposure, --view, --dither, OpenColorIO, --sensor, "
                      "--white-balance, --rgb-space, --view-name, --layers and --false-color are for an "
                      ".exr");
  }
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

void define_view_options(Command& command, ViewOptions& view) {
  constexpr double kMostStops = 64;
  command.add("--exposure", view.exposure_stops, "of a .png: twice as bright with each stop")
      .type_name("STOPS")
      .in_range(-kMostStops, kMostStops);
  command
      .add("--view", view.name,
           "how a .png shows what is brighter than the screen (default: srgb, which cuts it off): filmic, "
           "aces, "
           "agx, or a view of the configuration")
      .type_name("NAME");
  command.add_flag("--dither", view.dithers, "of a .png: smooth gradients without bands");
  const options::Option config =
      command.add("--ocio", view.ocio_config, "a configuration of OpenColorIO, whose views a .png has")
          .type_name("FILE");
  command.add("--ocio-display", view.ocio_display, "of the configuration (default: its own choice)")
      .type_name("NAME")
      .needs(config);
  command.add("--ocio-space", view.ocio_space, "the configuration's name of the space that the image is in")
      .type_name("NAME")
      .needs(config)
      .with_default();
}

}  // namespace

void add_convert_command(CommandLine& line) {
  auto options = std::make_shared<ConvertOptions>();
  Command command = line.add_command("convert", "Convert a scene to .textproto or .tsb, or an .exr to .png");
  command.add("IN", options->input, "a scene, or an .exr").required();
  command.add("OUT", options->output, "a .textproto or .tsb; a .png or .exr").required();
  define_exr_options(command, options->exr);
  command
      .add("--sensor", options->sensor,
           "of a spectral .exr: what sees its bands: cie1931, cie2006, cie2006-10, a camera (nikon-d5100), "
           "band:FROM-TO")
      .type_name("NAME");
  command
      .add("--white-balance", options->white_balance,
           "light that this sensor shows as white: an illuminant, kelvin, or none (default: D65)")
      .type_name("LIGHT");
  command.add("--rgb-space", options->rgb_space, "of an .exr: the space of red, green and blue")
      .one_of(wire::words_of(*google::protobuf::GetEnumDescriptor<v1::RgbSpace>()));
  command
      .add("--view-name", options->view_name, "of an .exr with several views: this one (default: the first)")
      .type_name("NAME");
  define_view_options(command, options->view);
  command
      .add("--layers", options->layers,
           "of an .exr: these layers, side by side; rgba is the picture, visits a heat map")
      .separated_by_commas()
      .type_name("NAME,...");
  define_false_color_options(command, options->false_color);
  command.add_flag("--quiet", options->quiet, "no warnings");
  define_gltf_options(command, options->gltf);
  command.example("tessera convert scene.pbrt scene.textproto");
  command.example("tessera convert picture.exr picture.png");
  command.example("tessera convert picture.exr picture.png --exposure 1.5 --view agx");
  command.example("tessera convert picture.exr luminance.png --false-color --scale log --isolines");
  command.example("tessera convert spectral.exr seen.exr --sensor cie2006 --rgb-space rec2020");
  command.does([options](Interrupt&) {
    const bool is_image = is_exr(options->input);
    return is_image ? convert_image(*options) : convert_scene(*options);
  });
}

}  // namespace tessera::client
