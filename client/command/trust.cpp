// tessera trust HOST
#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct TrustOptions {
  ServerOption server;
  std::string host;
};

int run(const TrustOptions& options, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  const absl::Status status = (*farm)->trust(options.host, interrupt.token());
  if (!status.ok()) return report_farm_error(status, options.server);
  std::cout << "host " << options.host << " is trusted\n";
  return kDone;
}

}  // namespace

void add_trust_command(CommandLine& line) {
  auto options = std::make_shared<TrustOptions>();
  Command command = line.add_command("trust", "Lift the quarantine of a host");
  command.add("HOST", options->host, "as tessera workers names it").required();
  define_server_option(command, options->server);
  command.example("tessera trust render7");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
