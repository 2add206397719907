// tessera workers
#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/job_table.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct Options {
  ServerOption server;
  bool json = false;
};

int run(const Options& options, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status());
  const auto workers = (*farm)->workers(interrupt.token());
  if (!workers.ok()) return report_farm_error(workers.status());
  if (options.json) {
    v1::ListWorkersResponse all;
    all.mutable_workers()->Add(workers->begin(), workers->end());
    std::cout << to_json(all) << '\n';
  } else {
    std::cout << workers_table(*workers);
  }
  return kDone;
}

}  // namespace

void add_workers_command(CommandLine& line) {
  auto options = std::make_shared<Options>();
  Command command = line.add_command("workers", "Lists the coordinator's workers");
  define_server_option(command, options->server);
  command.add_flag("--json", options->json, "as JSON");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
