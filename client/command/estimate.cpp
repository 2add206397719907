// tessera estimate SCENE: what a job will cost.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "base/printable.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/render_options.h"
#include "command/report/progress.h"
#include "local/bench_scene.h"
#include "local/local_farm.h"
#include "pilot/estimate.h"
#include "wire/job_check.h"
#include "wire/limits.h"
#include "wire/scene_views.h"

namespace tessera::client {
namespace {

// With noise, parts are rendered with all samples that the pilot gave them, and are smaller than tiles; else
// a sample costs the same wherever it stands among a pixel's, and some of them are enough.
constexpr std::uint32_t kAdaptivePart = 4 * wire::kNoiseBlock;  // pixels, a side
constexpr std::uint32_t kSurveySamples = 16;
constexpr double kOfNormal = 1.96;  // standard errors: 95 % of a normal distribution

struct EstimateOptions {
  RenderOptions render;
  double error = 0.05;
  double budget = 60;
  std::optional<double> price;
  bool json = false;
};

/// The job's parts: tiles, or its passes.
class Parts {
 public:
  /// `spec`: of the scene, whose tiles are the parts; the job's own are `tile_size` wide.
  Parts(const BenchScene& scene, const BenchPhases& phases, const v1::JobSpec& spec, std::uint32_t tile_size,
        std::stop_token stop)
      : scene_(scene),
        phases_(phases),
        stop_(std::move(stop)),
        tile_size_(tile_size),
        part_size_(spec.cut().tile_size()),
        spp_(spec.samples().spp()),
        passes_(wire::works_in_passes(spec)),
        adaptive_(spec.samples().noise() != 0) {}

  bool whole() const { return passes_ || adaptive_ || spp_ <= kSurveySamples; }
  std::size_t count() const { return passes_ ? spp_ : scene_.tile_count(); }

  absl::StatusOr<PartCost> measure(std::size_t part) const {
    const auto pass = static_cast<std::uint32_t>(part);
    const std::uint32_t taken = adaptive_ ? spp_ : std::min(spp_, kSurveySamples);
    const absl::StatusOr<BenchRender> rendered = passes_
                                                     ? scene_.render_tile(0, pass, pass + 1, phases_, stop_)
                                                     : scene_.render_tile(part, 0, taken, phases_, stop_);
    if (!rendered.ok()) return rendered.status();
    const wire::TileResult& tile = rendered->tiles.front();
    const double scale = passes_ ? 1 : static_cast<double>(spp_) / taken;
    PartCost cost{.cpu_seconds = scale * rendered->cost.cpu_seconds, .spent = rendered->cost.cpu_seconds};
    for (const std::uint32_t count : tile.counts) {
      cost.samples += scale * count;
      cost.capped += adaptive_ && count >= spp_ ? 1 : 0;
    }
    if (part_size_ != tile_size_)
      cost.cpu_seconds *= as_in_tiles(static_cast<double>(rendered->cost.counts.camera_rays) / cost.samples);
    return cost;
  }

 private:
  /// A tile whose samples are scattered renders a border around it, too, which is more of a smaller one.
  /// `with_border`: samples rendered over the part's own.
  double as_in_tiles(double with_border) const {
    const double border = (std::sqrt(std::max(with_border, 1.0)) - 1) * part_size_ / 2;  // pixels
    const double side = 1 + 2 * border / tile_size_;
    return side * side / std::max(with_border, 1.0);
  }

  const BenchScene& scene_;
  const BenchPhases& phases_;
  const std::stop_token stop_;
  const std::uint32_t tile_size_, part_size_;
  const std::uint32_t spp_;
  const bool passes_, adaptive_;
};

/// All that is known of the job's cost.
struct Outlook {
  JobEstimate parts;
  std::size_t part_count = 0;
  double phases = 0, build = 0;  // CPU seconds
  double pixels = 0;
  double views = 1;  // each of which costs as much as view 0

