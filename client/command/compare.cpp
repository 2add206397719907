// tessera compare REF TEST
#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "image/color_space.h"
#include "image/exr.h"
#include "image/metrics.h"
#include "image/spectral_metrics.h"
#include "spectra/sensor/sensor_name.h"

namespace tessera::client {
namespace {

struct CompareCommandOptions {
  std::string reference;
  std::string test;
  std::string view_name;  // of files with several views; empty: the first of each
  CompareOptions compared;
  bool spectral = false;
  std::string observer = "cie1931";
  bool json = false;
};

absl::StatusOr<std::string> compare_spectra(const Image& reference, const Image& test,
                                            const CompareCommandOptions& options) {
  const auto observer = spectra::parse_sensor(options.observer);
  if (!observer.ok()) return observer.status();
  if (observer->kind != spectra::SensorKind::kObserver)
    return absl::InvalidArgumentError("colours differ to an observer; '" + options.observer + "' is none");
  const auto comparison = compare_bands(reference, test, observer->sensitivities);
  if (!comparison.ok()) return comparison.status();
  return options.json ? to_json(*comparison) : to_text(*comparison);
}

int run(const CompareCommandOptions& options) {
  const auto reference = read_exr(options.reference, kMostImagePixels, options.view_name);
  if (!reference.ok()) return report(kUsage, std::string{reference.status().message()});
  auto test = read_exr(options.test, kMostImagePixels, options.view_name);
  if (!test.ok()) return report(kUsage, std::string{test.status().message()});
  convert_space(space_of(*reference), *test);
  if (options.spectral) {
    const auto text = compare_spectra(*reference, *test, options);
    if (!text.ok()) return report(kUsage, std::string{text.status().message()});
    std::cout << *text << '\n';
    return kDone;
  }
  const auto comparison = compare_images(*reference, *test, options.compared);
  if (!comparison.ok()) return report(kUsage, std::string{comparison.status().message()});
  std::cout << (options.json ? to_json(*comparison) : to_text(*comparison, options.compared)) << '\n';
  return kDone;
}

}  // namespace

void add_compare_command(CommandLine& line) {
  auto options = std::make_shared<CompareCommandOptions>();
  Command command = line.add_command("compare", "Measure the error of an EXR image against a reference");
  command.add("REF", options->reference, "the reference, .exr").required();
  command.add("TEST", options->test, "the image, .exr").required();
  command.add("--block", options->compared.block, "side in pixels of the blocks whose means are compared")
      .in_range(1, 4096)
      .with_default();
  command
      .add("--view-name", options->view_name,
           "of files with several views: this one (default: the first of each)")
      .type_name("NAME");
  const options::Option spectral =
      command.add_flag("--spectral", options->spectral,
                       "bands of spectral images: error of each, and CIEDE2000 to an observer");
  command.add("--sensor", options->observer, "that observer: cie1931, cie2006 or cie2006-10")
      .with_default()
      .needs(spectral);
  command.add_flag("--json", options->json, "as JSON");
  command.example("tessera compare reference.exr picture.exr");
  command.example("tessera compare --spectral reference.exr picture.exr");
  command.does([options](Interrupt&) { return run(*options); });
}

}  // namespace tessera::client
