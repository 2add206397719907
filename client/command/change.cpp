// tessera cancel, retry, pause, resume and priority: what changes a job, and tells what became of it.
#include <CLI/CLI.hpp>

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

std::shared_ptr<Options> add_change(CLI::App& app, Action& action, const char* name, const char* description,
                                    const Change& change) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand(name, description);
  command.add_option("ID", options->job_id)->required();
  define_server_option(command, options->server);
  command.add_flag("--json", options->json, "as JSON");
  command.callback([options, change, &action] {
    action = [options, change](Interrupt& interrupt) { return run(*options, change, interrupt); };
  });
  return options;
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

void add_cancel_command(CLI::App& app, Action& action) {
  add_change(
      app, action, "cancel", "Stops a job; a finished one stays as it is",
      [](FarmClient& farm, const Options& options, std::stop_token stop) { return farm.cancel(options.job_id, stop); });
}

void add_retry_command(CLI::App& app, Action& action) {
  add_change(
      app, action, "retry", "Tries again what was set aside of a job, with a clean record",
      [](FarmClient& farm, const Options& options, std::stop_token stop) { return farm.retry(options.job_id, stop); });
}

void add_pause_command(CLI::App& app, Action& action) {
  add_change(app, action, "pause", "Begins no more units of a job; those begun are finished", set_paused(true));
}

void add_resume_command(CLI::App& app, Action& action) {
  add_change(app, action, "resume", "Goes on with a paused job", set_paused(false));
}

void add_priority_command(CLI::App& app, Action& action) {
  const auto options = add_change(app, action, "priority", "Changes the priority of a job; higher goes first",
                                  [](FarmClient& farm, const Options& chosen, std::stop_token stop) {
                                    v1::AdjustJobRequest request;
                                    request.set_job_id(chosen.job_id);
                                    request.set_priority(chosen.priority);
                                    return farm.adjust(request, stop);
                                  });
  app.get_subcommand("priority")->add_option("PRIORITY", options->priority)->required();
}

}  // namespace tessera::client
