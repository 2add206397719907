#include "command/render_options.h"

#include <malloc.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <map>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/cpu_time.h"
#include "command/exit_code.h"
#include "command/report/output.h"
#include "command/report/phase.h"
#include "import/import.h"
#include "wire/algorithm.h"
#include "wire/enum_words.h"
#include "wire/limits.h"
#include "wire/mesh_blob.h"
#include "wire/scene_numbers.h"

namespace tessera::client {
namespace {

/// An option whose text `parse` turns into a value.
template <class Value, class Parse>
Option add_parsed(options::Command& command, const char* name, std::optional<Value>& value, Parse parse,
                  const char* description) {
  const auto read = [&value, parse](const std::string& text) {
    absl::StatusOr<Value> parsed = parse(text);
    if (!parsed.ok()) return parsed.status();
    value = *std::move(parsed);
    return absl::OkStatus();
  };
  return command.add_read_by(name, read, description);
}

/// An option whose value is a word for one of an enum's (wire/enum_words.h).
template <class Enum>
Option add_word(options::Command& command, const char* name, Enum& value, const char* description) {
  const auto read = [&value](const std::string& text) {
    const absl::StatusOr<Enum> known = wire::value_of<Enum>(text);
    if (known.ok()) value = *known;
    return known.status();
  };
  return command.add_read_by(name, read, description).type_name("NAME");
}

absl::StatusOr<v1::PixelFilter::Kind> parse_filter(const std::string& word) {
  const absl::StatusOr<int> kind = wire::number_of(*v1::PixelFilter::Kind_descriptor(), word, "pixel filter");
  if (!kind.ok()) return kind.status();
  return static_cast<v1::PixelFilter::Kind>(*kind);
}

std::string check_integrator(const std::string& name) {
  return std::string{wire::check_algorithm_name(name).message()};
}

std::vector<options::Choice> integrators() {
  std::vector<options::Choice> choices;
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms())
    choices.push_back({algorithm.name, wire::description_of(algorithm)});
  return choices;
}

std::string check_define(const std::string& text) {
  const std::size_t equals = text.find('=');
  return equals == std::string::npos || equals == 0 ? "expected NAME=VALUE" : "";
}

/// Name of the job for people: the scene's own name, which is the file's where it has none; of
/// "kitchen/scene.pbrt" or "kitchen/scene-small.pbrt", the usual forms, the folder's.
std::string name_of(const std::string& file, const ImportedScene& imported) {
  const std::filesystem::path path = std::filesystem::absolute(file);
  if (!imported.scene.name().empty() && imported.scene.name() != path.stem()) return imported.scene.name();
  return (path.stem().string().starts_with("scene") ? path.parent_path().filename() : path.stem()).string();
}

void define_cache_options(options::Command& command, CacheWishes& cache) {
  command.group("Irradiance cache");
  command
      .add("--cache-error", cache.error,
           "largest error of a record where it is used, as Ward estimates it (0.3 unless given)")
      .in_range(wire::kLeastCacheError, wire::kMostCacheError);
  command.add("--cache-samples", cache.samples, "rays of a record (1024 unless given)")
      .in_range(wire::kLeastCacheSamples, wire::kMostCacheSamples);
  add_parsed(command, "--cache-reach", cache.reach, parse_reach,
             "how far records reach, in widths of a pixel (3,32 unless given)")
      .type_name("MIN,MAX");
  command.add_flag("--cache-view", cache.view, "show a red point at each record");
}

ImportOptions import_options(const RenderOptions& options) {
  ImportOptions result;
  result.threads = options.threads;
  for (const std::string& define : options.defines) {
    const std::size_t equals = define.find('=');
    result.defines[define.substr(0, equals)] = define.substr(equals + 1);
  }
  return result;
}

}  // namespace

void define_render_options(options::Command& command, RenderOptions& options) {
  command.add("SCENE", options.scene, "the scene: .pbrt, .xml (Mitsuba), .textproto or .tsb").required();
  command.group("Image");
  command.add("-o,--output", options.output, "the image: .exr (linear) or .png (tone-mapped)")
      .type_name("FILE");
  command.add_flag("--half", options.exr.half, "16-bit EXR");
  command.add_flag("--multipart", options.exr.multipart, "EXR with a part for each layer");
  command.group("Quality");
  command.add("--spp", options.job.spp, "samples a pixel").in_range(1, wire::kMaxSamplesPerPixel);
  define_job_options(command, options);
  command.group("Output");
  command.add("--stats", options.stats, "write run time and counts to this file").type_name("FILE.json");
  command.add_flag("--quiet", options.quiet, "no progress, no warnings");
}

