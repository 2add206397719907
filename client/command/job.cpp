// tessera job ID
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
  std::string job_id;
  bool json = false;
};

int run(const Options& options, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status());
  const auto job = (*farm)->job(options.job_id, interrupt.token());
  if (!job.ok()) return report_farm_error(job.status());
  std::cout << (options.json ? to_json(*job) + "\n" : job_text(*job));
  return kDone;
}

}  // namespace

void add_job_command(CommandLine& line) {
  auto options = std::make_shared<Options>();
  Command command = line.add_command("job", "Shows one job");
  command.add("ID", options->job_id).required();
  define_server_option(command, options->server);
  command.add_flag("--json", options->json, "as JSON");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
