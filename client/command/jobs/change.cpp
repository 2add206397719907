// tessera cancel, delete, retry, pause, resume and priority: what changes jobs, and tells what became of
// each.
#include <algorithm>
#include <atomic>
#include <functional>
#include <iostream>
#include <memory>
#include <thread>

#include "absl/strings/str_cat.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/jobs/job_selection.h"
#include "command/report/job_table.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct ChangeOptions {
  ServerOption server;
  JobSelection jobs;
  std::int32_t priority = 0;
  bool json = false;
};

/// Output about one job, for people and for programs.
struct Told {
  std::string text, json;
};

/// The change that a command makes to one job, and the jobs to which it may be made.
struct Change {
  std::function<absl::StatusOr<Told>(FarmClient&, const ChangeOptions&, const std::string& job,
                                     std::stop_token)>
      apply;
  Suits suits;
};

bool is_over(const v1::JobStatus& job) { return has_ended(job.state()); }
bool is_open(const v1::JobStatus& job) { return !has_ended(job.state()); }

// Calls at a time, over one connection: many together cost the coordinator one write to its disk.
constexpr std::size_t kCallsAtOnce = 16;

/// Applies the change to every job; the answers are in the order of the jobs.
std::vector<absl::StatusOr<Told>> apply_to_all(FarmClient& farm, const ChangeOptions& options,
                                               const Change& change, const std::vector<std::string>& jobs,
                                               std::stop_token stop) {
  std::vector<absl::StatusOr<Told>> answers(jobs.size(), absl::CancelledError("interrupted"));
  std::atomic<std::size_t> next = 0;
  const auto work = [&](FarmClient& client) {
    for (std::size_t i = next++; i < jobs.size(); i = next++) {
      answers[i] = change.apply(client, options, jobs[i], stop);
      if (stop.stop_requested()) return;
    }
  };
  std::vector<std::jthread> others;
  for (std::size_t i = 1; i < std::min(kCallsAtOnce, jobs.size()); ++i) {
    others.emplace_back([&work, client = farm.another()] { work(*client); });
  }
  work(farm);
  others.clear();
  return answers;
}

int run(const ChangeOptions& options, const Change& change, Interrupt& interrupt) {
  const std::stop_token stop = interrupt.token();
  const auto farm = connect(options.server);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  const auto jobs = select_jobs(**farm, options.jobs, change.suits, stop);
  if (!jobs.ok()) return report_farm_error(jobs.status(), options.server);
  if (jobs->empty()) std::cerr << "tessera: no job is like that" << std::endl;
  int exit_code = kDone;
  for (const absl::StatusOr<Told>& told : apply_to_all(**farm, options, change, *jobs, stop)) {
    if (told.ok()) {
      std::cout << (options.json ? told->json : told->text) << '\n';
    } else if (const int code = report_farm_error(told.status(), options.server); exit_code == kDone) {
      exit_code = code;
    }
  }
  return exit_code;
}

/// A subcommand about jobs. The options are for those that have more of them.
Command add_change(CommandLine& line, const char* name, const char* description, const Change& change,
                   std::shared_ptr<ChangeOptions> options = std::make_shared<ChangeOptions>()) {
  Command command = line.add_command(name, description);
  define_job_selection(command, options->jobs);
  command.group("Output");
  command.add_flag("--json", options->json, "as JSON, one object a line");
  define_server_option(command, options->server);
  command.does([options, change](Interrupt& interrupt) { return run(*options, change, interrupt); });
  return command;
}

absl::StatusOr<Told> tell(const absl::StatusOr<v1::JobStatus>& status) {
  if (!status.ok()) return status.status();
  return Told{absl::StrCat("job ", status->job_id(), ": ", state_text(*status)), to_json(*status)};
}

Change set_paused(bool paused) {
  return {[paused](FarmClient& farm, const ChangeOptions&, const std::string& job, std::stop_token stop) {
            v1::AdjustJobRequest request;
            request.set_job_id(job);
            request.set_paused(paused);
            return tell(farm.adjust(request, stop));
          },
          is_open};
}

}  // namespace

void add_cancel_command(CommandLine& line) {
  add_change(line, "cancel", "Cancel jobs; finished ones stay as they are",
             {[](FarmClient& farm, const ChangeOptions&, const std::string& job, std::stop_token stop) {
                return tell(farm.cancel(job, stop));
              },
              is_open})
      .example("tessera cancel 4f0c 91be")
      .example("tessera cancel --user $USER --state queued");
}

void add_delete_command(CommandLine& line) {
  add_change(line, "delete", "Delete jobs that are over, and their results",
             {[](FarmClient& farm, const ChangeOptions&, const std::string& job,
                 std::stop_token stop) -> absl::StatusOr<Told> {
                if (absl::Status status = farm.delete_job(job, stop); !status.ok()) return status;
                return Told{absl::StrCat("job ", job, ": deleted"),
                            absl::StrCat("{\"job_id\":\"", job, "\",\"deleted\":true}")};
              },
              is_over})
      .example("tessera delete 4f0c")
      .example("tessera delete --state cancelled");
}

void add_retry_command(CommandLine& line) {
  add_change(line, "retry", "Retry the units of jobs that were set aside",
             {[](FarmClient& farm, const ChangeOptions&, const std::string& job, std::stop_token stop) {
                return tell(farm.retry(job, stop));
              },
              [](const v1::JobStatus& job) { return job.units_set_aside() > 0; }})
      .example("tessera retry 4f0c");
}

void add_pause_command(CommandLine& line) {
  add_change(line, "pause", "Pause jobs; units that are leased are finished", set_paused(true))
      .example("tessera pause 4f0c");
}

void add_resume_command(CommandLine& line) {
  add_change(line, "resume", "Resume paused jobs", set_paused(false))
      .example("tessera resume --state paused");
}

void add_priority_command(CommandLine& line) {
  const auto options = std::make_shared<ChangeOptions>();
  const Change change = {
      [](FarmClient& farm, const ChangeOptions& chosen, const std::string& job, std::stop_token stop) {
        v1::AdjustJobRequest request;
        request.set_job_id(job);
        request.set_priority(chosen.priority);
        return tell(farm.adjust(request, stop));
      },
      is_open};
  Command command =
      add_change(line, "priority", "Change the priority of jobs; higher goes first", change, options);
  command.add("PRIORITY", options->priority, "a whole number; 0 is usual").required();
  command.example("tessera priority 4f0c 91be 5");
}

}  // namespace tessera::client
