// tessera bench SCENE...: run time against error.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "bench/against.h"
#include "bench/analysis.h"
#include "bench/machine.h"
#include "bench/report.h"
#include "command/bench_sides.h"
#include "command/bench_variants.h"
#include "command/command.h"
#include "command/denoise_result.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/render_options.h"
#include "command/report/output.h"
#include "image/atomic_file.h"
#include "local/local_farm.h"
#include "wire/algorithm.h"
#include "wire/algorithm_fit.h"
#include "wire/limits.h"

namespace tessera::client {
namespace {

struct BenchOptions {
  RenderOptions render;
  std::vector<std::string> scenes;
  std::vector<std::string> references;
  std::uint32_t reference_spp = 0;  // 0: none is made
  std::string compare;              // OPTION=A,B
  std::string json, plot, bias_plot, against;
  SideOptions sides;
  BenchPlan plan{.spp = {4, 16, 64, 256}, .seeds = 4, .threads = 1};
};

/// A reference should have this many times the samples of the images that are held against it.
constexpr std::uint32_t kReferenceFactor = 16;

/// An error that has been printed.
struct Failed {
  int exit_code;
};

int report_measuring(const absl::Status& status) {
  const std::string message{status.message()};
  if (absl::IsCancelled(status)) return report(kInterrupted, message);
  return report(absl::IsInvalidArgument(status) || absl::IsNotFound(status) ? kUsage : kJobFailed, message);
}

/// A scene of so many primitives is not searched without any structure, unless that is named.
constexpr double kMostForBrute = 2e4;

std::string too_many_for_brute(const v1::JobSpec& spec, const BenchScene& scene) {
  const std::map<std::string, double> figures = scene.structure();
  const auto primitives = figures.find("primitives");
  if (spec.content().algorithms().accelerator() != v1::ACCELERATOR_BRUTE || primitives == figures.end() ||
      primitives->second <= kMostForBrute)
    return "";
  return absl::StrFormat(
      "every ray would be tested against %.0f primitives; a comparison that names it has it",
      primitives->second);
}

/// A variant and what it refers to.
struct LoadedVariant {
  std::unique_ptr<LoadedJob> job;
  BenchVariant variant;
};

/// With `refusal`, it says why the variant cannot render the scene, and nothing is printed of that.
std::optional<Failed> load_variant(const RenderOptions& options, const std::string& name,
                                   absl::Status* refusal, LoadedVariant& loaded) {
  const Interrupt::AtOnce at_once;
  int exit_code = kDone;
  loaded.job = load_job(options, exit_code, refusal);
  if (loaded.job == nullptr) return Failed{exit_code};
  const v1::JobSpec& spec = loaded.job->job->spec;
  if (refusal != nullptr) {
    const std::string obstacle = wire::obstacle_to(spec.content().algorithms(), loaded.job->imported.scene);
    if (!obstacle.empty()) *refusal = absl::InvalidArgumentError(obstacle);
    if (!refusal->ok()) return Failed{kBadScene};
  }
  absl::StatusOr<std::unique_ptr<BenchScene>> scene = build_scene(*loaded.job, options);
  if (!scene.ok() && refusal != nullptr && absl::IsInvalidArgument(scene.status())) {
    *refusal = scene.status();
    return Failed{kBadScene};
  }
  if (!scene.ok()) {
    return Failed{report(absl::IsInvalidArgument(scene.status()) ? kBadScene : kJobFailed,
                         std::string{scene.status().message()})};
  }
  if (refusal != nullptr) {
    if (const std::string many = too_many_for_brute(spec, **scene); !many.empty()) {
      *refusal = absl::InvalidArgumentError(many);
      return Failed{kBadScene};
    }
  }
  loaded.variant = {name, spec, *std::move(scene), loaded.job->import_cpu_seconds};
  if (options.job.denoise) loaded.variant.denoise = denoise_options(*options.job.denoise, options.threads);
  return std::nullopt;
}

/// All variants of a scene; where all there are were asked for, those that can render it, and why the others
/// cannot.
std::optional<Failed> load_variants(const BenchOptions& options, const std::string& scene,
                                    const std::vector<VariantOption>& variants,
                                    std::vector<LoadedVariant>& loaded, std::vector<BenchRefusal>& refusals) {
  for (const VariantOption& variant : variants) {
    absl::StatusOr<RenderOptions> render = with_option(options.render, variant);
    if (!render.ok()) return Failed{report(kUsage, std::string{render.status().message()})};
    render->scene = scene;
    render->job.several_integrators = variant.option == "integrator";
    render->threads = options.plan.threads;
    render->quiet = options.render.quiet || !loaded.empty();  // a scene warns once
    absl::Status refusal;
    const std::optional<Failed> failed = load_variant(
        *render, variant.name(), asks_for_all(options.compare) ? &refusal : nullptr, loaded.emplace_back());
    if (!refusal.ok()) {
      refusals.push_back({variant.name(), std::string{refusal.message()}});
      loaded.pop_back();
    } else if (failed) {
      return failed;
    }
  }
  if (!loaded.empty()) return std::nullopt;
  return Failed{report(kBadScene, absl::StrCat("nothing that is compared can render ", scene))};
}

/// Tells what is being done: on a terminal in one line, else a line each.
class Steps {
 public:
  Steps(std::string scene, bool quiet)
      : scene_(std::move(scene)), quiet_(quiet), terminal_(::isatty(STDERR_FILENO)) {}
  ~Steps() { say(""); }
  void operator()(const std::string& what) const { say(absl::StrCat(scene_, ": ", what)); }

