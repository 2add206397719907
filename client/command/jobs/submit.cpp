// tessera submit SCENE -o OUT: renders on the farm.
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "command/command.h"
#include "command/denoise_result.h"
#include "command/exit_code.h"
#include "command/frames/frames.h"
#include "command/interrupt.h"
#include "command/jobs/follow.h"
#include "command/jobs/job_selection.h"
#include "command/jobs/on_done.h"
#include "command/render_options.h"
#include "command/report/output.h"
#include "command/report/phase.h"
#include "command/report/stats_file.h"
#include "command/server_option.h"
#include "wire/digest.h"
#include "wire/enum_words.h"
#include "wire/version.h"

namespace tessera::client {
namespace {

using Clock = std::chrono::steady_clock;

/// Name of the user as the system has it, also where no login has set $USER.
std::string user_name() {
  if (const char* const user = std::getenv("USER"); user != nullptr && *user != '\0') return user;
  const passwd* const entry = getpwuid(geteuid());
  return entry != nullptr ? entry->pw_name : absl::StrCat("uid-", geteuid());
}

struct SubmitOptions {
  RenderOptions render;
  ServerOption server;
  FarmClient::Reuse reuse;
  std::vector<std::string> after;
  std::string on_done;
  bool detach = false;
};

absl::Status check(const SubmitOptions& options) {
  if (absl::Status status = check_stats(options.render); !status.ok()) return status;
  if (options.detach && !options.on_done.empty())
    return absl::InvalidArgumentError("--on-done is for commands that wait: with --detach, see watch");
  if (options.detach && !options.render.frames.preview_video.empty())
    return absl::InvalidArgumentError("--preview-video is of images: it does not go with --detach");
  if (options.render.output.empty()) {
    if (options.detach) return absl::OkStatus();
    return absl::InvalidArgumentError("--output is required, unless with --detach");
  }
  return check_output(options.render.output, options.render.exr);
}

/// The job that is continued; nothing where there is none.
absl::StatusOr<std::optional<v1::JobSpec>> continued_job(FarmClient& farm, const std::string& continued) {
  if (continued.empty()) return std::nullopt;
  absl::StatusOr<v1::GetJobResponse> job = farm.job(continued, {});
  if (!job.ok()) return job.status();
  return std::move(*job->mutable_spec());
}

/// Whole ids of the jobs that have to be done first.
absl::StatusOr<std::vector<std::string>> ids_of(FarmClient& farm, const std::vector<std::string>& after) {
  std::vector<std::string> ids;
  for (const std::string& beginning : after) {
    absl::StatusOr<std::string> id = find_job_id(farm, beginning, {});
    if (!id.ok()) return id.status();
    ids.push_back(*std::move(id));
  }
  return ids;
}

absl::StatusOr<std::uint64_t> upload(FarmClient& farm, const LoadedJob& loaded, bool quiet,
                                     std::stop_token stop) {
  Phase phase{progress_mode(STDERR_FILENO, quiet), std::cerr, loaded.job->spec.farm().name(), "uploading"};
  return farm.upload(loaded.job->blobs, stop, [&](std::uint64_t sent, std::uint64_t total) {
    phase.detail(format_bytes(sent, total));
  });
}

/// Follows the submitted job to its image.
int wait_for_image(const SubmitOptions& options, FarmClient& farm, const std::string& job_id,
                   const LoadedJob& loaded, std::uint64_t uploaded_bytes, std::stop_token stop) {
  const v1::JobSpec& spec = loaded.job->spec;
  const Clock::time_point start = Clock::now();
  absl::StatusOr<FollowedJob> followed =
      follow_job(farm, job_id, spec,
                 {.quiet = options.render.quiet,
                  .building = {},
                  .frame_memory = frame_memory(options.render.exr, denoise_memory(options.render, spec)),
                  .mattes = loaded.mattes(options.render)},
                 stop);
  if (!followed.ok()) {
    const int exit_code = report_farm_error(followed.status(), options.server);
    std::cerr << "tessera: the job goes on; its image comes with: tessera fetch " << job_id << " -o "
              << options.render.output << " --server " << options.server.address << std::endl;
    return exit_code;
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const OnDone on_done{options.on_done};
  loaded.describe(options.render, *followed);
  denoise_result(options.render, spec, *followed);
  const int exit_code =
      deliver(*followed, spec, options.render.output, options.render.exr, options.render.quiet);
  if (options.render.stats.empty()) return on_done.run(followed->status, options.render.output, exit_code);

  RenderStatistics statistics;
  statistics.load_seconds = loaded.import_seconds;
  statistics.render_wall_seconds = seconds;
  statistics.uploaded_bytes = uploaded_bytes;
  statistics.import_warnings = loaded.warning_lines();
  statistics.spec = spec;
  statistics.status = followed->status;
  statistics.time = time_spent(followed->status.stats());
  if (const absl::Status status = write_statistics(statistics, options.render.stats); !status.ok()) {
    return report(kIncomplete, std::string{status.message()});
  }
  return on_done.run(followed->status, options.render.output, exit_code);
}

/// A job on the farm, and what its image will need.
struct Submitted {
  std::unique_ptr<LoadedJob> loaded;
  std::string id;
  std::uint64_t uploaded_bytes = 0;
};

/// Submits a frame, unless the same command, begun before and killed, has left its job there: queued, in work
/// or done. Its request is named by what is asked for, and after a job that was given up by that job, too.
absl::StatusOr<std::string> submit_frame(FarmClient& farm, const v1::JobSpec& spec, FarmClient::Reuse reuse,
                                         std::stop_token stop) {
  v1::JobSpec asked = spec;
  asked.mutable_content()->set_build(wire::build_version());
  asked.mutable_farm()->clear_group();        // another one each time
  asked.mutable_farm()->clear_auto_choice();  // has the time that it took
  const std::string digest = wire::sha256_hex(asked.SerializeAsString());
  reuse.request_id = digest;
  while (true) {
    absl::StatusOr<std::string> id = farm.submit(spec, reuse, stop);
    if (!id.ok()) return id;
    const absl::StatusOr<v1::GetJobResponse> job = farm.job(*id, stop);
    if (!job.ok()) return job.status();
    const bool is_new = job->spec().farm().group() == spec.farm().group();
    if (is_new || !has_ended(job->status().state()) || job->status().state() == v1::DONE) return id;
    reuse.request_id = absl::StrCat(digest, "-", *id);
  }
}

/// Loads, uploads and submits. Nothing, with the exit code set, where that does not work.
std::optional<Submitted> submit(const SubmitOptions& options, FarmClient& farm, Interrupt& interrupt,
                                int& exit_code) {
  const auto fail = [&](const absl::Status& status) {
    exit_code = report_farm_error(status, options.server);
    return std::nullopt;
  };
  const auto continued = continued_job(farm, options.reuse.continued);
  if (!continued.ok()) return fail(continued.status());
  const absl::StatusOr<std::vector<std::string>> after = ids_of(farm, options.after);
  if (!after.ok()) return fail(after.status());
  // --threads is not for this command.
  const auto threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const ChoiceOptions choice{
      .threads = threads, .stop = [&] { return interrupt.token(); }, .continued = *continued};
  Submitted job{load_job(options.render, exit_code, nullptr, &choice), "", 0};
  if (job.loaded == nullptr) return std::nullopt;
  const absl::Status fits =
      options.detach ? absl::OkStatus() : check_denoise_memory(options.render, job.loaded->job->spec);
  if (!fits.ok()) {
    exit_code = report(kUsage, std::string{fits.message()});
    return std::nullopt;
  }
  const std::stop_token stop = interrupt.token();
  const absl::StatusOr<std::uint64_t> uploaded = upload(farm, *job.loaded, options.render.quiet, stop);
  if (!uploaded.ok()) return fail(uploaded.status());
  job.uploaded_bytes = *uploaded;
  v1::JobSpec& spec = job.loaded->job->spec;
  if (*continued) {
    // Only equal units have equal results.
    spec.mutable_cut()->set_tile_size((*continued)->cut().tile_size());
    // With noise, a unit takes all samples; where these differ, the farm says so.
    if (spec.samples().noise() == 0)
      spec.mutable_cut()->set_samples_per_unit((*continued)->cut().samples_per_unit());
  }
  for (const std::string& id : *after) spec.mutable_farm()->add_after(id);
  const bool is_frame = options.render.frame && !options.reuse.fresh;
  absl::StatusOr<std::string> job_id =
      is_frame ? submit_frame(farm, spec, options.reuse, stop) : farm.submit(spec, options.reuse, stop);
  if (!job_id.ok()) return fail(job_id.status());
  job.id = *std::move(job_id);
  if (options.detach || !options.render.quiet) std::cout << "job " << job.id << std::endl;
  return job;
}

/// Frames that are on the farm before the image of the first of them is waited for.
constexpr std::size_t kFramesAhead = 16;

/// A word for the jobs of one command: when it began, and by which process.
std::string new_group(const RenderOptions& options) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return absl::StrCat(std::filesystem::path(options.scene).filename().string(), "-",
                      absl::Hex(std::chrono::duration_cast<std::chrono::milliseconds>(now).count()), "-",
                      getpid());
}

int run_animation(const SubmitOptions& options, FarmClient& farm, Interrupt& interrupt) {
  if (!options.reuse.continued.empty())
    return report(kUsage, "--continue is for one image: it does not go with --frames");
  std::uint64_t uploaded = 0;
  RenderOptions all = options.render;
  all.group = new_group(all);
  const auto start = [&](const RenderOptions& frame, int& exit_code) -> FrameJob {
    auto own = std::make_shared<SubmitOptions>(options);
    own->render = frame;
    std::optional<Submitted> submitted = submit(*own, farm, interrupt, exit_code);
    if (!submitted) return nullptr;
    uploaded += submitted->uploaded_bytes;
    submitted->loaded->free_blobs();
    const auto job = std::make_shared<Submitted>(*std::move(submitted));
    return [own, job, &farm, &interrupt] {
      if (own->detach) return static_cast<int>(kDone);
      return wait_for_image(*own, farm, job->id, *job->loaded, job->uploaded_bytes, interrupt.token());
    };
  };
  const int exit_code =
      run_frames(all, kFramesAhead, start, interrupt.token(), options.detach ? "submitted" : "rendered");
  if (!options.render.quiet) std::cerr << "uploaded " << uploaded << " bytes for all frames\n";
  return exit_code;
}

int run(const SubmitOptions& options, Interrupt& interrupt) {
  const bool is_animation = !options.render.frames.frames.empty();
  absl::Status sound = is_animation ? check_frames(options.render) : absl::OkStatus();
  sound.Update(check(options));
  if (!sound.ok()) return report(kUsage, std::string{sound.message()});
  const auto farm = connect(options.server, options.render.quiet);
  if (!farm.ok()) return report_farm_error(farm.status(), options.server);
  // A coordinator that is not there is better noticed before a long import than after it.
  const auto workers = (*farm)->workers({});
  if (!workers.ok()) return report_farm_error(workers.status(), options.server);
  if (workers->empty() && !options.render.quiet) {
    std::cerr << "tessera: " << options.server.address << " has no worker yet; the job will wait for one"
              << std::endl;
  }
  if (is_animation) return run_animation(options, **farm, interrupt);
  int exit_code = kDone;
  const std::optional<Submitted> job = submit(options, **farm, interrupt, exit_code);
  if (!job) return exit_code;
  if (options.detach) return kDone;
  return wait_for_image(options, **farm, job->id, *job->loaded, job->uploaded_bytes, interrupt.token());
}

}  // namespace

void add_submit_command(CommandLine& line) {
  auto options = std::make_shared<SubmitOptions>();
  Command command = line.add_command("submit", "Render a scene on the farm");
  define_render_options(command, options->render);
  define_frame_options(command, options->render);
  command.group("Job");
  JobSettings& job = options->render.job;
  job.user = user_name();
  command.add_flag("--detach", options->detach, "do not wait: print the job's id and leave");
  command.add("--user", job.user, "user to whose share of the farm the job counts")
      .type_name("NAME")
      .with_default("yours on this machine");
  command.add("--priority", job.priority, "higher goes first").with_default();
  command.add("--require", job.required_tags, "tags that a worker must have")
      .separated_by_commas()
      .type_name("TAG,...");
  const auto set_bits = [&bits = job.bits](const std::string& word) {
    const absl::StatusOr<v1::Bits> known = wire::value_of<v1::Bits>(word);
    if (known.ok()) bits = *known;
    return known.status();
  };
  command
      .add_read_by(
          "--bits", set_bits,
          "same: machines that round alike render all of it; any: every machine works (default: as the farm "
          "has it)")
      .one_of(wire::words_of(*v1::Bits_descriptor()));
  command.add("--max-workers", job.max_workers, "workers at a time; 0: any number").with_default();
  command.add("--after", options->after, "jobs that have to be done before this one begins")
      .separated_by_commas()
      .type_name("JOB,...");
  command.add("--comment", job.comment, "shown by jobs and job").type_name("TEXT");
  define_on_done_option(command, options->on_done);
  command.add("--webhook", job.webhook, "told of the job's end; one that the coordinator allows")
      .type_name("URL");
  const Option continued = command
                               .add("--continue", options->reuse.continued,
                                    "job from whose samples to go on, with its tiles; only --spp may differ")
                               .type_name("JOB");
  command.add_flag("--fresh", options->reuse.fresh, "render everything: do not reuse results of the farm")
      .excludes(continued);
  command.add("--threads", options->render.threads, "ignored: the workers have their own").in_range(1, 1024);
  define_server_option(command, options->server);
  command.example("tessera submit scene.pbrt -o scene.exr --spp 256");
  command.example("tessera submit scene.pbrt --detach --priority 5 --require big-memory");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
