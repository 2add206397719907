// tessera render SCENE -o OUT: everything in this process.
#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/follow.h"
#include "command/interrupt.h"
#include "command/output.h"
#include "command/render_options.h"
#include "command/stats_file.h"
#include "command/time_spent.h"
#include "farm/farm_client.h"
#include "local/local_farm.h"
#include "wire/cpu_time.h"

namespace tessera::client {
namespace {

using Clock = std::chrono::steady_clock;

/// The job from submission to its end.
absl::StatusOr<FollowedJob> run_job(LocalFarm& farm, const v1::JobSpec& spec, bool quiet, std::stop_token stop) {
  FarmClient client{farm.channel(), {.address = "this process"}};
  const absl::StatusOr<std::string> job_id = client.submit(spec, {}, stop);
  if (!job_id.ok()) return job_id.status();
  return follow_job(client, *job_id, spec, quiet, stop);
}

int run(const RenderOptions& options, Interrupt& interrupt) {
  if (const absl::Status status = check_output(options.output); !status.ok()) {
    return report(kUsage, std::string{status.message()});
  }
  int exit_code = kDone;
  const std::unique_ptr<LoadedJob> loaded = load_job(options, exit_code);
  if (loaded == nullptr) return exit_code;
  v1::JobSpec& spec = loaded->job->spec;
  if (const std::vector<std::string> isas = local_isas(); spec.isa().empty() && !isas.empty())
    spec.set_isa(isas.front());

  const std::stop_token stop = interrupt.token();
  const absl::StatusOr<std::unique_ptr<LocalFarm>> farm = LocalFarm::start(
      {.threads = options.threads, .isa = spec.isa(), .blobs = loaded->job->blobs, .geometry_read = [&loaded] {
         loaded->free_meshes();
       }});
  if (!farm.ok()) return report(kJobFailed, std::string{farm.status().message()});

  const Clock::time_point start = Clock::now();
  absl::StatusOr<FollowedJob> followed = run_job(**farm, spec, options.quiet, stop);
  if (!followed.ok()) return report_farm_error(followed.status());
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  exit_code = deliver(*followed, spec, options.output, options.half, options.quiet);
  const TimeSpent spent =
      time_spent(followed->status.stats(), ProcessTime{.import_seconds = loaded->import_cpu_seconds,
                                                       .total_seconds = wire::in_seconds(wire::process_cpu_time())});
  if (const std::string text = to_text(spent); !options.quiet && !text.empty()) std::cerr << text << '\n';
  if (options.stats.empty()) return exit_code;

  RenderStatistics statistics;
  statistics.load_seconds = loaded->import_seconds;
  statistics.build_seconds = (*farm)->build_seconds();
  statistics.render_wall_seconds = std::max(0.0, seconds - *statistics.build_seconds);
  statistics.import_warnings = loaded->warning_lines();
  statistics.spec = spec;
  statistics.status = followed->status;
  statistics.time = spent;
  if (const absl::Status status = write_statistics(statistics, options.stats); !status.ok()) {
    return report(kIncomplete, std::string{status.message()});
  }
  return exit_code;
}

}  // namespace

void add_render_command(CommandLine& line) {
  auto options = std::make_shared<RenderOptions>();
  Command command = line.add_command("render", "Renders a scene in this process");
  define_render_options(command, *options);
  command.option("--output").required();
  options->threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  command.add("--threads", options->threads, "tiles rendered at once").in_range(1, 1024).with_default();
  command.option("--isa").one_of(local_isas());
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