 private:
  void say(const std::string& line) const {
    if (quiet_ || (line.empty() && !terminal_)) return;
    if (terminal_) {
      std::cerr << "\r\x1b[K" << line << std::flush;
    } else {
      std::cerr << line << '\n';
    }
  }

  std::string scene_;
  bool quiet_, terminal_;
};

/// The one given for scene number `index`, or one that is made, and kept where a file is named.
absl::StatusOr<BenchReference> find_reference(const BenchOptions& options, std::size_t index,
                                              const BenchVariant& variant, const Steps& steps,
                                              std::stop_token stop) {
  const std::string file = index < options.references.size() ? options.references[index] : "";
  if (options.reference_spp == 0) return read_reference(file, options.plan.block);
  steps(absl::StrCat("reference, ", options.reference_spp, " samples a pixel"));
  absl::StatusOr<BenchReference> made =
      make_reference(variant, options.reference_spp, options.plan.threads, options.plan.block, stop);
  if (!made.ok() || file.empty()) return made;
  if (absl::Status status = write_reference(*made, options.plan.block, file); !status.ok()) return status;
  made->source += absl::StrCat(", ", file);
  return made;
}

SideScene side_scene(const BenchOptions& options, std::size_t index, const BenchSceneResult& result,
                     const BenchReference& reference) {
  SideScene scene{
      .file = options.scenes[index], .own = {}, .reference = reference, .peer_reference = std::nullopt};
  for (const BenchVariantResult& variant : result.variants) {
    scene.own.push_back({variant.name, variant.name.empty() ? "" : absl::StrCat("--", variant.name),
                         variant.spec.view().seed()});
  }
  if (!options.sides.peer_references.empty()) scene.peer_reference = options.sides.peer_references[index];
  scene.reference_spp = options.reference_spp;
  return scene;
}

absl::StatusOr<BenchSceneResult> measure_scene(const BenchOptions& options, std::size_t index,
                                               std::vector<LoadedVariant>& loaded, std::stop_token stop) {
  std::vector<BenchVariant> variants;
  for (LoadedVariant& one : loaded) variants.push_back(std::move(one.variant));
  BenchSceneResult result;
  result.name = variants.front().spec.farm().name();
  const Steps steps(result.name, options.render.quiet);
  absl::StatusOr<BenchReference> reference = find_reference(options, index, variants.front(), steps, stop);
  if (!reference.ok()) return reference.status();
  result.reference = reference->source;
  result.noise = reference->noise;
  result.block = options.plan.block;
  absl::StatusOr<std::vector<BenchVariantResult>> measured = measure_variants(
      variants, *reference, options.plan, [&](const std::string& what) { steps(what); }, stop);
  if (!measured.ok()) return measured.status();
  result.variants = *std::move(measured);
  if (!options.sides.any()) return result;
  absl::StatusOr<std::vector<WholeResult>> whole = measure_sides(
      options.sides, side_scene(options, index, result, *reference), options.plan,
      [&](const std::string& what) { steps(what); }, stop);
  if (!whole.ok()) return whole.status();
  result.whole = *std::move(whole);
  return result;
}

absl::Status check(BenchOptions& options) {
  std::ranges::sort(options.plan.spp);
  options.plan.spp.erase(std::unique(options.plan.spp.begin(), options.plan.spp.end()),
                         options.plan.spp.end());
  if (options.reference_spp == 0 && options.references.empty()) {
    return absl::InvalidArgumentError("errors need a reference: --reference FILE.exr, or --make-reference N");
  }
  if (!options.references.empty() && options.references.size() != options.scenes.size()) {
    return absl::InvalidArgumentError(absl::StrCat("there are ", options.scenes.size(), " scenes and ",
                                                   options.references.size(),
                                                   " references; one for each is needed"));
  }
  if (!options.sides.peer_references.empty() && options.sides.peer_references.size() != options.scenes.size())
    return absl::InvalidArgumentError("--peer-reference: one for each scene is needed");
  if (absl::Status status = check_peers(options.sides); !status.ok()) return status;
  for (const std::string& file : {options.json, options.plot, options.bias_plot}) {
    if (file.empty()) continue;
    if (absl::Status status = check_writable(file); !status.ok()) return status;
  }
  for (const std::string& file : {options.plot, options.bias_plot}) {
    if (file.empty()) continue;
    if (absl::Status status = check_plot_path(file); !status.ok()) return status;
  }
  return absl::OkStatus();
}

int write_files(const BenchOptions& options, const std::vector<BenchSceneResult>& results,
                const Machine& machine) {
  absl::Status status;
  if (!options.json.empty())
    status = replace_file_with(options.json, to_json(results, options.plan, machine));
  if (status.ok() && !options.plot.empty()) status = write_plot(to_plot(results, options.plan), options.plot);
  if (status.ok() && !options.bias_plot.empty())
    status = write_plot(to_bias_plot(results, options.plan), options.bias_plot);
  return status.ok() ? kDone : report(kIncomplete, std::string{status.message()});
}

int run(BenchOptions options, Interrupt& interrupt) {
  if (const absl::Status status = check(options); !status.ok())
    return report(kUsage, std::string{status.message()});
  const absl::StatusOr<std::vector<VariantOption>> variants = parse_compare(options.compare);
  if (!variants.ok()) return report(kUsage, std::string{variants.status().message()});
  if (!options.render.quiet && options.reference_spp > 0 &&
      options.reference_spp / kReferenceFactor < options.plan.spp.back()) {
    std::cerr << "warning: a reference should have " << kReferenceFactor
              << " times the samples of the images, "
              << kReferenceFactor * std::uint64_t{options.plan.spp.back()} << " here\n";
  }

  std::string earlier;
  if (!options.against.empty()) {
    absl::StatusOr<std::string> read = read_results(options.against);
    if (!read.ok()) return report(kUsage, std::string{read.status().message()});
    earlier = *std::move(read);
  }

  const MachineWatch watch;
  const std::stop_token stop = interrupt.token();
  std::vector<BenchSceneResult> results;
  for (std::size_t i = 0; i < options.scenes.size(); ++i) {
    std::vector<LoadedVariant> loaded;
    std::vector<BenchRefusal> refusals;
    if (const auto failed = load_variants(options, options.scenes[i], *variants, loaded, refusals))
      return failed->exit_code;
    absl::StatusOr<BenchSceneResult> result = measure_scene(options, i, loaded, stop);
    if (!result.ok()) return report_measuring(result.status());
    result->refusals = std::move(refusals);
    std::cout << (i > 0 ? "\n" : "") << to_text(*result) << std::flush;
    if (!options.render.quiet && reference_too_noisy(*result)) {
      std::cerr << "warning: " << result->name
                << ": the reference has more than half of the error; more samples in it "
                << "would make the figures true\n";
    }
    results.push_back(*std::move(result));
  }
  const Machine machine = watch.machine();
  std::cout << "\nmachine: " << to_text(machine) << '\n';
  if (!earlier.empty()) {
    const absl::StatusOr<BenchChanges> changes = changes_since(earlier, results, machine);
    if (!changes.ok()) return report(kUsage, absl::StrCat(options.against, ": ", changes.status().message()));
    std::cout << to_text(*changes);
  }
  std::cout << std::flush;
  return write_files(options, results, machine);
}

/// Options that are not those of `render`, or that each of its processes gets another value of.
std::vector<std::string> own_options() {
  return {"--reference", "--make-reference", "--spp",     "--seeds",
          "--compare",   "--threads",        "--block",   "--whole",
          "--peer",      "--peer-reference", "--against", "--json",
          "--plot",      "--plot-bias",      "--quiet",   "--seed"};
}

}  // namespace

void add_bench_command(CommandLine& line) {
  auto options = std::make_shared<BenchOptions>();
  Command command = line.add_command("bench", "Measure run time against error, in this process");
  command.add("SCENE", options->scenes, "scene files").required();
  command.group("Measurement");
  command.add("--reference", options->references, "what the images are held against, one for each scene")
      .separated_by_commas()
      .type_name("FILE.exr,...");
  command
      .add("--make-reference", options->reference_spp,
           "render it first, with N samples a pixel, to --reference")
      .in_range(2, wire::kMaxSamplesPerPixel);
  command.add("--spp", options->plan.spp, "samples a pixel")
      .separated_by_commas()
      .in_range(1, wire::kMaxSamplesPerPixel)
      .with_default();
  command.add("--seeds", options->plan.seeds, "images for each number of samples")
      .in_range(1, 1000)
      .with_default();
  command
      .add(
          "--compare", options->compare,
          "render with each value of an option in turn, and say which wins; integrator=all, accelerator=all: "
          "with all that can render the scene")
      .type_name("OPTION=A,B");
  command.add("--threads", options->plan.threads, "tiles rendered at once").in_range(1, 1024).with_default();
  command
      .add("--block", options->plan.block,
           "side in pixels of the blocks whose means have an error of their own")
      .in_range(1, 4096)
      .with_default();
  command.add_flag("--whole", options->sides.whole,
                   "measure whole processes as well, from the command to the file");
  command
      .add("--peer", options->sides.peers,
           "another program, a shell's command line with {scene}, {spp} and {out} (and {seed}, {threads}) "
           "that "
           "takes turns with whole processes of this one")
      .type_name("COMMAND");
  command
      .add("--peer-reference", options->sides.peer_references,
           "what peers' images are held against; absent: what --make-reference makes each of them render, or "
           "--reference")
      .separated_by_commas()
      .type_name("FILE.exr,...");
  command.add("--against", options->against, "compare with the figures of an earlier run's --json")
      .type_name("FILE.json");
  command.group("Output");
  command.add("--json", options->json, "write all figures").type_name("FILE.json");
  command.add("--plot", options->plot, "draw error over time").type_name("FILE.png|svg");
  command.add("--plot-bias", options->bias_plot, "draw bias and variance over time")
      .type_name("FILE.png|svg");
  command.add_flag("--quiet", options->render.quiet, "no progress, no warnings");
  define_job_options(command, options->render, false);
  command.option("--isa").one_of(local_isas());
  command.example("tessera bench scene.pbrt --make-reference 4096 --reference ref.exr");
  command.example("tessera bench box.pbrt --reference ref.exr --compare filter=box,gaussian");
  command.does([options, command](Interrupt& interrupt) {
    std::vector<std::string> but_for = own_options();
    but_for.push_back(absl::StrCat("--", options->compare.substr(0, options->compare.find('='))));
    options->sides.job_words = command.given(but_for);
    return run(*options, interrupt);
  });
}

}  // namespace tessera::client