  double seconds() const { return views * parts.cpu_seconds + phases; }
  double least() const { return std::max(0.0, seconds() - kOfNormal * views * parts.cpu_error); }
  double most() const { return seconds() + kOfNormal * views * parts.cpu_error; }
};

std::string hours(double seconds) { return absl::StrFormat("%.3g", seconds / 3600); }

std::string outlook_text(const Outlook& outlook, const v1::JobSpec& spec, const EstimateOptions& options) {
  const int threads = options.render.threads;
  std::string text = absl::StrFormat("cost        %s core-hours (95 %%: %s to %s); here, on %d threads, %s\n",
                                     hours(outlook.seconds()), hours(outlook.least()), hours(outlook.most()),
                                     threads, format_duration(outlook.seconds() / threads));
  if (options.price) {
    const double price = *options.price / 3600;
    absl::StrAppendFormat(&text, "price       %.4g (95 %%: %.4g to %.4g) at %g a core-hour\n",
                          price * outlook.seconds(), price * outlook.least(), price * outlook.most(),
                          *options.price);
  }
  absl::StrAppendFormat(&text, "samples     %.4g a pixel", outlook.parts.samples / outlook.pixels);
  if (spec.samples().noise() != 0) {
    absl::StrAppendFormat(&text, ", to a noise of %g; %.3g %% of the pixels take all %d that they may",
                          spec.samples().noise(), 100 * outlook.parts.capped / outlook.pixels,
                          spec.samples().spp());
  }
  absl::StrAppendFormat(&text, "\nloading     %.3g CPU s on each machine\n", outlook.build);
  if (outlook.phases > 0)
    absl::StrAppendFormat(&text, "phases      %.3g CPU s, part of the cost\n", outlook.phases);
  if (outlook.views > 1)
    absl::StrAppendFormat(&text, "views       %g, all taken to cost as view 0\n", outlook.views);
  absl::StrAppendFormat(&text, "survey      %d of %d parts, %.3g CPU s\n", outlook.parts.parts,
                        outlook.part_count, outlook.parts.survey_seconds);
  return text;
}

std::string outlook_json(const Outlook& outlook, const v1::JobSpec& spec, const EstimateOptions& options) {
  nlohmann::ordered_json json = {{"cpu_seconds", outlook.seconds()},
                                 {"cpu_seconds_error", outlook.views * outlook.parts.cpu_error},
                                 {"core_hours", outlook.seconds() / 3600},
                                 {"core_hours_95", {outlook.least() / 3600, outlook.most() / 3600}},
                                 {"samples_a_pixel", outlook.parts.samples / outlook.pixels},
                                 {"samples_a_pixel_error", outlook.parts.samples_error / outlook.pixels},
                                 {"capped_share", outlook.parts.capped / outlook.pixels},
                                 {"spp", spec.samples().spp()},
                                 {"noise", spec.samples().noise()},
                                 {"integrator", spec.content().algorithms().integrator()},
                                 {"build_cpu_seconds", outlook.build},
                                 {"phases_cpu_seconds", outlook.phases},
                                 {"views", outlook.views},
                                 {"parts", outlook.parts.parts},
                                 {"parts_total", outlook.part_count},
                                 {"survey_cpu_seconds", outlook.parts.survey_seconds}};
  if (options.price) {
    const double price = *options.price / 3600;
    json["price"] = price * outlook.seconds();
    json["price_95"] = {price * outlook.least(), price * outlook.most()};
  }
  return json.dump(2) + "\n";
}

absl::StatusOr<Outlook> look_ahead(const EstimateOptions& options, LoadedJob& loaded, std::stop_token stop) {
  v1::JobSpec& spec = loaded.job->spec;
  const std::uint32_t tile_size = spec.cut().tile_size();
  if (spec.samples().noise() != 0) spec.mutable_cut()->set_tile_size(std::min(tile_size, kAdaptivePart));
  const absl::StatusOr<std::unique_ptr<BenchScene>> scene = build_scene(loaded, options.render);
  if (!scene.ok()) return scene.status();
  const absl::StatusOr<BenchPhases> phases = (*scene)->make_phases(0, stop);
  if (!phases.ok()) return phases.status();
  const Parts parts(**scene, *phases, spec, tile_size, stop);
  const SurveyPlan plan{.parts = parts.count(),
                        .whole = parts.whole(),
                        .wanted_error = options.error,
                        .cpu_seconds = options.budget,
                        .threads = options.render.threads,
                        .seed = spec.view().seed()};
  absl::StatusOr<JobEstimate> estimate = survey(
      plan, [&](std::size_t part) { return parts.measure(part); }, stop);
  if (!estimate.ok()) return estimate.status();
  const v1::PixelRect& crop = spec.cut().crop();
  return Outlook{.parts = *estimate,
                 .part_count = parts.count(),
                 .phases = spec.cut().phases_size() > 0 ? phases->cost.cpu_seconds : 0,
                 .build = (*scene)->build_cpu_seconds(),
                 .pixels = double(crop.x1() - crop.x0()) * double(crop.y1() - crop.y0()),
                 .views = double(wire::views_of(spec))};
}

int run(const EstimateOptions& options, Interrupt& interrupt) {
  int exit_code = kDone;
  const ChoiceOptions choice{.threads = options.render.threads, .stop = [&] { return interrupt.token(); }};
  const std::unique_ptr<LoadedJob> loaded = load_job(options.render, exit_code, nullptr, &choice);
  if (loaded == nullptr) return exit_code;
  const absl::StatusOr<Outlook> outlook = look_ahead(options, *loaded, interrupt.token());
  if (absl::IsCancelled(outlook.status())) return kInterrupted;
  if (!outlook.ok()) {
    return report(absl::IsInvalidArgument(outlook.status()) ? kBadScene : kJobFailed,
                  std::string{outlook.status().message()});
  }
  const v1::JobSpec& spec = loaded->job->spec;
  std::cout << (options.json ? outlook_json(*outlook, spec, options) : outlook_text(*outlook, spec, options));
  return kDone;
}

}  // namespace

void add_estimate_command(CommandLine& line) {
  auto options = std::make_shared<EstimateOptions>();
  Command command = line.add_command("estimate", "Say what a job will cost, before it is rendered");
  command.add("SCENE", options->render.scene, "the scene, as of render").required();
  command.add("--price", options->price, "of a core-hour, in any currency: the cost in it").in_range(0, 1e9);
  command.add("--error", options->error, "standard error of the cost, as a share of it, to come to")
      .in_range(0.001, 1)
      .with_default();
  command.add("--budget", options->budget, "CPU seconds after which it is told as it is")
      .in_range(0, 1e6)
      .with_default();
  command.add_flag("--json", options->json, "as JSON");
  define_job_options(command, options->render);
  command.option("--isa").one_of(local_isas());
  options->render.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  command.group("Computation");
  command.add("--threads", options->render.threads, "parts rendered at once")
      .in_range(1, 1024)
      .with_default("one a hardware thread");
  command.group("Output");
  command.add_flag("--quiet", options->render.quiet, "no progress, no warnings");
  command.example("tessera estimate scene.pbrt --noise 0.02 --spp 4096 --price 0.04");
  command.does([options](Interrupt& interrupt) { return run(*options, interrupt); });
}

}  // namespace tessera::client
