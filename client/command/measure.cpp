// tessera measure SCENE METERS: how much light there is.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/measure/error_progress.h"
#include "command/measure/figure_files.h"
#include "command/measure/probe_jobs.h"
#include "command/render_options.h"
#include "command/server_option.h"
#include "command/setting_options.h"
#include "measure/measure.h"
#include "measure/report/figure_text.h"
#include "measure/sky_series.h"
#include "wire/algorithm.h"
#include "wire/algorithm_fit.h"

namespace tessera::client {
namespace {

using Clock = std::chrono::steady_clock;

struct MeasureOptions {
  RenderOptions scene;
  std::string meters;
  FigureFiles files;
  SamplingOptions sampling;
  std::optional<double> seconds;
  bool on_farm = false;
  ServerOption server;
};

/// Figures are means of estimates that are right in the mean.
absl::Status check_algorithm(const std::string& name) {
  const wire::AlgorithmTraits* const algorithm = wire::find_algorithm(name);
  if (algorithm == nullptr) return wire::check_algorithm_name(name);
  if (algorithm->bias != wire::Bias::kUnbiased)
    return absl::InvalidArgumentError(absl::StrCat(
        "integrator '", name, "' is ", wire::word_of(algorithm->bias),
        ": the error that is told beside a figure would not hold its bias; path, volpath, direct, "
        "light and bdpt are unbiased"));
  if (!algorithm->reads_probes)
    return absl::InvalidArgumentError(absl::StrCat(
        "integrator '", name, "' does not read meters; path, volpath, direct, light and bdpt do"));
  return absl::OkStatus();
}

bool is_chosen(const MeasureOptions& options) {
  const std::string& asked = options.scene.job.settings.integrator();
  return asked.empty() || asked == "auto";
}

/// The integrator that is named, or one that finds all light which the scene's matter lets through.
std::string algorithm_of(const MeasureOptions& options, const v1::Scene& scene) {
  if (!is_chosen(options)) return options.scene.job.settings.integrator();
  return scene.media_size() > 0 ? "volpath" : "path";
}

/// Whether light tracing finds all light of the scene by paths that are not rare: matter is diffuse, light
/// neither comes from infinity, where its paths would begin all around, nor meets media.
bool suits_light_tracing(const v1::Scene& scene) {
  const auto is_near = [](const v1::Light& light) {
    return !light.has_infinite() && !light.has_distant() && !light.has_sky();
  };
  return scene.media_size() == 0 && std::ranges::all_of(scene.lights(), is_near) &&
         std::ranges::all_of(scene.materials(),
                             [](const v1::Material& material) { return material.has_diffuse(); });
}

/// Integrators that meters may choose among, the usual one first.
std::vector<std::string> candidates_for_meters(const std::string& usual, const v1::Scene& scene) {
  std::vector<std::string> names = {usual, "bdpt"};
  if (suits_light_tracing(scene)) names.emplace_back("light");
  std::erase_if(names, [&](const std::string& name) {
    v1::Algorithms algorithms;
    algorithms.set_integrator(name);
    return name != usual && !wire::obstacle_to(algorithms, scene).empty();
  });
  return names;
}

/// Measures one scene, which may have one sky after another.
class SceneMeter {
 public:
  SceneMeter(const MeasureOptions& options, const MeterFile& file, ImportedScene& imported, FarmClient* farm,
             Interrupt& interrupt)
      : options_(options),
        file_(file),
        imported_(imported),
        algorithm_(algorithm_of(options, imported.scene)),
        farm_(farm),
        interrupt_(interrupt) {}

  /// Measures the scene as it is, or under each sky of the file's series, and writes that.
  int run();

 private:
  /// Settles what the scene is and what is sampled; kDone, or an exit code after telling why not.
  int prepare();
  /// Figures of the scene as it is, in the `part`-th of `parts` shares of the time.
  absl::StatusOr<MeasureRun> measure_once(std::size_t part, std::size_t parts);
  int run_alone();
  int run_series();
  int report_failure(const absl::Status& status) const;
  int end_of(bool stopped, const Measured& measured) const;
  void tell_warnings(const std::string& step, const Measured& measured) const;

