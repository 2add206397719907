// tessera render SCENE -o OUT: everything in this process.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "base/cpu_time.h"
#include "command/command.h"
#include "command/denoise_result.h"
#include "command/exit_code.h"
#include "command/frames/frames.h"
#include "command/interrupt.h"
#include "command/jobs/follow.h"
#include "command/jobs/go_on.h"
#include "command/render_options.h"
#include "command/report/output.h"
#include "command/report/stats_file.h"
#include "command/report/time_spent.h"
#include "display/tev.h"
#include "farm/job_calls.h"
#include "local/checkpoint.h"
#include "local/local_farm.h"

namespace tessera::client {
namespace {

using Clock = std::chrono::steady_clock;

/// The job from submission, or from where it was, to its end.
absl::StatusOr<FollowedJob> run_job(LocalFarm& farm, const v1::JobSpec& spec, FollowOptions how,
                                    std::stop_token stop) {
  JobCalls& client = farm.calls();
  const absl::StatusOr<std::string> job_id = submit_or_go_on(client, spec, stop);
  if (!job_id.ok()) return job_id.status();
  how.building = [&farm] { return farm.building(); };
  return follow_job(client, *job_id, spec, how, stop, {.wanted = true});
}

/// Where an image is kept that could not be written where it was to be: the state folder, or that of
/// temporary files.
std::vector<std::filesystem::path> other_folders() {
  std::vector<std::filesystem::path> folders;
  const char* const state = std::getenv("XDG_STATE_HOME");
  const char* const home = std::getenv("HOME");
  if (state != nullptr && *state != '\0') {
    folders.push_back(std::filesystem::path(state) / "tessera");
  } else if (home != nullptr && *home != '\0') {
    folders.push_back(std::filesystem::path(home) / ".local" / "state" / "tessera");
  }
  std::error_code error;
  folders.push_back(std::filesystem::temp_directory_path(error));
  return folders;
}

/// The image could not be written, and no checkpoint has its results: it is kept elsewhere, if that can be.
void keep_image(const FollowedImage& of_view, const std::string& output) {
  for (const std::filesystem::path& folder : other_folders()) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const std::string name = std::filesystem::path(output).stem().string();
    const std::string path = (folder / absl::StrCat(name, "-", getpid(), ".exr")).string();
    const Image& image = of_view.image;
    if (!(of_view.rows ? write_image(image, *of_view.rows, path) : write_image(image, path)).ok()) continue;
    report(kIncomplete, absl::StrCat("the image is in ", path, " instead"));
    return;
  }
}

/// With `--display tev`, results go there too. Unavailable where it does not listen.
absl::Status show_in_tev(const RenderOptions& options, const v1::JobSpec& spec, FollowOptions& how) {
  if (options.display != "tev") return absl::OkStatus();
  const std::string name = std::filesystem::path(options.output).filename().string();
  absl::StatusOr<TevPicture> opened = TevPicture::open(kTevAddress, name, crop_of(spec));
  if (!opened.ok()) return opened.status();
  const auto picture = std::make_shared<std::optional<TevPicture>>(*std::move(opened));
  how.show = [picture](const wire::TileResult& result) {
    if (!*picture || !absl::IsUnavailable((*picture)->add(result))) return;
    picture->reset();
    std::cerr << "warning: tev is gone; rendering goes on\n";
  };
  how.show_anew = [picture] {
    if (*picture) (*picture)->clear();
  };
  return absl::OkStatus();
}

/// `is_whole`: the job is done, and its image written.
int render(const RenderOptions& options, Interrupt& interrupt, bool& is_whole) {
  const double start_cpu_seconds = base::in_seconds(base::process_cpu_time());
  int exit_code = kDone;
  ChoiceOptions choice{
      .threads = options.threads, .keeps_scene = true, .stop = [&] { return interrupt.token(); }};
  if (!options.checkpoint.empty()) choice.begun = begun_job(options.checkpoint);
  std::optional<Interrupt::AtOnce> at_once{std::in_place};
  const std::unique_ptr<LoadedJob> loaded = load_job(options, exit_code, nullptr, &choice);
  at_once.reset();
  if (loaded == nullptr) return exit_code;
  v1::JobSpec& spec = loaded->job->spec;
  if (!options.checkpoint.empty()) {
    if (const absl::Status status = keep_begun_job(options.checkpoint, spec); !status.ok())
      return report(kUsage, std::string{status.message()});
  }
  if (const absl::Status fits = check_denoise_memory(options, spec); !fits.ok())
    return report(kUsage, std::string{fits.message()});
  set_local_isa(spec);

  // An interrupt ends the job, and so does a disk on which nothing can be kept.
  std::stop_source ended;
  const std::stop_callback interrupted{interrupt.token(), [&ended] { ended.request_stop(); }};
  absl::Status failure;
  const auto failed = [&](const absl::Status& status) {
    failure = status;
    ended.request_stop();
  };
  const absl::StatusOr<std::unique_ptr<LocalFarm>> farm =
      LocalFarm::start({.threads = options.threads,
                        .isa = spec.farm().isa(),
                        .blobs = loaded->job->blobs,
                        .geometry_read = [&loaded] { loaded->free_meshes(); },
                        .checkpoint = options.checkpoint,
                        .web = options.display == "web",
                        .built = std::move(loaded->built),
                        .failed = failed});
  if (!farm.ok()) return report(kJobFailed, std::string{farm.status().message()});
  if (const int port = (*farm)->web_port(); port != 0)
    std::cerr << "tessera: the picture grows at http://127.0.0.1:" << port << "/" << std::endl;

  const Clock::time_point start = Clock::now();
  FollowOptions how{.quiet = options.quiet,
                    .frame_memory = frame_memory(options.exr, denoise_memory(options, spec)),
                    .mattes = loaded->mattes(options)};
  if (absl::Status s = show_in_tev(options, spec, how); !s.ok())
    return report(kUsage, std::string{s.message()});
  absl::StatusOr<FollowedJob> followed = run_job(**farm, spec, how, ended.get_token());
  if (!failure.ok() && followed.ok()) followed->broken_off = failure;
  if (!followed.ok()) return report_farm_error(followed.status());
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  loaded->describe(options, *followed);
  denoise_result(options, spec, *followed);
  exit_code = deliver(*followed, spec, options.output, options.exr, options.quiet);
  if (!failure.ok()) exit_code = kIncomplete;
  const auto views = static_cast<std::uint32_t>(followed->images.size());
  for (std::uint32_t view = 0; view < views && options.checkpoint.empty(); ++view) {
    if (!followed->images[view].written)
      keep_image(followed->images[view], output_of_view(options.output, view, views));
  }
  is_whole = views > 0 && std::ranges::all_of(followed->images, &FollowedImage::written) &&
             followed->status.state() == v1::DONE;
  const TimeSpent spent = time_spent(
      followed->status.stats(), ProcessTime{.start_seconds = start_cpu_seconds,
                                            .import_seconds = loaded->import_cpu_seconds,
                                            .pilot_seconds = spec.farm().auto_choice().pilot_seconds(),
                                            .total_seconds = base::in_seconds(base::process_cpu_time())});
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

int run_one(const RenderOptions& options, Interrupt& interrupt) {
  absl::Status status = check_output(options.output, options.exr);
  status.Update(check_stats(options));
  if (status.ok() && !options.checkpoint.empty()) status = open_checkpoint(options.checkpoint);
  if (!status.ok()) return report(kUsage, std::string{status.message()});
  bool is_whole = false;
  const int exit_code = render(options, interrupt, is_whole);
  if (options.checkpoint.empty()) return exit_code;
  if (!is_whole) {
    std::cerr << "what was rendered is in " << options.checkpoint << ": the same command goes on with it\n";
  } else if (status = delete_checkpoint(options.checkpoint); !status.ok()) {
    std::cerr << "warning: " << status.message() << '\n';
  }
  return exit_code;
}

int run(const RenderOptions& options, Interrupt& interrupt) {
  if (options.frames.frames.empty()) return run_one(options, interrupt);
  if (const absl::Status status = check_frames(options); !status.ok())
    return report(kUsage, std::string{status.message()});
  if (!options.checkpoint.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options.checkpoint, error);
  }
  const auto start = [&](const RenderOptions& frame, int&) -> FrameJob {
    return [frame, &interrupt] { return run_one(frame, interrupt); };
  };
  return run_frames(options, 1, start, interrupt.token());
}

}  // namespace

void add_render_command(CommandLine& line) {
  auto options = std::make_shared<RenderOptions>();
  Command command = line.add_command("render", "Render a scene in this process");
  define_render_options(command, *options);
  command.option("--output").required();
  define_frame_options(command, *options);
  options->threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  command.group("Computation");
  command.add("--threads", options->threads, "tiles rendered at once")
      .in_range(1, 1024)
      .with_default("one a hardware thread");
  command.option("--isa").one_of(local_isas());
  command.group("Output");
  command.add("--display", options->display, "show the picture as it grows").one_of({"web", "tev"});
  command.add("--checkpoint", options->checkpoint, "keep results here; the same command goes on")
      .type_name("FOLDER");
  command.example("tessera render scenes/cornell-box/scene.pbrt -o box.exr --spp 64");
  command.example("tessera render turn.####.pbrt -o turn.####.exr --frames 1-60");
  command.example("tessera render kitchen.xml -o kitchen.png --noise 0.05 --spp 1024");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
