// tessera workers
#include <unistd.h>

#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/report/job_table.h"
#include "command/report/table.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct WorkersOptions {
  ServerOption server;
  bool json = false;
};

int run(const WorkersOptions& options, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  const auto workers = (*farm)->workers(interrupt.token());
  if (!workers.ok()) return report_farm_error(workers.status(), options.server);
  if (options.json) {
    v1::ListWorkersResponse all;
    all.mutable_workers()->Add(workers->begin(), workers->end());
    std::cout << to_json(all) << '\n';
  } else {
    std::cout << workers_table(*workers, table_width(STDOUT_FILENO));
  }
  return kDone;
}

}  // namespace

void add_workers_command(CommandLine& line) {
  auto options = std::make_shared<WorkersOptions>();
  Command command = line.add_command("workers", "List the coordinator's workers");
  define_server_option(command, options->server);
  command.example("tessera workers --server 10.0.0.1:7070 --tls ~/farm-tls/client-$USER");
  command.add_flag("--json", options->json, "as JSON");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
