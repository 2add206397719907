// tessera job ID
#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/jobs/job_selection.h"
#include "command/report/job_table.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct JobOptions {
  ServerOption server;
  std::string job_id;
  bool json = false;
};

int run(const JobOptions& options, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  const std::stop_token stop = interrupt.token();
  const auto id = find_job_id(**farm, options.job_id, stop);
  if (!id.ok()) return report_farm_error(id.status(), options.server);
  const auto job = (*farm)->job(*id, stop);
  if (!job.ok()) return report_farm_error(job.status(), options.server);
  std::cout << (options.json ? to_json(*job) + "\n" : job_text(*job));
  return kDone;
}

}  // namespace

void add_job_command(CommandLine& line) {
  auto options = std::make_shared<JobOptions>();
  Command command = line.add_command("job", "Show one job");
  command.add("ID", options->job_id, "the job, or a unique beginning of its id").required();
  define_server_option(command, options->server);
  command.add_flag("--json", options->json, "as JSON");
  command.example("tessera job 4f0c2a11");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
