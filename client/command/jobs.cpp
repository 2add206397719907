// tessera jobs
#include <CLI/CLI.hpp>

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

void add_jobs_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("jobs", "Lists the coordinator's jobs");
  define_server_option(command, options->server);
  command.add_flag("--json", options->json, "as JSON");
  command.callback([options, &action] { action = [options](Interrupt& interrupt) { return run(*options, interrupt); }; });
}

}  // namespace tessera::client
