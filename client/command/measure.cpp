// tessera measure SCENE METERS: how much light there is.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/measure/error_progress.h"
#include "command/measure/probe_jobs.h"
#include "command/render_options.h"
#include "command/server_option.h"
#include "command/setting_options.h"
#include "measure/lamp_file_of.h"
#include "measure/measure.h"
#include "measure/report/measured_html.h"
#include "measure/report/measured_table.h"
#include "measure/report/mesh_maps.h"
#include "measure/report/plane_maps.h"
#include "photometry/lamps/lamp_file.h"
#include "wire/algorithm.h"
#include "wire/algorithm_fit.h"
#include "wire/scene_views.h"

namespace tessera::client {
namespace {

using Clock = std::chrono::steady_clock;

struct MeasureOptions {
  RenderOptions scene;
  std::string meters;
  std::string output, html, lamp, maps;
  bool all_cells = false;
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

absl::Status write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (file) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(path, " cannot be written"));
}

absl::Status check_figures_file(const std::string& path) {
  for (const char* const extension : {".csv", ".json", ".txt"})
    if (absl::EndsWithIgnoreCase(path, extension)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("'", path, "': figures are written as .csv, .json or .txt"));
}

/// The file of an intensity meter, the first one.
absl::Status write_lamp(const std::string& path, const v1::MeterList& list, const Measured& measured) {
  for (int i = 0; i < list.meters_size(); ++i) {
    if (!list.meters(i).has_intensity()) continue;
    const auto meter = std::ranges::find(measured.meters, list.meters(i).name(), &MeasuredMeter::name);
    if (meter == measured.meters.end()) continue;
    const auto luminaire = luminaire_of(list.meters(i), *meter);
    if (!luminaire.ok()) return luminaire.status();
    const auto text = absl::EndsWithIgnoreCase(path, ".ldt") ? photometry::write_eulumdat(*luminaire)
                                                             : photometry::write_ies(*luminaire);
    return text.ok() ? write_file(path, *text) : text.status();
  }
  return absl::InvalidArgumentError("--lamp-file is of an intensity meter with a name, and there is none");
}

/// Maps of all planes and surfaces, as pictures and as values; surfaces as meshes, too.
absl::Status write_maps(const std::string& folder, const Measured& measured, bool y_up) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  for (std::size_t m = 0; m < measured.meters.size(); ++m) {
    const MeasuredMeter& meter = measured.meters[m];
    for (std::size_t p = 0; p < meter.planes.size(); ++p) {
      for (const char* const extension : {".png", ".exr"}) {
        const std::string path =
            (std::filesystem::path(folder) / absl::StrCat(m + 1, "-", p + 1, extension)).string();
        if (absl::Status s = write_plane_map(measured, meter, meter.planes[p], {}, path); !s.ok()) return s;
      }
    }
    for (std::size_t p = 0; p < meter.meshes.size(); ++p) {
      for (const char* const extension : {".png", ".exr", ".ply"}) {
        const std::string path =
            (std::filesystem::path(folder) / absl::StrCat(m + 1, "-mesh-", p + 1, extension)).string();
        if (absl::Status s = write_mesh_map(meter, meter.meshes[p], {.maps = {}, .y_up = y_up}, path);
            !s.ok())
          return s;
      }
    }
  }
  return absl::OkStatus();
}

int write_figures(const MeasureOptions& options, const v1::MeterList& list, const Measured& measured) {
  const bool y_up = list.up() == v1::MeterList::Y;
  const std::string text = measured_text(measured, {.all_cells = options.all_cells});
  if (options.output.empty()) std::cout << text;
  absl::Status written;
  if (absl::EndsWithIgnoreCase(options.output, ".csv"))
    written = write_file(options.output, measured_csv(measured));
  if (absl::EndsWithIgnoreCase(options.output, ".json"))
    written = write_file(options.output, measured_json(measured));
  if (absl::EndsWithIgnoreCase(options.output, ".txt")) written = write_file(options.output, text);
  if (!options.html.empty()) {
    MeasuredReportOptions how;
    how.y_up = y_up;
    written.Update(write_file(options.html, measured_html(measured, how)));
  }
  if (!options.lamp.empty()) written.Update(write_lamp(options.lamp, list, measured));
  if (!options.maps.empty()) written.Update(write_maps(options.maps, measured, y_up));
  return written.ok() ? kDone : report(kIncomplete, std::string{written.message()});
}

