// tessera jobs
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
  const auto jobs = (*farm)->jobs(interrupt.token());
  if (!jobs.ok()) return report_farm_error(jobs.status());
  if (options.json) {
    v1::ListJobsResponse all;
    all.mutable_jobs()->Add(jobs->begin(), jobs->end());
    std::cout << to_json(all) << '\n';
  } else {
    std::cout << jobs_table(*jobs);
  }
  return kDone;
}

}  // namespace

void add_jobs_command(CommandLine& line) {
  auto options = std::make_shared<Options>();
  Command command = line.add_command("jobs", "Lists the coordinator's jobs");
  define_server_option(command, options->server);
  command.add_flag("--json", options->json, "as JSON");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
