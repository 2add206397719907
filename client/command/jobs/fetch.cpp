// tessera fetch ID -o OUT
#include <memory>

#include "absl/strings/str_cat.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/jobs/follow.h"
#include "command/jobs/job_selection.h"
#include "command/jobs/on_done.h"
#include "command/report/exr_options.h"
#include "command/report/output.h"
#include "command/report/scene_facts.h"
#include "command/server_option.h"

namespace tessera::client {
namespace {

struct FetchOptions {
  ServerOption server;
  std::string job_id;
  std::string output;
  ExrFormat exr;
  std::string on_done;
  bool partial = false;
  bool quiet = false;
};

int run(const FetchOptions& options, Interrupt& interrupt) {
  if (const absl::Status status = check_output(options.output, options.exr); !status.ok()) {
    return report(kUsage, std::string{status.message()});
  }
  const std::stop_token stop = interrupt.token();
  const auto farm = connect(options.server, options.quiet);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  const auto id = find_job_id(**farm, options.job_id, stop);
  if (!id.ok()) return report_farm_error(id.status(), options.server);
  const auto job = (*farm)->job(*id, stop);
  if (!job.ok()) return report_farm_error(job.status(), options.server);
  PartialImage partial;
  if (options.partial) {
    partial = {.wanted = true, .units = job->status().units_done()};
    if (partial.units == 0 && !has_ended(job->status().state())) {
      return report(kIncomplete, absl::StrCat("job ", *id, " has no results yet"));
    }
  }
  auto followed = follow_job(**farm, *id, job->spec(),
                             {.quiet = options.quiet,
                              .building = {},
                              .frame_memory = frame_memory(options.exr),
                              .mattes = nameless_mattes(options.exr.matte_ranks)},
                             stop, partial);
  if (!followed.ok()) return report_farm_error(followed.status(), options.server);
  const int exit_code = deliver(*followed, job->spec(), options.output, options.exr, options.quiet);
  return OnDone{options.on_done}.run(followed->status, options.output, exit_code);
}

}  // namespace

void add_fetch_command(CommandLine& line) {
  auto options = std::make_shared<FetchOptions>();
  Command command = line.add_command("fetch", "Wait for the end of a job and write its image");
  command.add("ID", options->job_id, "the job, or a unique beginning of its id").required();
  command.add("-o,--output", options->output, "the image, .exr or .png").type_name("FILE").required();
  define_exr_options(command, options->exr);
  define_multiview(command, options->exr);
  command.add_flag("--partial", options->partial, "write a partial image, if the job is not done");
  define_on_done_option(command, options->on_done);
  command.add_flag("--quiet", options->quiet, "no progress, no warnings");
  define_server_option(command, options->server);
  command.example("tessera fetch 4f0c2a11 -o scene.exr");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
