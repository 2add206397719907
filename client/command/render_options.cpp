#include "command/render_options.h"

#include <malloc.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/cpu_time.h"
#include "base/nearest_name.h"
#include "command/exit_code.h"
#include "command/gltf_choice.h"
#include "command/interrupt.h"
#include "command/read_option.h"
#include "command/report/choice_text.h"
#include "command/report/exr_options.h"
#include "command/report/file_facts.h"
#include "command/report/output.h"
#include "command/report/phase.h"
#include "command/report/scene_facts.h"
#include "command/setting_options.h"
#include "expression/polynomial.h"
#include "import/import.h"
#include "import/tessera_scene/animation.h"
#include "local/local_farm.h"
#include "local/scene_check.h"
#include "wire/algorithm.h"
#include "wire/enum_words.h"
#include "wire/film_size.h"
#include "wire/limits.h"
#include "wire/mesh_blob.h"
#include "wire/packed_instances.h"
#include "wire/scene_numbers.h"
#include "wire/scene_views.h"

namespace tessera::client {
namespace {

absl::StatusOr<v1::PixelFilter::Kind> parse_filter(const std::string& word) {
  const absl::StatusOr<int> kind = wire::number_of(*v1::PixelFilter::Kind_descriptor(), word, "pixel filter");
  if (!kind.ok()) return kind.status();
  return static_cast<v1::PixelFilter::Kind>(*kind);
}

/// Whether rays can find the surface so: Sturm's chains and deflation are of polynomials.
bool is_found_by(v1::ImplicitSurface::Roots roots, const v1::ImplicitSurface& surface) {
  if (roots != v1::ImplicitSurface::STURM && roots != v1::ImplicitSurface::NEWTON) return true;
  const auto parsed = expression::parse(surface.expression());
  return parsed.ok() && expression::expand(*parsed).has_value();
}

void set_roots(v1::ImplicitSurface::Roots roots, v1::Shape& shape) {
  if (shape.has_implicit() && is_found_by(roots, shape.implicit()))
    shape.mutable_implicit()->set_roots(roots);
}

/// Sets the method of all surfaces for which there is one, operands of combinations among them.
void set_roots(v1::ImplicitSurface::Roots roots, v1::Scene& scene) {
  const auto set = [roots](auto& shapes) {
    for (v1::Shape& shape : shapes) {
      set_roots(roots, shape);
      if (!shape.has_csg()) continue;
      for (v1::Csg::Part& part : *shape.mutable_csg()->mutable_parts()) {
        if (part.has_solid()) set_roots(roots, *part.mutable_solid());
      }
    }
  };
  set(*scene.mutable_shapes());
  for (v1::Object& object : *scene.mutable_objects()) set(*object.mutable_shapes());
}

/// Words of --aov.
std::vector<std::string> channel_words() {
  std::vector<std::string> words = wire::words_of(*v1::AOV_descriptor());
  for (const char* const layer :
       {"bounce0..bounce5", "lights", "emission", "shadow", "strategies", "unweighted-strategies"})
    words.emplace_back(layer);
  return words;
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

void define_film_options(options::Command& command, RenderOptions& options) {
  JobSettings& job = options.job;
  command.group("Quality");
  add_parsed(command, "--filter", job.filter, parse_filter, "box, triangle, gaussian, mitchell or lanczos")
      .type_name("NAME");
  const auto read_denoise = [&denoise = job.denoise](const std::string& word) {
    const absl::StatusOr<std::optional<DenoiseMethod>> method = parse_denoise_method(word);
    if (method.ok()) denoise = *method;
    return method.status();
  };
  command.add_read_by("--denoise", read_denoise, "denoiser: regression, statistical, oidn or off")
      .type_name("NAME")
      .completing({"regression", "statistical", "oidn", "off"});
  command.group("Image");
  add_parsed(command, "--resolution", job.resolution, parse_resolution, "size of the image").type_name("WxH");
  add_parsed(command, "--crop", job.crop, parse_crop, "pixels to render").type_name("x0,y0,x1,y1");
  command
      .add("--overscan", job.overscan,
           "pixels to render on each side beyond the image; the EXR's data window has them")
      .in_range(0, wire::kMaxFilmSide / 4)
      .as_setting();
  command.add("--view", job.view, "one view of a scene that has several, alone: the first is 0")
      .in_range(0, wire::kMaxUnitsPerJob)
      .as_setting();
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
          "further channels, or layers of light: albedo, normal, depth, lights ... (tessera settings aov)")
      .separated_by_commas()
      .type_name("NAME,...")
      .completing(channel_words());
  add_parsed(command, "--layers", job.layers.layers, layers::parse_layers,
             "light of some paths as channels NAME.R, .G, .B: caustics=LS+DE (docs/layers.md)")
      .type_name("NAME=EXPRESSION,...");
  command.group("Computation");
  command
      .add("--tile", job.tile_size,
           "side of a tile, pixels (default: 32; 128 where pixels share light or samples)")
      .in_range(1, wire::kMaxTileSize)
      .as_setting();
  command.add("-D", options.defines, "a parameter of the scene; may be repeated")
      .type_name("NAME=VALUE")
      .checked_by(check_define);
  add_parsed(
      command, "--roots", options.roots, wire::value_of<v1::ImplicitSurface::Roots>,
      "search along rays for implicit surfaces, whatever the scene says: auto, sturm, interval or newton")
      .type_name("NAME")
      .as_setting();
  command.add("--isa", job.isa, "kernels to use, on every worker").type_name("NAME").as_setting();
  define_gltf_options(command, options.gltf);
  for (const char* const name : {"--camera", "--time", "--shutter", "--shutter-position", "--animation",
                                 "--variant", "--default-light"})
    command.option(name).as_setting();
}

}  // namespace

ImportOptions import_options(const RenderOptions& options) {
  ImportOptions result;
  result.threads = options.threads;
  for (const std::string& define : options.defines) {
    const std::size_t equals = define.find('=');
    result.defines[define.substr(0, equals)] = define.substr(equals + 1);
  }
  result.gltf = options.gltf;
  return result;
}

void define_render_options(options::Command& command, RenderOptions& options) {
  command.add("SCENE", options.scene, absl::StrCat("the scene: ", kSceneFiles).c_str()).required();
  command.group("Image");
  command.add("-o,--output", options.output, "the image: .exr (linear) or .png (tone-mapped)")
      .type_name("FILE");
  define_job_options(command, options);
  command.group("Image");
  define_exr_options(command, options.exr);
  define_multiview(command, options.exr).as_setting();
  for (const char* const name :
       {"--half-layers", "--multipart", "--exr-compression", "--channel-names", "--exr-tiles",
        "--frame-memory", "--crypto-ranks", "--attribute", "--exr-mipmaps"})
    command.option(name).as_setting();
  command.group("Output");
  command.add("--stats", options.stats, "write run time and counts to this file").type_name("FILE.json");
  command.add_flag("--quiet", options.quiet, "no progress, no warnings");
}

void define_job_options(options::Command& command, RenderOptions& options, bool with_samples) {
  define_settings(command, options.job.settings,
                  [&](const std::string& name) { return with_samples || name != "spp"; });
  define_film_options(command, options);
}

absl::Status check_stats(const RenderOptions& options) {
  return options.stats.empty() ? absl::OkStatus() : check_writable(options.stats);
}

void LoadedJob::free_blobs() {
  job->blobs.clear();
  imported.blobs.clear();
  std::string().swap(job->scene.bytes);
}

void LoadedJob::describe(const RenderOptions& options, FollowedJob& followed) const {
  for (std::uint32_t view = 0; view < followed.images.size(); ++view) {
    Image& image = followed.images[view].image;
    add_scene_facts(imported.scene, wire::camera_of(imported.scene, view), job->spec, image);
    if (options.frame) add_frame_facts(*options.frame, rate, shutter, image);
  }
}

std::vector<MatteList> LoadedJob::mattes(const RenderOptions& options) const {
  return mattes_of(imported.scene, options.exr.matte_ranks);
}

void LoadedJob::free_meshes() {
  for (SceneBlob& blob : imported.blobs) {
    if (wire::is_mesh(blob.bytes) || wire::is_matrices(blob.bytes)) std::string().swap(blob.bytes);
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

Rational frame_rate(const RenderOptions& options, const v1::Scene& scene) {
  if (options.frames.rate) return *options.frames.rate;
  const double own = scene.animation().frames_per_second();
  if (!(own > 0)) return {24, 1};
  // Whole numbers as they are, others in thousandths.
  return own == std::floor(own) ? Rational{static_cast<std::int32_t>(own), 1}
                                : Rational{static_cast<std::int32_t>(std::lround(own * 1000)), 1000};
}

namespace {

/// The job as the options and the scene ask for it.
absl::StatusOr<ChosenJob> prepare(const RenderOptions& options, const ImportedScene& imported,
                                  const ChoiceOptions* choice, double read_cpu_seconds) {
  const std::string name = name_of(options.scene, imported);
  if (!asks_for_choice(options.job, imported.scene)) {
    absl::StatusOr<std::unique_ptr<PreparedJob>> job = prepare_job(options.job, imported, name);
    if (!job.ok()) return job.status();
    return ChosenJob{*std::move(job)};
  }
  if (choice == nullptr) {
    return absl::OutOfRangeError(
        "integrator 'auto' is none itself, but a choice that render and submit make: here it has to be "
        "named");
  }
  ChoiceOptions own = *choice;
  own.scene_read_cpu_seconds = read_cpu_seconds;
  const Phase phase{progress_mode(STDERR_FILENO, options.quiet), std::cerr, options.scene,
                    "choosing the integrator"};
  return choose_job(options.job, imported, name, own);
}

}  // namespace

void set_local_isa(v1::JobSpec& spec) {
  const std::vector<std::string> isas = local_isas();
  if (spec.farm().isa().empty() && !isas.empty()) spec.mutable_farm()->set_isa(isas.front());
}

absl::StatusOr<std::unique_ptr<BenchScene>> build_scene(LoadedJob& loaded, const RenderOptions& options) {
  const Interrupt::AtOnce at_once;
  set_local_isa(loaded.job->spec);
  absl::StatusOr<std::unique_ptr<BenchScene>> scene =
      BenchScene::load(loaded.job->spec, loaded.job->blobs, options.threads);
  if (!scene.ok() || options.quiet) return scene;
  for (const std::string& warning : (*scene)->warnings()) std::cerr << "warning: " << warning << '\n';
  return scene;
}

std::unique_ptr<LoadedJob> load_job(const RenderOptions& options, int& exit_code, absl::Status* refusal,
                                    const ChoiceOptions* choice) {
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
  if (options.origin && !*options.origin) *options.origin = wire::camera_place(loaded->imported.scene);
  loaded->rate = frame_rate(options, loaded->imported.scene);
  loaded->shutter = loaded->imported.scene.animation().shutter();
  if (options.frames.scene_rate) *options.frames.scene_rate = loaded->rate;
  if (options.frame) {
    if (const absl::Status status =
            pose_at_frame(static_cast<double>(*options.frame), loaded->imported.scene);
        !status.ok()) {
      exit_code = report(kBadScene, absl::StrCat(options.scene, ": ", std::string(status.message())));
      return nullptr;
    }
  }
  loaded->imported.scene.clear_animation();
  if (absl::Status status = resolve_rig(loaded->imported); !status.ok()) {
    exit_code = report(kBadScene, std::string(status.message()));
    return nullptr;
  }
  if (options.origin && !loaded->imported.scene.has_render_origin())
    *loaded->imported.scene.mutable_render_origin() = **options.origin;
  if (options.job.view) {
    const std::uint32_t view = *options.job.view;
    v1::Scene& scene = loaded->imported.scene;
    if (view > 0 && view <= static_cast<std::uint32_t>(scene.views_size())) {
      // Its faults are told where it stands in the file.
      auto place = loaded->imported.places.extract(&wire::camera_of(scene, view));
      if (!place.empty()) loaded->imported.places[&scene.camera()] = std::move(place.mapped());
    }
    if (const absl::Status status = wire::keep_view(view, scene); !status.ok()) {
      exit_code = report(kUsage, absl::StrCat("--view: ", std::string(status.message())));
      return nullptr;
    }
  }
  if (options.roots) set_roots(*options.roots, loaded->imported.scene);
  const auto print_warnings = [&](const std::vector<std::string>& lines) {
    if (options.quiet) return;
    for (const std::string& line : lines) std::cerr << "warning: " << line << '\n';
  };
  print_warnings(loaded->warning_lines());
  const auto refuse = [&](const std::vector<SceneFault>& faults) {
    exit_code = report(kBadScene, std::string{status_of(faults, loaded->imported).message()});
    return nullptr;
  };
  // Choosing an integrator renders the scene.
  const bool chooses = asks_for_choice(options.job, loaded->imported.scene);
  std::vector<SceneFault> faults;
  if (chooses) faults = find_scene_faults(loaded->imported, nullptr);
  if (!faults.empty()) return refuse(faults);
  absl::StatusOr<ChosenJob> job =
      prepare(options, loaded->imported, choice, base::in_seconds(base::process_cpu_time() - cpu_start));
  if (!job.ok() && refusal != nullptr) {
    *refusal = job.status();
    return nullptr;
  }
  if (!job.ok()) {
    const ExitCode code = absl::IsCancelled(job.status())    ? kInterrupted
                          : absl::IsOutOfRange(job.status()) ? kUsage
                                                             : kBadScene;
    exit_code = report(code, std::string{job.status().message()});
    return nullptr;
  }
  if (!chooses) faults = find_scene_faults(loaded->imported, &job->job->spec);
  const bool sound = faults.empty();
  for (SceneFault& fault : find_job_faults(loaded->imported, job->job->spec))
    faults.push_back(std::move(fault));
  if (!faults.empty()) {
    if (!sound || refusal == nullptr) return refuse(faults);
    *refusal = status_of(faults, loaded->imported);
    return nullptr;
  }
  loaded->imported.places.clear();
  loaded->job = std::move(job->job);
  if (options.frame) {
    loaded->job->spec.mutable_farm()->set_frame(*options.frame);
    loaded->job->spec.mutable_farm()->set_group(options.group);
  }
  loaded->built = std::move(job->built);
  print_warnings(loaded->job->warnings);
  if (const std::string chosen = choice_text(loaded->job->spec); !options.quiet && !chosen.empty())
    std::cerr << chosen << '\n';
  loaded->import_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  loaded->import_cpu_seconds = base::in_seconds(base::process_cpu_time() - cpu_start) -
                               loaded->job->spec.farm().auto_choice().pilot_seconds();
  return loaded;
}

}  // namespace tessera::client
