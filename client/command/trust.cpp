// tessera trust HOST
#include <CLI/CLI.hpp>

#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct Options {
  ServerOption server;
  std::string host;
};

int run(const Options& options, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status());
  const absl::Status status = (*farm)->trust(options.host, interrupt.token());
  if (!status.ok()) return report_farm_error(status);
  std::cout << "host " << options.host << " is trusted\n";
  return kDone;
}

}  // namespace

void add_trust_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("trust", "Lets a host work again that had returned wrong pixels");
  command.add_option("HOST", options->host)->required();
  define_server_option(command, options->server);
  command.callback([options, &action] { action = [options](Interrupt& interrupt) { return run(*options, interrupt); }; });
}

}  // namespace tessera::client