void define_radiosity_options(options::Command& command, RadiosityWishes& radiosity) {
  command.group("Radiosity");
  command
      .add("--radiosity-error", radiosity.error_bound,
           "error of a link's light, over the mean irradiance (0.01 unless given)")
      .in_range(1e-6, 1)
      .type_name("X");
  command
      .add("--smallest-patch", radiosity.smallest_area,
           "area, scene units squared, below which patches are not split (usually 1/50,000 of all surfaces)")
      .in_range(0, 1e30)
      .type_name("AREA");
  command
      .add("--radiosity-residual", radiosity.residual,
           "power that the last sweep moves, over all power (0.0001 unless given)")
      .in_range(1e-12, 1)
      .type_name("X");
  add_parsed(command, "--final-gather", radiosity.final_gather, parse_switch,
             "on: the patches light what is seen; off: they are what is seen")
      .type_name("on|off");
  command.add_flag("--ignore-non-diffuse", radiosity.ignore_non_diffuse,
                   "leave out of materials what is not diffuse");
  add_parsed(command, "--memory-limit", radiosity.memory_limit, parse_bytes,
             "memory for patches and links (4G unless given)")
      .type_name("SIZE");
}

void define_job_options(options::Command& command, RenderOptions& options) {
  JobSettings& job = options.job;
  command.group("Quality");
  command
      .add("--noise", job.noise,
           "target for the relative error of a pixel, with --spp as the upper bound; 0: no target")
      .type_name("ERROR");
  command.add("--max-depth", job.max_depth, "scattering events on a path; 0 shows emitters only")
      .in_range(0, wire::kMaxDepth);
  command
      .add("--integrator", job.integrator,
           "how light is found; more samples lead to the right picture with what is unbiased or consistent")
      .type_name("NAME")
      .listing(integrators())
      .checked_by(check_integrator);
  command
      .add("--ao-distance", job.occlusion_distance,
           "ao: how far things hide the sky, in units of the scene; 0: however far")
      .in_range(0, wire::kLargestSceneNumber);
  add_word(command, "--sampler", job.sampler, "sobol or independent");
  add_parsed(command, "--seed", job.seed, parse_seed, "seed of the sampler").type_name("N");
  add_parsed(command, "--filter", job.filter, parse_filter,
             "pixel filter: box, triangle, gaussian, mitchell or lanczos")
      .type_name("NAME");
  command.group("Film");
  add_parsed(command, "--resolution", job.resolution, parse_resolution, "size of the image").type_name("WxH");
  add_parsed(command, "--crop", job.crop, parse_crop, "pixels to render").type_name("x0,y0,x1,y1");
  const auto add_aov = [&aovs = job.aovs, &layers = job.layers](const std::string& word) {
    if (const absl::StatusOr<bool> taken = take_layer_word(word, layers); !taken.ok() || *taken)
      return taken.status();
    const absl::StatusOr<v1::AOV> aov = wire::value_of<v1::AOV>(word);
    if (aov.ok()) aovs.push_back(*aov);
    return aov.status();
  };
  command
      .add_list_read_by(
          "--aov", add_aov, [&aovs = job.aovs] { aovs.clear(); },
          "further channels: variance, albedo, normal, depth, samples, alpha, id; layers: bounce0..bounceN, "
          "lights, emission")
      .separated_by_commas()
      .type_name("NAME,...");
  add_parsed(command, "--layers", job.layers.layers, layers::parse_layers,
             "light of some paths as channels NAME.R, .G, .B: caustics=LS+DE (docs/layers.md)")
      .type_name("NAME=EXPRESSION,...");
  command.group("Preview");
  add_word(command, "--shadows", job.shadows,
           "shadows of --integrator preview: pcss (as soft as the lamp is large), pcf, hard or none");
  command.add("--ambient", job.ambient, "factor of its ambient light; 1 unless given")
      .in_range(0, wire::kMaxAmbient);
  command.group("Computation");
  add_word(command, "--intersection", job.intersection,
           "ray-triangle tests: auto (robust where the geometry asks for it), fast or robust");
  add_word(command, "--direct-light", job.direct_light,
           "estimator of direct light: mis (light and BSDF sampling) or bsdf (no light sampling)");
  add_word(command, "--light-selection", job.light_selection,
           "probabilities of lights: auto, tree, mixed, power or uniform");
  add_word(command, "--traversal", job.traversal, "trace rays by packet or single");
  command.add("--tile", job.tile_size, "side of a tile, pixels")
      .in_range(1, wire::kMaxTileSize)
      .with_default();
  command.group("Photon mapping");
  command
      .add("--photon-radius", job.photon_radius,
           "radius of the first pass's estimates, in the scene's units; usually 3 pixels on what is seen")
      .in_range(wire::kMinPhotonRadius, wire::kMaxPhotonRadius)
      .type_name("R");
  command.add("--photons", job.photons, "light paths of a pass; usually the film's pixels, up to 2^20")
      .in_range(1, wire::kMaxPhotons);
  add_word(command, "--photon-map", job.photon_map,
           "progressive (a radius that shrinks) or classic (one map for all passes; biased)");
  add_word(command, "--photon-light", job.photon_light,
           "light that photons bring: indirect (lights are sampled) or all");
  command.group("Computation");
  command.add("-D", options.defines, "a parameter of the scene; may be repeated")
      .type_name("NAME=VALUE")
      .checked_by(check_define);
  command.add("--isa", job.isa, "kernels to use, on every worker").type_name("NAME");
  define_cache_options(command, job.cache);
  define_radiosity_options(command, job.radiosity);
}

