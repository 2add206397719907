// tessera watch ID
#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/jobs/follow.h"
#include "command/jobs/job_selection.h"
#include "command/jobs/on_done.h"
#include "command/report/job_table.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct WatchOptions {
  ServerOption server;
  std::string job_id;
  std::string on_done;
  bool json = false;
};

int run(const WatchOptions& options, Interrupt& interrupt) {
  const std::stop_token stop = interrupt.token();
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  const auto id = find_job_id(**farm, options.job_id, stop);
  if (!id.ok()) return report_farm_error(id.status(), options.server);
  const auto job = (*farm)->job(*id, stop);
  if (!job.ok()) return report_farm_error(job.status(), options.server);
  const auto status = follow_progress(**farm, *id, job->spec(), stop);
  if (!status.ok()) return report_farm_error(status.status(), options.server);
  if (options.json) std::cout << to_json(*status) << '\n';
  return OnDone{options.on_done}.run(*status, "", report_end(*status));
}

}  // namespace

void add_watch_command(CommandLine& line) {
  auto options = std::make_shared<WatchOptions>();
  Command command = line.add_command("watch", "Show a job's progress until it ends");
  command.add("ID", options->job_id, "the job, or a unique beginning of its id").required();
  define_server_option(command, options->server);
  command.add_flag("--json", options->json, "the final status as JSON");
  define_on_done_option(command, options->on_done);
  command.example("tessera watch 4f0c2a11");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
