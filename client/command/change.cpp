// tessera cancel, retry, pause, resume and priority: what changes a job, and tells what became of it.
#include <functional>
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
  std::int32_t priority = 0;
  bool json = false;
};

using Change = std::function<absl::StatusOr<v1::JobStatus>(FarmClient&, const Options&, std::stop_token)>;

int run(const Options& options, const Change& change, Interrupt& interrupt) {
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status());
  const auto status = change(**farm, options, interrupt.token());
  if (!status.ok()) return report_farm_error(status.status());
  if (options.json) {
    std::cout << to_json(*status) << '\n';
  } else {
    std::cout << "job " << status->job_id() << ": " << state_text(*status) << '\n';
  }
  return kDone;
}

/// A subcommand about one job. The options are for those that have more of them.
Command add_change(CommandLine& line, const char* name, const char* description, const Change& change,
                   std::shared_ptr<Options> options = std::make_shared<Options>()) {
  Command command = line.add_command(name, description);
  command.add("ID", options->job_id).required();
  define_server_option(command, options->server);
  command.add_flag("--json", options->json, "as JSON");
  command.does([options, change](Interrupt& interrupt) { return run(*options, change, interrupt); });
  return command;
}

Change set_paused(bool paused) {
  return [paused](FarmClient& farm, const Options& options, std::stop_token stop) {
    v1::AdjustJobRequest request;
    request.set_job_id(options.job_id);
    request.set_paused(paused);
    return farm.adjust(request, stop);
  };
}

}  // namespace

void add_cancel_command(CommandLine& line) {
  add_change(
      line, "cancel", "Stops a job; a finished one stays as it is",
      [](FarmClient& farm, const Options& options, std::stop_token stop) { return farm.cancel(options.job_id, stop); });
}

void add_retry_command(CommandLine& line) {
  add_change(
      line, "retry", "Tries again what was set aside of a job, with a clean record",
      [](FarmClient& farm, const Options& options, std::stop_token stop) { return farm.retry(options.job_id, stop); });
}

void add_pause_command(CommandLine& line) {
  add_change(line, "pause", "Begins no more units of a job; those begun are finished", set_paused(true));
}

void add_resume_command(CommandLine& line) {
  add_change(line, "resume", "Goes on with a paused job", set_paused(false));
}

void add_priority_command(CommandLine& line) {
  const auto options = std::make_shared<Options>();
  const Change change = [](FarmClient& farm, const Options& chosen, std::stop_token stop) {
    v1::AdjustJobRequest request;
    request.set_job_id(chosen.job_id);
    request.set_priority(chosen.priority);
    return farm.adjust(request, stop);
  };
  add_change(line, "priority", "Changes the priority of a job; higher goes first", change, options)
      .add("PRIORITY", options->priority)
      .required();
}

}  // namespace tessera::client