absl::Status check_stats(const RenderOptions& options) {
  return options.stats.empty() ? absl::OkStatus() : check_writable(options.stats);
}

void LoadedJob::free_meshes() {
  for (SceneBlob& blob : imported.blobs) {
    if (wire::is_mesh(blob.bytes)) std::string().swap(blob.bytes);
  }
#ifdef __GLIBC__
  malloc_trim(0);  // many are small: the allocator would keep them
#endif
}

std::vector<std::string> LoadedJob::warning_lines() const {
  std::vector<std::string> lines;
  for (const Diagnostic& warning : imported.warnings) lines.push_back(to_string(warning));
  if (job != nullptr) lines.insert(lines.end(), job->warnings.begin(), job->warnings.end());
  return lines;
}

std::unique_ptr<LoadedJob> load_job(const RenderOptions& options, int& exit_code, absl::Status* refusal) {
  if (std::error_code error; !std::filesystem::exists(options.scene, error)) {
    exit_code = report(kUsage, absl::StrCat("there is no file ", options.scene));
    return nullptr;
  }
  const auto start = std::chrono::steady_clock::now();
  const std::chrono::nanoseconds cpu_start = base::process_cpu_time();
  auto loaded = std::make_unique<LoadedJob>();
  absl::StatusOr<ImportedScene> imported = [&] {
    const Phase phase{progress_mode(STDERR_FILENO, options.quiet), std::cerr, options.scene, "reading"};
    return import_scene(options.scene, import_options(options));
  }();
  if (!imported.ok()) {
    exit_code = report(kBadScene, std::string{imported.status().message()});
    return nullptr;
  }
  loaded->imported = *std::move(imported);
  const auto print_warnings = [&](const std::vector<std::string>& lines) {
    if (options.quiet) return;
    for (const std::string& line : lines) std::cerr << "warning: " << line << '\n';
  };
  print_warnings(loaded->warning_lines());
  absl::StatusOr<std::unique_ptr<PreparedJob>> job =
      prepare_job(options.job, loaded->imported, name_of(options.scene, loaded->imported));
  if (!job.ok() && refusal != nullptr) {
    *refusal = job.status();
    return nullptr;
  }
  if (!job.ok()) {
    exit_code =
        report(absl::IsOutOfRange(job.status()) ? kUsage : kBadScene, std::string{job.status().message()});
    return nullptr;
  }
  loaded->job = *std::move(job);
  print_warnings(loaded->job->warnings);
  loaded->import_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  loaded->import_cpu_seconds = base::in_seconds(base::process_cpu_time() - cpu_start);
  return loaded;
}

}  // namespace tessera::client