  const MeasureOptions& options_;
  const MeterFile& file_;
  ImportedScene& imported_;
  const std::string algorithm_;
  FarmClient* const farm_;
  Interrupt& interrupt_;
  std::optional<absl::StatusOr<Ball>> ball_;
  std::optional<MeasuredScene> scene_;
  std::optional<MeasurePlan> plan_;
  std::unique_ptr<ProbeJobs> jobs_;
  const Clock::time_point start_ = Clock::now();
};

int SceneMeter::prepare() {
  if (absl::Status s = check_algorithm(algorithm_); !s.ok()) return report(kUsage, std::string{s.message()});
  v1::RenderSettings asked = imported_.scene.settings();
  asked.MergeFrom(options_.scene.job.settings);
  const bool is_spectral = asked.color() == v1::COLOR_SPECTRAL;
  auto scene = measured_scene(imported_, file_, is_spectral, [this]() -> absl::StatusOr<Ball> {
    if (!ball_) ball_ = ball_around(imported_, options_.scene.threads);
    return *ball_;
  });
  if (!scene.ok()) return report(kUsage, std::string{scene.status().message()});
  scene_.emplace(*std::move(scene));
  scene_->emitted_flux = [this](const v1::Scene& lights) {
    return emitted_flux(imported_, lights, options_.scene.threads);
  };
  auto plan = plan_of(file_, *scene_);
  if (!plan.ok()) return report(kUsage, std::string{plan.status().message()});
  plan_.emplace(*std::move(plan));
  ProbeJobOptions how{
      .job = options_.scene.job,
      .name = absl::StrCat("measure ", std::filesystem::path(options_.scene.scene).stem().string()),
      .threads = options_.scene.threads,
      .farm = farm_,
      .stop = interrupt_.token()};
  how.job.settings.set_integrator(algorithm_);
  if (is_spectral) how.job.settings.set_color(v1::COLOR_SPECTRAL);
  jobs_ = std::make_unique<ProbeJobs>(imported_, std::move(how));
  return kDone;
}

absl::StatusOr<MeasureRun> SceneMeter::measure_once(std::size_t part, std::size_t parts) {
  SamplingOptions sampling = options_.sampling;
  sampling.seed = options_.scene.job.settings.seed();
  if (is_chosen(options_)) sampling.integrators = candidates_for_meters(algorithm_, imported_.scene);
  if (options_.seconds)
    sampling.time_is_up = [&] {
      const double share = static_cast<double>(part + 1) / static_cast<double>(parts);
      return std::chrono::duration<double>(Clock::now() - start_).count() >= share * *options_.seconds;
    };
  ErrorProgress error_progress(progress_mode(STDERR_FILENO, options_.scene.quiet), std::cerr, sampling.error,
                               terminal_columns(STDERR_FILENO));
  sampling.progress = [&](const SamplingProgress& progress) { error_progress.show(progress); };
  const MeasureRenderers renderers{[&](const ProbeJob& job) { return jobs_->render(job); },
                                   [&](const PictureJob& job) { return jobs_->render(job); },
                                   [&](const ProbeJob& job, const v1::Light& light, std::string sky) {
                                     return jobs_->render(job, light, std::move(sky));
                                   }};
  auto run = measure(*plan_, *scene_, file_, algorithm_, sampling, renderers);
  error_progress.finish();
  return run;
}

int SceneMeter::report_failure(const absl::Status& status) const {
  if (absl::IsInvalidArgument(status)) return report(kBadScene, std::string{status.message()});
  return farm_ != nullptr ? report_farm_error(status, options_.server) : report_farm_error(status);
}

/// Tables have them, too.
void SceneMeter::tell_warnings(const std::string& step, const Measured& measured) const {
  if (options_.scene.quiet || options_.files.figures.empty()) return;
  for (const MeasuredMeter& meter : measured.meters) {
    for (const std::string& warning : meter.warnings)
      std::cerr << "warning: " << step << meter.name << ": " << warning << '\n';
  }
}

int SceneMeter::end_of(bool stopped, const Measured& measured) const {
  if (!stopped) return kDone;
  if (measured.worst_meter.empty() || measured.wanted_error == 0)
    return report(kIncomplete, "the time is up before all figures have their samples");
  return report(kIncomplete,
                absl::StrFormat("the time is up: %s is within %.3g %%, not %.3g %%", measured.worst_meter,
                                100 * measured.worst_error, 100 * measured.wanted_error));
}

int SceneMeter::run_alone() {
  const auto run = measure_once(0, 1);
  if (!options_.scene.quiet) {
    for (const std::string& warning : jobs_->warnings()) std::cerr << "warning: " << warning << '\n';
  }
  if (!run.ok()) return report_failure(run.status());
  tell_warnings("", run->measured);
  if (const absl::Status s = write_figures(options_.files, file_.list, run->measured); !s.ok())
    return report(kIncomplete, std::string{s.message()});
  return end_of(run->stopped, run->measured);
}

int SceneMeter::run_series() {
  const auto skies = sky_steps(file_, imported_);
  if (!skies.ok()) return report(kUsage, std::string{skies.status().message()});
  if (const int prepared = prepare(); prepared != kDone) return prepared;
  MeasuredSeries series{.name = skies->name, .steps = {}};
  MeasureRun worst;
  for (std::size_t i = 0; i < skies->steps.size(); ++i) {
    const SkyStep& step = skies->steps[i];
    if (!options_.scene.quiet)
      std::cerr << series.name << ' ' << step.value << ": " << step.word << " (" << i + 1 << " of "
                << skies->steps.size() << ")\n";
    *imported_.scene.mutable_lights(skies->light)->mutable_sky() = step.sky;
    jobs_->forget_scene();
    scene_->is_night = step.word == kNightWord;
    auto run = measure_once(i, skies->steps.size());
    if (!run.ok()) return report_failure(run.status());
    MeasuredStep& made = series.steps.emplace_back();
    made = {step.value, step.word, step.sun_altitude_degrees, std::move(run->measured)};
    tell_warnings(absl::StrCat(series.name, " ", step_text(made), ": "), made.measured);
    if (i == 0 || made.measured.worst_error > worst.measured.worst_error) worst.measured = made.measured;
    worst.stopped = worst.stopped || run->stopped;
  }
  if (!options_.scene.quiet) {
    for (const std::string& warning : jobs_->warnings()) std::cerr << "warning: " << warning << '\n';
  }
  if (const absl::Status s = write_figures(options_.files, file_.list, series); !s.ok())
    return report(kIncomplete, std::string{s.message()});
  return end_of(worst.stopped, worst.measured);
}

int SceneMeter::run() {
  if (file_.list.has_series()) return run_series();
  const int prepared = prepare();
  return prepared != kDone ? prepared : run_alone();
}

int run(const MeasureOptions& options, Interrupt& interrupt) {
  if (!options.files.figures.empty()) {
    if (absl::Status s = check_figures_file(options.files.figures); !s.ok())
      return report(kUsage, std::string{s.message()});
  }
  const auto file = read_meter_file(options.meters);
  if (!file.ok()) return report(kUsage, std::string{file.status().message()});
  std::unique_ptr<FarmClient> farm;
  if (options.on_farm) {
    auto connected = connect(options.server, options.scene.quiet);
    if (!connected.ok()) return report_farm_error(connected.status(), options.server);
    farm = *std::move(connected);
  }
  RenderOptions scene = options.scene;
  // The scene is loaded for whatever integrator its author had in mind: meters have their own.
  scene.job.settings.set_integrator("volpath");
  int exit_code = kDone;
  const std::unique_ptr<LoadedJob> loaded = load_job(scene, exit_code);
  if (loaded == nullptr) return exit_code;
  return SceneMeter(options, *file, loaded->imported, farm.get(), interrupt).run();
}

}  // namespace

void add_measure_command(CommandLine& line) {
  auto options = std::make_shared<MeasureOptions>();
  options->scene.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  Command command = line.add_command(
      "measure", "Measure light: irradiance, radiance, intensity and flux, with units and errors");
  command.add("SCENE", options->scene.scene, absl::StrCat("the scene: ", kSceneFiles).c_str()).required();
  command.add("METERS", options->meters, "what is measured (.textproto, docs/measuring.md)").required();
  command.group("Figures");
  command
      .add("-o,--output", options->files.figures, "the figures: .csv, .json or .txt; else they are printed")
      .type_name("FILE");
  command.add("--html", options->files.html, "a page with maps, tables and how it was measured")
      .type_name("FILE");
  command.add("--maps", options->files.maps, "maps in false colours (.png) and as values (.exr, meshes .ply)")
      .type_name("FOLDER");
  command
      .add("--lamp-file", options->files.lamp, "the intensity meter as IES LM-63 (.ies) or EULUMDAT (.ldt)")
      .type_name("FILE");
  command.add_flag("--all-cells", options->files.all_cells,
                   "every cell and triangle in tables, not their means alone");
  command
      .add("--error", options->sampling.error,
           "goes on until 95 % intervals are within this part of their figures: 0.01")
      .in_range(0, 1)
      .type_name("PART");
  command.add("--samples", options->sampling.samples, "paths of each figure, where no error is asked for")
      .in_range(1, std::uint64_t{1} << 40)
      .with_default();
  command.add("--time", options->seconds, "ends after so many seconds with what there is (exit code 6)")
      .in_range(0, 1e9)
      .type_name("SECONDS");
  define_settings(command, options->scene.job.settings,
                  [](const std::string& name) { return name != "spp" && name != "noise"; });
  command.group("Computation");
  command.add("--threads", options->scene.threads, "threads of this process")
      .in_range(1, 1024)
      .with_default("one a hardware thread");
  command.add("-D", options->scene.defines, "a parameter of the scene; may be repeated")
      .type_name("NAME=VALUE");
  command.add_flag("--farm", options->on_farm, "on the farm of --server, not in this process");
  define_server_option(command, options->server);
  command.add_flag("--quiet", options->scene.quiet, "no progress, no warnings");
  command.example("tessera measure hall.pbrt meters.textproto --error 0.01 --html hall.html");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
