// tessera jobs
#include <unistd.h>

#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/jobs/job_selection.h"
#include "command/report/job_table.h"
#include "command/report/table.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct JobsOptions {
  ServerOption server;
  JobFilter filter;
  bool json = false;
};

int run(const JobsOptions& options, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  auto jobs = (*farm)->jobs(interrupt.token());
  if (!jobs.ok()) return report_farm_error(jobs.status(), options.server);
  std::erase_if(*jobs, [&](const v1::JobStatus& job) { return !matches(options.filter, job); });
  if (options.json) {
    v1::ListJobsResponse all;
    all.mutable_jobs()->Add(jobs->begin(), jobs->end());
    std::cout << to_json(all) << '\n';
  } else {
    std::cout << jobs_table(*jobs, table_width(STDOUT_FILENO));
  }
  return kDone;
}

}  // namespace

void add_jobs_command(CommandLine& line) {
  auto options = std::make_shared<JobsOptions>();
  Command command = line.add_command("jobs", "List the coordinator's jobs");
  define_job_filter(command, options->filter);
  command.group("Output");
  command.add_flag("--json", options->json, "as JSON");
  define_server_option(command, options->server);
  command.example("tessera jobs --user $USER --state running");
  command.example("tessera jobs --server 10.0.0.1:7070 --tls ~/farm-tls/client-$USER");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
