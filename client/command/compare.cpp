// tessera compare REF TEST
#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "image/exr.h"
#include "image/metrics.h"

namespace tessera::client {
namespace {

struct CompareCommandOptions {
  std::string reference;
  std::string test;
  CompareOptions compared;
  bool json = false;
};

int run(const CompareCommandOptions& options) {
  const auto reference = read_exr(options.reference);
  if (!reference.ok()) return report(kUsage, std::string{reference.status().message()});
  const auto test = read_exr(options.test);
  if (!test.ok()) return report(kUsage, std::string{test.status().message()});
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
  command.add_flag("--json", options->json, "as JSON");
  command.example("tessera compare reference.exr picture.exr");
  command.does([options](Interrupt&) { return run(*options); });
}

}  // namespace tessera::client