int run_jobs(const MeasureOptions& options, const MeterFile& file, ImportedScene& imported, FarmClient* farm,
             Interrupt& interrupt) {
  const std::string algorithm = algorithm_of(options, imported.scene);
  if (absl::Status s = check_algorithm(algorithm); !s.ok()) return report(kUsage, std::string{s.message()});
  std::optional<absl::StatusOr<Ball>> ball;
  v1::RenderSettings asked = imported.scene.settings();
  asked.MergeFrom(options.scene.job.settings);
  const bool is_spectral = asked.color() == v1::COLOR_SPECTRAL;
  auto scene = measured_scene(imported, file, is_spectral, [&]() -> absl::StatusOr<Ball> {
    if (!ball) ball = ball_around(imported, options.scene.threads);
    return *ball;
  });
  if (!scene.ok()) return report(kUsage, std::string{scene.status().message()});
  scene->emitted_flux = [&](const v1::Scene& lights) {
    return emitted_flux(imported, lights, options.scene.threads);
  };
  const auto plan = plan_of(file, *scene);
  if (!plan.ok()) return report(kUsage, std::string{plan.status().message()});
  if (!imported.scene.has_render_origin())
    *imported.scene.mutable_render_origin() = wire::camera_place(imported.scene);
  ProbeJobOptions how{
      .job = options.scene.job,
      .name = absl::StrCat("measure ", std::filesystem::path(options.scene.scene).stem().string()),
      .threads = options.scene.threads,
      .farm = farm,
      .stop = interrupt.token()};
  how.job.settings.set_integrator(algorithm);
  if (is_spectral) how.job.settings.set_color(v1::COLOR_SPECTRAL);
  ProbeJobs jobs(imported, std::move(how));
  SamplingOptions sampling = options.sampling;
  sampling.seed = options.scene.job.settings.seed();
  if (is_chosen(options)) sampling.integrators = candidates_for_meters(algorithm, imported.scene);
  const Clock::time_point start = Clock::now();
  if (options.seconds)
    sampling.time_is_up = [&] {
      return std::chrono::duration<double>(Clock::now() - start).count() >= *options.seconds;
    };
  ErrorProgress error_progress(progress_mode(STDERR_FILENO, options.scene.quiet), std::cerr, sampling.error,
                               terminal_columns(STDERR_FILENO));
  sampling.progress = [&](const SamplingProgress& progress) { error_progress.show(progress); };
  const MeasureRenderers renderers{[&](const ProbeJob& job) { return jobs.render(job); },
                                   [&](const PictureJob& job) { return jobs.render(job); },
                                   [&](const ProbeJob& job, const v1::Light& light, std::string sky) {
                                     return jobs.render(job, light, std::move(sky));
                                   }};
  const auto run = measure(*plan, *scene, file, algorithm, sampling, renderers);
  error_progress.finish();
  if (!options.scene.quiet) {
    for (const std::string& warning : jobs.warnings()) std::cerr << "warning: " << warning << '\n';
  }
  if (!run.ok()) {
    if (absl::IsInvalidArgument(run.status())) return report(kBadScene, std::string{run.status().message()});
    return farm != nullptr ? report_farm_error(run.status(), options.server)
                           : report_farm_error(run.status());
  }
  // Tables have them, too.
  if (!options.scene.quiet && !options.output.empty()) {
    for (const MeasuredMeter& meter : run->measured.meters) {
      for (const std::string& warning : meter.warnings)
        std::cerr << "warning: " << meter.name << ": " << warning << '\n';
    }
  }
  const int written = write_figures(options, file.list, run->measured);
  if (written != kDone || !run->stopped) return written;
  if (run->measured.worst_meter.empty() || run->measured.wanted_error == 0)
    return report(kIncomplete, "the time is up before all figures have their samples");
  return report(kIncomplete, absl::StrFormat("the time is up: %s is within %.3g %%, not %.3g %%",
                                             run->measured.worst_meter, 100 * run->measured.worst_error,
                                             100 * run->measured.wanted_error));
}

int run(const MeasureOptions& options, Interrupt& interrupt) {
  if (!options.output.empty()) {
    if (absl::Status s = check_figures_file(options.output); !s.ok())
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
  return run_jobs(options, *file, loaded->imported, farm.get(), interrupt);
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
  command.add("-o,--output", options->output, "the figures: .csv, .json or .txt; else they are printed")
      .type_name("FILE");
  command.add("--html", options->html, "a page with maps, tables and how it was measured").type_name("FILE");
  command.add("--maps", options->maps, "maps in false colours (.png) and as values (.exr, meshes .ply)")
      .type_name("FOLDER");
  command.add("--lamp-file", options->lamp, "the intensity meter as IES LM-63 (.ies) or EULUMDAT (.ldt)")
      .type_name("FILE");
  command.add_flag("--all-cells", options->all_cells,
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
